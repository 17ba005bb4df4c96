//! The most voltage that keeps the current within its limit, foreseen from how the current moves.
//!
//! ```text
//! 2 L d|I_m|/dt + R |I_m| = V  (about the resonance),   g = 1 / R = |I_m| / (V - 2 L d|I_m|/dt),   |I| = V sqrt(g^2 + B^2)  once rung up
//! ```
//!
//! `L` hardly moves with the load, so that a part of a ring-up tells what all of it will come to: an order that is too loud is held back before its
//! current is there, and so is a load that comes off. Voltage and current go through the same low-pass of an eighth of the time constant, which leaves the
//! equation as it is, and eight times the noise of the current in `R`, whatever Q is.
//!
//! Both roots follow by a step of Newton's a block, which is never below the root: while it is above, the drive is held back a little more.

use crate::seam::compare::{larger, smaller, up_to};
use crate::seam::phasor::Phasor;

/// Part of the limit that is aimed at.
const AIM: f32 = 0.95;
/// The low-pass, parts of the time constant.
const QUICKER: f32 = 8.0;
/// The part that the low-pass must have come of a step before it is read.
const READ: f32 = 0.8;
/// Less than this part of the voltage is not told from noise: a ring-up that has just begun, or, where there is this part of the limit already, one that ends
/// far beyond it.
const READABLE: f32 = 0.1;
const LOUD: f32 = 0.3;
/// A square that is larger than this times the last one is far from it: a step of Newton's would be a tenth off.
const FAR: f32 = 2.0;

/// The fold-back of the current.
#[derive(Clone, Debug)]
pub(crate) struct FoldBack {
    limit_a: f32,
    /// `2 L` by the time of a block, ohm.
    ohm: f32,
    /// Part of the way that the low-pass goes in a block; zero before anything is known.
    gain: f32,
    /// The motional current, A, and the admittance, S: roots that follow.
    amperes: f32,
    siemens: f32,
    /// Voltage, V, and motional current, A, through the low-pass, and how far it has come since it began.
    volts: f32,
    current: f32,
    come: f32,
    /// The most voltage, V.
    ceiling: f32,
}

impl FoldBack {
    /// Keeps this current, A.
    pub(crate) fn build(limit_a: f32) -> Self {
        FoldBack {
            limit_a,
            ohm: 0.0,
            gain: 0.0,
            amperes: 0.0,
            siemens: 0.0,
            volts: 0.0,
            current: 0.0,
            come: -1.0,
            ceiling: f32::INFINITY,
        }
    }

    /// Begins with this inductance, H, blocks that last so long, s, and the part of the time constant that they are.
    pub(crate) fn begin(&mut self, lm_h: f32, block_s: f32, lag: f32) {
        *self = FoldBack { ohm: 2.0 * lm_h / block_s, gain: smaller(QUICKER * lag, 1.0), ..FoldBack::build(self.limit_a) };
    }

    /// The most voltage, V.
    pub(crate) fn ceiling(&self) -> f32 {
        self.ceiling
    }

    /// The next block is not like the last one: an edge, or silence.
    pub(crate) fn interrupt(&mut self) {
        self.come = -1.0;
    }

    /// Takes a block of this voltage throughout, V: its motional current, A, and the susceptance of the clamped branch, S.
    #[inline(never)]
    pub(crate) fn watch(&mut self, volts: f32, motional_current: Phasor, susceptance: f32) {
        self.amperes = follow(self.amperes, motional_current.norm_sqr());
        if self.come < 0.0 {
            (self.volts, self.current, self.come) = (volts, self.amperes, 0.0);
            return;
        }
        let rise = self.gain * (self.amperes - self.current);
        self.current += rise;
        self.volts += self.gain * (volts - self.volts);
        self.come += self.gain * (1.0 - self.come);
        let (felt, least) = (self.volts - self.ohm * rise, READABLE * self.volts);
        if self.come < READ || felt < least && self.current < LOUD * self.limit_a {
            return;
        }
        let conductance = self.current / larger(felt, least);
        self.siemens = follow(self.siemens, conductance * conductance + susceptance * susceptance);
        self.ceiling = up_to(f32::MAX, AIM * self.limit_a / self.siemens);
    }
}

/// A step from a root towards that of `square`, from above; all the way to one that is far from it.
#[inline(always)]
fn follow(root: f32, square: f32) -> f32 {
    let near = root > 0.0 && square <= FAR * root * root;
    if near { 0.5 * (root + square / root) } else { libm::sqrtf(square) }
}
