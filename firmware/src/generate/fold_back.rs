//! Fold-back: the largest voltage that keeps the current within its limit, predicted from the
//! change of the current.
//!
//! ```text
//! 2 L d|I_m|/dt + R |I_m| = V  (near the resonance),   g = 1 / R = |I_m| / (V - 2 L d|I_m|/dt),   |I| = V sqrt(g^2 + B^2)  after the ring-up
//! ```
//!
//! `L` hardly changes with the load, so that the beginning of a ring-up predicts its end. An
//! excessive set point is reduced before its current is reached, and so is the drive when a load is
//! removed. Voltage and current pass through the same low-pass, of an eighth of the resonance's
//! time constant. It leaves the equation unchanged, and the noise of `R` is eight times that of the
//! current at any Q.
//!
//! Both square roots are updated by one Newton step a block. The result is never below the root;
//! while it is above, the drive is reduced slightly more.

use crate::seam::compare::{larger, smaller, up_to};
use crate::seam::phasor::Phasor;

/// Target of the current, relative to its limit.
const TARGET_CURRENT_REL: f32 = 0.95;
/// Ratio of the time constant of the resonance to that of the low-pass.
const LOW_PASS_RATIO: f32 = 8.0;
/// Part of its step response that the low-pass must have reached before it is used.
const MIN_RESPONSE_REL: f32 = 0.8;
/// Smallest voltage across `R`, relative to the drive, that is distinguished from noise. Less means
/// a ring-up that has just begun, or one that ends far beyond the limit.
const MIN_RESISTIVE_REL: f32 = 0.1;
/// Current, relative to its limit, above which such a ring-up ends far beyond the limit.
const HIGH_CURRENT_REL: f32 = 0.3;
/// Ratio of a square to the last one above which the root is computed directly, because a Newton
/// step would be a tenth off.
const MAX_NEWTON_RATIO: f32 = 2.0;

/// Fold-back of the current.
#[derive(Clone, Debug)]
pub(crate) struct FoldBack {
    limit_a: f32,
    /// `2 L` divided by the length of a block, ohm.
    ohm: f32,
    /// Gain of the low-pass a block; zero before a transducer is known.
    gain: f32,
    /// Motional current by Newton steps, A.
    amperes: f32,
    /// Admittance by Newton steps, S.
    siemens: f32,
    /// Voltage after the low-pass, V.
    volts: f32,
    /// Motional current after the low-pass, A.
    current: f32,
    /// Part of its step response that the low-pass has reached; negative before its first block.
    response: f32,
    /// Largest voltage, V.
    ceiling: f32,
}

impl FoldBack {
    /// Creates a fold-back at this current limit, A.
    pub(crate) fn build(limit_a: f32) -> Self {
        FoldBack {
            limit_a,
            ohm: 0.0,
            gain: 0.0,
            amperes: 0.0,
            siemens: 0.0,
            volts: 0.0,
            current: 0.0,
            response: -1.0,
            ceiling: f32::INFINITY,
        }
    }

    /// Begins with an inductance, H, the length of a block, s, and its ratio to the time constant.
    pub(crate) fn begin(&mut self, lm_h: f32, block_s: f32, lag: f32) {
        *self = FoldBack { ohm: 2.0 * lm_h / block_s, gain: smaller(LOW_PASS_RATIO * lag, 1.0), ..FoldBack::build(self.limit_a) };
    }

    /// Returns the current limit, A.
    pub(crate) fn most_amperes(&self) -> f32 {
        self.limit_a
    }

    /// Returns the largest voltage, V.
    pub(crate) fn ceiling(&self) -> f32 {
        self.ceiling
    }

    /// Restarts the low-pass after a block that is not of constant voltage: an edge, or silence.
    pub(crate) fn interrupt(&mut self) {
        self.response = -1.0;
    }

    /// Processes a block of constant voltage, V: its motional current, A, and the susceptance of
    /// the clamped branch, S.
    #[inline(never)]
    pub(crate) fn watch(&mut self, volts: f32, motional_current: Phasor, susceptance: f32) {
        self.amperes = newton_step(self.amperes, motional_current.norm_sqr());
        if self.response < 0.0 {
            (self.volts, self.current, self.response) = (volts, self.amperes, 0.0);
            return;
        }
        let rise = self.gain * (self.amperes - self.current);
        self.current += rise;
        self.volts += self.gain * (volts - self.volts);
        self.response += self.gain * (1.0 - self.response);
        let (resistive, least) = (self.volts - self.ohm * rise, MIN_RESISTIVE_REL * self.volts);
        if self.response < MIN_RESPONSE_REL || resistive < least && self.current < HIGH_CURRENT_REL * self.limit_a {
            return;
        }
        let conductance = self.current / larger(resistive, least);
        self.siemens = newton_step(self.siemens, conductance * conductance + susceptance * susceptance);
        self.ceiling = up_to(f32::MAX, TARGET_CURRENT_REL * self.limit_a / self.siemens);
    }
}

/// Returns one Newton step from `root` to the root of `square`, or the exact root if `root` is far
/// from it.
#[inline(always)]
fn newton_step(root: f32, square: f32) -> f32 {
    let near = root > 0.0 && square <= MAX_NEWTON_RATIO * root * root;
    if near { 0.5 * (root + square / root) } else { fpu::sqrtf(square) }
}
