//! Motional current: the total current minus that of the clamped capacitance, `I_m = I - Y0(f) V`,
//! with `Y0(f) = g0 + j b0 f / f0`.
//!
//! The plain V-I phase never crosses zero once `M = 1 / (omega C0 Rm) < 2`, the range of a loaded
//! stack. The motional phase always does, at the series resonance. `Y0` also includes the current
//! through C0 from images of a zero-order-hold DAC. Therefore it is measured in place
//! (`crate::find::identify`) and not computed from C0.

use crate::seam::phasor::Phasor;
use crate::sense::demod::Sensed;

/// Clamped branch, and direction of the motional admittance at resonance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motional {
    /// Admittance of the clamped branch at the nominal frequency, S.
    pub y0: Phasor,
    /// Direction of the motional admittance at the series resonance: one, rotated by the sensing
    /// chain (a current sampled late, an aliased image).
    pub axis: Phasor,
}

impl Motional {
    /// Creates a lossless clamped capacitance of `c0_f` farads at `hz`, with an ideal sensing
    /// chain.
    pub fn of_capacitance(c0_f: f32, hz: f32) -> Self {
        Motional { y0: Phasor::new(0.0, core::f32::consts::TAU * hz * c0_f), axis: Phasor::new(1.0, 0.0) }
    }

    /// Computes the motional current, A, at `relative` times the nominal frequency.
    pub fn current(&self, sensed: &Sensed, relative: f32) -> Phasor {
        let y0 = Phasor::new(self.y0.re, self.y0.im * relative);
        sensed.i - y0 * sensed.v
    }

    /// Returns a phasor whose argument is the motional phase: zero at the series resonance,
    /// negative above.
    pub fn phase_of(&self, motional_current: Phasor, v: Phasor) -> Phasor {
        motional_current * (v * self.axis).conj()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::phasor::argument;

    #[test]
    fn current_of_the_capacitance_is_removed() {
        let motional = Motional::of_capacitance(300e-9, 40e3);
        let v = Phasor::new(1.0, 2.0);
        let branch = Phasor::new(0.3, -0.1) * v;
        let i = branch + Phasor::new(0.0, core::f32::consts::TAU * 41e3 * 300e-9) * v;
        let current = motional.current(&Sensed { v, i }, 41.0 / 40.0);
        assert!((current - branch).norm_sqr() < 1e-12);
        assert!(argument(motional.phase_of(current, v)).0 < 0.0);
    }
}
