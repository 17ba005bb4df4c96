//! The stator as two modes of one ring, and the signals measured by the controller.
//!
//! ```text
//! w(x, t) = q_s sin kx + q_c cos kx                  (thesis B.11: a travelling wave is both, a quarter period apart)
//! m q_s'' + c q_s' + K_s q_s = sum over lanes of force factor * participation * v  -  friction
//! ```
//!
//! The cosine mode has the same equation. A perfect ring has one frequency for both; in a real one
//! they differ a little (`split_hz`), which shifts the phases of the modes against each other like
//! a phase error.

use std::f64::consts::TAU;

use firmware::seam::block::MAX_LANES;

use crate::circuit::Circuit;
use crate::motor::participation::{MODES, Participation, participation};
use scene::{Direction, Stator};

/// The stator, as the parameters in the equations.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Mean of the two resonances, Hz.
    pub series_resonance_hz: f64,
    split_hz: f64,
    /// Modal mass of each mode, kg.
    pub mass_kg: f64,
    /// Damping of both modes, N s/m.
    pub damping_n_s_per_m: f64,
    /// Modal force per volt of a lane whose tabs are at crests, N/V.
    pub force_factor_n_per_v: f64,
    /// Clamped capacitance of each lane, F.
    pub c0_f: f64,
    /// Lanes whose electrodes are connected to their amplifier.
    pub connected: [bool; MAX_LANES],
    /// Participation of each lane in each mode.
    pub participation: Participation,
    /// Wave number k, rad/m.
    pub wave_number: f64,
    /// `z k`: ratio of the displacement along the surface to that of the neutral line (thesis
    /// B.13).
    pub slope: f64,
}

impl Model {
    /// Creates the stator of a scene.
    pub fn from_stator(stator: &Stator) -> Self {
        let wave_number = TAU / stator.wave_length_m;
        Model {
            series_resonance_hz: stator.series_resonance_hz,
            split_hz: stator.split_hz,
            mass_kg: stator.modal_mass_kg,
            damping_n_s_per_m: TAU * stator.series_resonance_hz * stator.modal_mass_kg / stator.q,
            force_factor_n_per_v: stator.force_factor_n_per_v,
            c0_f: stator.c0_f,
            connected: [true; MAX_LANES],
            participation: participation(stator),
            wave_number,
            slope: wave_number * stator.surface_height_m,
        }
    }

    /// Returns the resonance of a mode, Hz: that of the sine is half the split above the mean, that
    /// of the cosine half below.
    pub fn resonance_hz(&self, mode: usize) -> f64 {
        self.series_resonance_hz + if mode == 0 { 0.5 } else { -0.5 } * self.split_hz
    }

    /// Stiffness of a mode, N/m.
    pub fn stiffness_n_per_m(&self, mode: usize) -> f64 {
        (TAU * self.resonance_hz(mode)).powi(2) * self.mass_kg
    }

    /// Returns the circuit at lane 0 while all lanes play in a direction: its part of the motional
    /// current, driven by all lanes.
    pub fn circuit(&self, lanes: u8, direction: Direction) -> Circuit {
        let turn = match direction {
            Direction::Forward => 1.0,
            Direction::Reverse => -1.0,
        };
        // In phase with lane 0: a lane a quarter turn away drives its own mode, not the conductance
        // of this one.
        let in_phase = |mode: usize| -> f64 {
            let lane_0 = self.participation[0][mode];
            let played = self.participation.iter().take(lanes.into()).enumerate();
            lane_0 * played.map(|(lane, part)| part[mode] * (turn * 0.25 * TAU * lane as f64).cos()).sum::<f64>()
        };
        let together: f64 = (0..MODES).map(in_phase).sum::<f64>() * self.force_factor_n_per_v.powi(2);
        let stiffness = (TAU * self.series_resonance_hz).powi(2) * self.mass_kg;
        Circuit {
            c0_f: self.c0_f,
            cm_f: together / stiffness,
            lm_h: self.mass_kg / together,
            rm_ohm: self.damping_n_s_per_m / together,
            force_factor_n_per_v: self.force_factor_n_per_v,
        }
    }

    /// Returns the modal force of four lane voltages, N.
    #[inline]
    pub fn drive_force_n(&self, volts: &[f64; MAX_LANES]) -> [f64; MODES] {
        std::array::from_fn(|mode| {
            let sum: f64 = volts.iter().zip(&self.participation).map(|(v, part)| v * part[mode]).sum();
            self.force_factor_n_per_v * sum
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::tests::stator;

    #[test]
    fn four_lanes_show_the_resonance_and_q_of_the_modes() {
        let model = Model::from_stator(&stator());
        for direction in [Direction::Forward, Direction::Reverse] {
            let circuit = model.circuit(4, direction);
            assert!((circuit.series_resonance_hz() / 40e3 - 1.0).abs() < 1e-12);
            assert!((circuit.q() / stator().q - 1.0).abs() < 1e-12);
            // Two lanes push the mode that lane 0 measures: half the resistance of one alone.
            assert!((2.0 * circuit.rm_ohm / model.circuit(1, direction).rm_ohm - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_split_lies_about_the_middle() {
        let split = Model::from_stator(&Stator { split_hz: 100.0, ..stator() });
        assert_eq!((split.resonance_hz(0), split.resonance_hz(1)), (40_050.0, 39_950.0));
    }
}
