//! The motional current: what is left of the current when the clamped capacitance has had its share,
//! `I_m = I - Y0(f) V`, with `Y0(f) = g0 + j b0 f / f0`.
//!
//! Plain V-I phase has no zero at all once `M = 1 / (omega C0 Rm) < 2`, which is where a loaded stack works; the motional
//! phase always has one, at the series resonance. `Y0` also includes what the images of a zero-order-hold DAC add to the
//! current through C0, so it is measured in place (`crate::find::identify`) and not computed from C0.

use crate::seam::phasor::Phasor;
use crate::sense::demod::Sensed;

/// The clamped branch, and the direction of the motional admittance at resonance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motional {
    /// Admittance of the clamped branch at the nominal frequency, S.
    pub y0: Phasor,
    /// Direction of the motional admittance at the series resonance: one, turned by what the sensing chain adds
    /// (a current sampled late, an aliased image).
    pub axis: Phasor,
}

impl Motional {
    /// A lossless clamped capacitance of `c0_f` farads at `hz`, and a perfect sensing chain.
    pub fn of_capacitance(c0_f: f32, hz: f32) -> Self {
        Motional { y0: Phasor::new(0.0, core::f32::consts::TAU * hz * c0_f), axis: Phasor::new(1.0, 0.0) }
    }

    /// The motional current, A, at `relative` times the nominal frequency.
    pub fn current(&self, sensed: &Sensed, relative: f32) -> Phasor {
        let y0 = Phasor::new(self.y0.re, self.y0.im * relative);
        sensed.i - y0 * sensed.v
    }

    /// A phasor whose argument is the motional phase: zero at the series resonance, negative above it.
    pub fn phase_of(&self, motional_current: Phasor, v: Phasor) -> Phasor {
        motional_current * (v * self.axis).conj()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::phasor::argument;

    #[test]
    fn what_the_capacitance_takes_is_removed() {
        let motional = Motional::of_capacitance(300e-9, 40e3);
        let v = Phasor::new(1.0, 2.0);
        let branch = Phasor::new(0.3, -0.1) * v;
        let i = branch + Phasor::new(0.0, core::f32::consts::TAU * 41e3 * 300e-9) * v;
        let current = motional.current(&Sensed { v, i }, 41.0 / 40.0);
        assert!((current - branch).norm_sqr() < 1e-12);
        assert!(argument(motional.phase_of(current, v)).0 < 0.0);
    }
}
