//! Outputs of the observer.

use super::{AHEAD_BLOCKS, Observer};
use crate::seam::compare::larger;
use crate::seam::phasor::Phasor;

/// Coefficient of `2 sinh(x / 2) = x (1 + x^2 / 24)`, accurate to 0.3 % at 1.5.
const SINH_COEFFICIENT: f32 = 1.0 / 24.0;
/// Smallest relative uncertainty of a quality factor measured at the resonance, because the steps
/// settle to 2 %.
const MIN_Q_DEVIATION_REL: f32 = 5e-3;
/// Difference of a measured quality factor from the estimate above which it is used, standard
/// deviations.
const Q_SIGMAS: f32 = 3.0;

/// Variances of an observer's unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    /// Variance of the pole, both components together, rad².
    pole: f32,
    /// Relative variance of the inductance.
    pub(crate) strength: f32,
    hz_per_radian: f32,
}

impl Spread {
    /// Returns the standard deviation of the resonance, Hz.
    pub(crate) fn deviation_hz(&self) -> f32 {
        fpu::sqrtf(0.5 * self.pole) * self.hz_per_radian
    }
}

impl Observer {
    /// Returns the resonance, as an offset from the nominal frequency, Hz.
    pub fn offset_hz(&self) -> f32 {
        self.pole.im * self.hz_per_radian
    }

    /// Returns the resonance predicted for the block that is decided now, as an offset from the
    /// nominal frequency, Hz.
    pub(crate) fn ahead_hz(&self) -> f32 {
        (self.pole.im + AHEAD_BLOCKS * self.rate) * self.hz_per_radian
    }

    /// Returns the standard deviation of the resonance, Hz.
    pub fn deviation_hz(&self) -> f32 {
        self.spread().deviation_hz()
    }

    /// Returns the variances of the unknowns.
    pub(crate) fn spread(&self) -> Spread {
        Spread { pole: self.covariance.pole, strength: self.covariance.strength, hz_per_radian: self.hz_per_radian }
    }

    /// Returns `true` if the standard deviation of the resonance is below `hz`.
    #[inline]
    pub(crate) fn is_within(&self, hz: f32) -> bool {
        self.is_within_radians(self.radian_per_hz * hz)
    }

    /// Returns `true` if the standard deviation is below `phase` radians of motional phase, or
    /// below `hz`, whichever is more.
    #[inline]
    pub(crate) fn is_within_phase(&self, phase: f32, hz: f32) -> bool {
        // A detuning of `alpha` turns the phase by 45 degrees; `-pole.re` is `alpha T`.
        self.is_within_radians(larger(-self.pole.re * phase, self.radian_per_hz * hz))
    }

    #[inline]
    fn is_within_radians(&self, bound: f32) -> bool {
        self.covariance.pole < 2.0 * bound * bound
    }

    /// Returns `true` if a motional current exceeds `part` of the steady current at `volts` through
    /// a source of `source_ohm`: `V / (Rm + Rs)`, `Rm = 2 alpha Lm`.
    pub(crate) fn rings(&self, current: Phasor, part: f32, volts: f32, source_ohm: f32) -> bool {
        let drop = (self.pole.re * self.ohm_per_pole).abs() + source_ohm * self.strength;
        let most = part * volts * self.strength;
        current.norm_sqr() * drop * drop > most * most
    }

    /// Returns the decay of the current per block, `alpha T`, as the filter uses it.
    #[inline]
    pub(crate) fn decays_by(&self) -> f32 {
        -self.pole.re
    }

    /// Returns `alpha T` of a resonance with this quality factor at the nominal frequency.
    pub(crate) fn decay_of(&self, q: f32) -> f32 {
        core::f32::consts::PI * self.nominal_hz / q * self.block_s
    }

    /// Returns the damping `alpha`, 1/s, as the steady current shows it.
    ///
    /// A block of the filter adds `sqrt(a) b V` instead of `(1 - a) / alpha`, so that the current
    /// settles at `b V / (2 sinh(alpha T / 2))`. At Q 6 and 87 kHz, with blocks of 32 us, the pole
    /// is 8 % low.
    pub(crate) fn damping(&self) -> f32 {
        -self.pole.re * (1.0 + SINH_COEFFICIENT * self.pole.re * self.pole.re) / self.block_s
    }

    /// Returns the quality factor.
    pub(super) fn q(&self) -> f32 {
        core::f32::consts::PI * (self.nominal_hz + self.offset_hz()) / self.damping()
    }

    /// Applies a quality factor measured at the resonance, with its standard deviation.
    ///
    /// If it differs from the estimate, the strength is corrected, because it was measured off
    /// resonance, where other resonances nearby add to it. The motional resistance, known from the
    /// steady current, is kept.
    pub(crate) fn take_q(&mut self, (q, deviation): (f32, f32)) {
        let (part, relative) = (self.q() / q, deviation / q);
        let (off, variance) = (1.0 - part, relative * relative + MIN_Q_DEVIATION_REL * MIN_Q_DEVIATION_REL);
        if !(q > 0.0 && off * off > Q_SIGMAS * Q_SIGMAS * (variance + self.covariance.strength)) {
            return;
        }
        let x = self.pole.re;
        self.pole.re = part * x * (1.0 + SINH_COEFFICIENT * x * x) / (1.0 + SINH_COEFFICIENT * part * part * x * x);
        self.strength *= part;
        self.covariance.strength = variance;
        (self.covariance.pole_strength, self.covariance.current_strength) = (Phasor::default(), Phasor::default());
    }

    /// Returns the estimated motional inductance, H.
    pub fn lm_h(&self) -> f32 {
        self.lm_h / self.strength.max(1e-3)
    }

    /// Returns the relative standard deviation of the inductance.
    #[cfg(test)]
    pub(crate) fn strength_deviation(&self) -> f32 {
        fpu::sqrtf(self.covariance.strength)
    }

    /// Resets the rate. Called after every block, this shows in a study the effect of the second
    /// integrator.
    pub fn forget_rate(&mut self) {
        self.rate = 0.0;
    }

    /// Returns `true` if the last block was driven and the frequency has settled since the last
    /// jump, which resets the rate.
    pub(crate) fn has_settled(&self) -> bool {
        self.rate != 0.0 && self.played.steady_v.is_some_and(|volts| volts > 0.0)
    }

    /// Returns `true` if the gate has opened in the last block.
    pub(crate) fn has_opened(&self) -> bool {
        self.calm == 0
    }
}
