//! Decomposition of a pair of modal amplitudes into two waves, one in each direction.
//!
//! With `y = q_c + i q_s`, a wave that turns the rotor forwards (it travels towards lower lanes) is
//! `A e^(-i w t)`, the other `B e^(i w t)`. At one instant
//!
//! ```text
//! A e^(-i w t) = (y + i y' / w) / 2,   B e^(i w t) = (y - i y' / w) / 2
//! ```
//!
//! exactly, if `w` is the drive frequency. That need not be the resonance; an error of one per cent
//! would look like half a per cent of backward wave. For one tone `y'' = -w^2 y`, for any
//! waves, and the equations of motion give `y''`.

use crate::motor::model::Model;
use crate::motor::participation::MODES;

/// Sums over the samples of a block, from which the frequency follows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tone {
    restored: f64,
    moved: f64,
}

/// Amplitudes of the two waves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waves {
    /// Amplitude of the wave that turns the rotor forwards, m.
    pub forward_m: f64,
    /// Amplitude of the wave that turns the rotor backwards, m.
    pub backward_m: f64,
    /// Frequency of both waves, rad/s.
    pub omega: f64,
}

impl Tone {
    /// Adds one instant: amplitudes, velocities, and the forces on the modes except their own
    /// stiffness and damping, N.
    #[inline]
    pub fn update(&mut self, model: &Model, q: [f64; MODES], s: [f64; MODES], force: [f64; MODES]) {
        for mode in 0..MODES {
            let acting = force[mode] - model.damping_n_s_per_m * s[mode] - model.stiffness_n_per_m(mode) * q[mode];
            self.restored -= acting / model.mass_kg * q[mode];
            self.moved += q[mode] * q[mode];
        }
    }

    /// Returns the waves at an instant.
    pub fn waves(&self, model: &Model, q: [f64; MODES], s: [f64; MODES]) -> Waves {
        let natural = std::f64::consts::TAU * model.series_resonance_hz;
        let measured = (self.restored / self.moved).sqrt();
        // Silence has no frequency.
        let omega = if measured.is_finite() && (measured / natural - 1.0).abs() < 0.5 { measured } else { natural };
        // y + i y' / w = (q_c - s_s / w) + i (q_s + s_c / w)
        let half = |sign: f64| 0.5 * (q[1] - sign * s[0] / omega).hypot(q[0] + sign * s[1] / omega);
        Waves { forward_m: half(1.0), backward_m: half(-1.0), omega }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::tests::stator;

    /// Two waves at a frequency one per cent off the resonance, at any phase.
    #[test]
    fn both_waves_are_found_off_resonance() {
        let model = Model::from_stator(&stator());
        let omega = std::f64::consts::TAU * 40_400.0;
        let (forward, backward) = (0.8e-6, 0.07e-6);
        for n in 0..20 {
            let t = f64::from(n) * 1.3e-6;
            let (sf, cf) = (omega * t).sin_cos();
            let (sb, cb) = (omega * t + 0.6).sin_cos();
            // y = A e^(-i w t) + B e^(i (w t + 0.6))
            let q = [-forward * sf + backward * sb, forward * cf + backward * cb];
            let s = [omega * (-forward * cf + backward * cb), omega * (-forward * sf - backward * sb)];
            let force = [0, 1]
                .map(|m| (model.stiffness_n_per_m(m) - omega * omega * model.mass_kg) * q[m] + model.damping_n_s_per_m * s[m]);
            let mut tone = Tone::default();
            tone.update(&model, q, s, force);
            let waves = tone.waves(&model, q, s);
            assert!((waves.forward_m / forward - 1.0).abs() < 1e-12 && (waves.backward_m / backward - 1.0).abs() < 1e-11);
        }
    }
}
