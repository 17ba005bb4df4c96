//! What the observer says.

use super::{AHEAD_BLOCKS, Observer};
use crate::seam::compare::larger;
use crate::seam::phasor::Phasor;

/// `2 sinh(x / 2) = x (1 + x^2 / 24)`, to 0.3 % at 1.5.
const BY_SQUARE: f32 = 1.0 / 24.0;
/// What a quality factor measured at the resonance is known to at best, relative: the steps settle to 2 %.
const AT_BEST: f32 = 5e-3;
/// A quality factor that differs from what was known by more of its standard deviations than this counts.
const SURPRISE: f32 = 3.0;

/// Variances of an observer's unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    /// Of the pole, both parts, rad².
    pole: f32,
    /// Of the inductance, relative.
    pub(crate) strength: f32,
    hz_per_radian: f32,
}

impl Spread {
    /// Standard deviation of the resonance, Hz.
    pub(crate) fn deviation_hz(&self) -> f32 {
        libm::sqrtf(0.5 * self.pole) * self.hz_per_radian
    }
}

impl Observer {
    /// The resonance, as an offset from the nominal frequency, Hz.
    pub fn offset_hz(&self) -> f32 {
        self.pole.im * self.hz_per_radian
    }

    /// Where the resonance will be when the block plays that is decided on now, as an offset from the nominal frequency, Hz.
    pub(crate) fn ahead_hz(&self) -> f32 {
        (self.pole.im + AHEAD_BLOCKS * self.rate) * self.hz_per_radian
    }

    /// Standard deviation of the resonance, Hz.
    pub fn deviation_hz(&self) -> f32 {
        self.spread().deviation_hz()
    }

    /// How well it knows what it knows, of which deviations are the roots.
    pub(crate) fn spread(&self) -> Spread {
        Spread { pole: self.covariance.pole, strength: self.covariance.strength, hz_per_radian: self.hz_per_radian }
    }

    /// Whether the deviation of the resonance is below `hz`.
    #[inline]
    pub(crate) fn is_within(&self, hz: f32) -> bool {
        self.is_within_radians(self.radian_per_hz * hz)
    }

    /// Whether the deviation is below `phase` radians of the resonance's own phase, or below `hz`, if that is more.
    #[inline]
    pub(crate) fn is_as_good_as(&self, phase: f32, hz: f32) -> bool {
        // A detuning of `alpha` turns it by 45 degrees; `-pole.re` is `alpha T`.
        self.is_within_radians(larger(-self.pole.re * phase, self.radian_per_hz * hz))
    }

    #[inline]
    fn is_within_radians(&self, bound: f32) -> bool {
        self.covariance.pole < 2.0 * bound * bound
    }

    /// Whether a motional current is above `part` of what a voltage, V, would drive in steady state: `V / Rm`, `Rm = 2 alpha Lm`.
    pub(crate) fn rings(&self, current: Phasor, part: f32, volts: f32) -> bool {
        let drop = self.pole.re * self.ohm_per_pole;
        let most = part * volts * self.strength;
        current.norm_sqr() * drop * drop > most * most
    }

    /// What the current decays by in a block: `alpha T`, as the filter has it.
    #[inline]
    pub(crate) fn decays_by(&self) -> f32 {
        -self.pole.re
    }

    /// The same of a resonance with this quality factor at the nominal frequency.
    pub(crate) fn decay_of(&self, q: f32) -> f32 {
        core::f32::consts::PI * self.nominal_hz / q * self.block_s
    }

    /// Damping `alpha`, 1/s, by the steady current. A block adds `sqrt(a) b V` to it instead of `(1 - a) / alpha`, so that what settles is `b V / (2 sinh(alpha T / 2))`: at Q 6
    /// and 87 kHz, with blocks of 32 us, the pole is 8 % low.
    pub(crate) fn damping(&self) -> f32 {
        -self.pole.re * (1.0 + BY_SQUARE * self.pole.re * self.pole.re) / self.block_s
    }

    /// Quality factor.
    pub(super) fn q(&self) -> f32 {
        core::f32::consts::PI * (self.nominal_hz + self.offset_hz()) / self.damping()
    }

    /// Takes a quality factor that was measured at the resonance, and its standard deviation. Where they differ, the strength gives way, which was seen from afar: other
    /// resonances nearby add to it there. The motional resistance stays, which the steady current shows.
    pub(crate) fn take_q(&mut self, (q, deviation): (f32, f32)) {
        let (part, relative) = (self.q() / q, deviation / q);
        let (off, variance) = (1.0 - part, relative * relative + AT_BEST * AT_BEST);
        if !(q > 0.0 && off * off > SURPRISE * SURPRISE * (variance + self.covariance.strength)) {
            return;
        }
        let x = self.pole.re;
        self.pole.re = part * x * (1.0 + BY_SQUARE * x * x) / (1.0 + BY_SQUARE * part * part * x * x);
        self.strength *= part;
        self.covariance.strength = variance;
        (self.covariance.pole_strength, self.covariance.current_strength) = (Phasor::default(), Phasor::default());
    }

    /// Estimated motional inductance, H.
    pub fn lm_h(&self) -> f32 {
        self.lm_h / self.strength.max(1e-3)
    }

    /// Standard deviation of the inductance, relative.
    #[cfg(test)]
    pub(crate) fn strength_deviation(&self) -> f32 {
        libm::sqrtf(self.covariance.strength)
    }

    /// Forgets that the resonance moves. After every block of a study this shows what the second integrator is good for.
    pub fn forget_rate(&mut self) {
        self.rate = 0.0;
    }

    /// Whether the gate has opened in the last block.
    pub(crate) fn has_opened(&self) -> bool {
        self.calm == 0
    }
}
