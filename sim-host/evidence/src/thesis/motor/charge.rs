//! Time in which charge spreads over an electrode (B.6).
//!
//! A tab is a film with resistance along it and capacitance through the sheet. Fed at one end, its
//! far end follows as `V(L)/V(0) = 1/cosh(sqrt(i w R C))`.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use super::electrodes::Pattern;
use super::sheet::{PERMITTIVITY, SIDE_M, THICKNESS_M, VACUUM_F_PER_M};

/// Resistivity of nickel in bulk at 20 C, Ohm m (*CRC Handbook of Chemistry and Physics*: 6.93 at
/// 20 C).
const NICKEL_OHM_M: f64 = 6.93e-8;
/// Thickness of the film, m: 1000 angstroms (B.4.1).
const FILM_M: f64 = 100e-9;
/// Speed of light, m/s.
const LIGHT_M_PER_S: f64 = 299_792_458.0;

/// Electrode that is fed along one edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Electrode {
    /// Length from the fed edge, m.
    pub length_m: f64,
    /// Width of the electrode, m.
    pub width_m: f64,
    /// Resistivity over that of bulk nickel; that of a thin sputtered film is higher.
    pub resistivity: f64,
}

impl Electrode {
    /// Returns a tab, fed at its end.
    pub fn tab(resistivity: f64) -> Electrode {
        Electrode { length_m: SIDE_M, width_m: Pattern::PRINTED.width_m, resistivity }
    }

    /// Returns the whole face, fed along an edge.
    pub fn whole(resistivity: f64) -> Electrode {
        Electrode { length_m: SIDE_M, width_m: SIDE_M, resistivity }
    }

    /// Returns the resistance from end to end, Ohm.
    pub fn ohm(&self) -> f64 {
        self.resistivity * NICKEL_OHM_M * self.length_m / (FILM_M * self.width_m)
    }

    /// Returns the capacitance through the sheet, F.
    pub fn farad(&self) -> f64 {
        VACUUM_F_PER_M * PERMITTIVITY * self.length_m * self.width_m / THICKNESS_M
    }

    /// Returns the voltage at the far end over that at the fed end.
    pub fn far_end(&self, frequency_hz: f64) -> Complex64 {
        let root = Complex64::new(0.0, TAU * frequency_hz * self.ohm() * self.farad()).sqrt();
        1.0 / root.cosh()
    }

    /// Returns the phase lag of the far end, degrees.
    pub fn lag_deg(&self, frequency_hz: f64) -> f64 {
        -self.far_end(frequency_hz).arg().to_degrees()
    }
}

/// Returns the travel time of light through the ceramic along the sheet, s.
pub fn travel_s() -> f64 {
    SIDE_M * PERMITTIVITY.sqrt() / LIGHT_M_PER_S
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with a ladder of resistors and capacitors, computed from its open end.
    #[test]
    fn the_far_end_is_that_of_a_ladder() {
        let electrode = Electrode::tab(30.0);
        let rungs = 2000;
        let (r, c) = (electrode.ohm() / f64::from(rungs), electrode.farad() / f64::from(rungs));
        let omega = TAU * 40e3;
        let (mut voltage, mut current) = (Complex64::new(1.0, 0.0), Complex64::default());
        for _ in 0..rungs {
            current += Complex64::new(0.0, omega * c) * voltage;
            voltage += current * r;
        }
        let ladder = 1.0 / voltage;
        // Each section is a 2000th of the line.
        assert!((ladder - electrode.far_end(40e3)).norm() < 1e-3, "{ladder} {}", electrode.far_end(40e3));
    }

    #[test]
    fn a_short_line_lags_by_half_of_rc() {
        let electrode = Electrode::tab(1.0);
        let expected = (0.5 * TAU * 40e3 * electrode.ohm() * electrode.farad()).to_degrees();
        assert!((electrode.lag_deg(40e3) / expected - 1.0).abs() < 1e-3, "{}", electrode.lag_deg(40e3));
        // By hand: 13 squares of 0.69 ohm, and 6.3 nF.
        assert!((electrode.ohm() - 9.0).abs() < 0.05 && (1e9 * electrode.farad() - 6.33).abs() < 0.01);
    }
}
