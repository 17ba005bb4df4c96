//! Ringing of resonances that the observer does not know.
//!
//! A step of the drive excites every resonance of the transducer. The others beat with the drive,
//! and the observer would take that for a detuning: an edge boosted to four times the drive leaves
//! several percent of the current. The size of this disturbance after a step is learned from the
//! innovations, as a variance relative to the square of the step. It counts as noise, and follows
//! the innovations until it is no longer visible. A transducer with a single resonance has none.

use super::ARM_BLOCKS;
use crate::seam::compare::{larger, smaller};

/// Number of blocks after a step that are evaluated.
const WINDOW_BLOCKS: u8 = 64;
/// Smallest number of blocks after a step that are evaluated. Of these, few may have an armed gate:
/// it opens by a disturbance that is not yet known.
const MIN_BLOCKS: u8 = 8;
/// Factor by which a visible disturbance, or the square of its innovations, exceeds the expected
/// square.
const VISIBLE: f32 = 4.0;
/// Smallest factor per block by which the square of a step fades: other resonances may ring longer
/// than the tracked one.
const MIN_LEFT: f32 = 1.0 - 1.0 / 32.0;
/// Part of the expected square below which a disturbance is over.
const OVER: f32 = 1e-3;
/// Weight of earlier steps against the last one.
const MEMORY: f32 = 0.5;
/// Part of the difference from the innovations that the variance follows in a block.
const FOLLOWED: f32 = 1.0 / 16.0;
/// Largest square of an innovation that the variance follows, relative to it: with more, it would
/// follow a jump of the load, and the gate would stay shut.
const MAX_FOLLOWED: f32 = 2.0;

/// Disturbance after steps of the drive.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ringing {
    /// Variance of the disturbance, A².
    variance: f32,
    /// Variance after a step, relative to its square, S².
    per_square: f32,
    /// Fading sum of `excited` that this was learned from, V².
    squares: f32,
    /// Sum of the squares of steps, each of which fades with time, V².
    square: f32,
    /// Blocks since the last step.
    blocks: u8,
    /// Sums over those of these blocks in which the gate is armed: of `square`, V²; of the squares
    /// of innovations, A²; and of their expected values without the disturbance, A².
    excited: f32,
    innovations: f32,
    expected: f32,
    /// `true` if the next innovation matters.
    listens: bool,
}

impl Ringing {
    /// Returns the variance of the disturbance in the next block, A².
    #[inline]
    pub(super) fn variance(&self) -> f32 {
        self.variance
    }

    /// Returns `true` if the next innovation matters: it is one of the first after a step, or there
    /// is a disturbance.
    #[inline]
    pub(super) fn listens(&self) -> bool {
        self.listens
    }

    /// Takes the square of a step of the drive, V².
    #[inline(never)]
    pub(super) fn step(&mut self, square: f32) {
        self.evaluate();
        self.square += square;
        (self.blocks, self.excited, self.innovations, self.expected, self.listens) = (0, 0.0, 0.0, 0.0, true);
        self.variance += self.per_square * square;
    }

    /// Ends the disturbance: in silence there is none.
    #[inline(never)]
    pub(super) fn rest(&mut self) {
        self.evaluate();
        (self.variance, self.square, self.blocks, self.listens) = (0.0, 0.0, 0, false);
    }

    /// Takes the square of an innovation, A², its expected value, A², and the factor by which the
    /// square of the free current changes in a block. `calm`: blocks since the gate has opened;
    /// until it is armed again, the expected value is mostly that of an unknown resonance.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(super) fn take(&mut self, innovation: f32, expected: f32, decay: f32, calm: u32) {
        let expected = expected - self.variance;
        let decay = smaller(decay, 1.0);
        self.variance *= decay;
        self.square *= larger(decay, MIN_LEFT);
        let within = self.blocks < WINDOW_BLOCKS;
        if calm > ARM_BLOCKS {
            if self.variance > expected {
                let seen = smaller(innovation, MAX_FOLLOWED * self.variance);
                self.variance += FOLLOWED * (seen - expected - self.variance);
            } else if self.variance < OVER * expected {
                self.variance = 0.0;
            }
            if within {
                self.excited += self.square;
                self.innovations += innovation;
                self.expected += expected;
            }
        }
        if within {
            self.blocks += 1;
        } else {
            self.square = 0.0;
            self.listens = self.variance > 0.0;
        }
    }

    /// Learns from the blocks since the last step, if the disturbance was visible or should have
    /// been.
    fn evaluate(&mut self) {
        let visible = larger(self.innovations, self.per_square * self.excited) > VISIBLE * self.expected;
        if visible && self.blocks >= MIN_BLOCKS && self.excited > 0.0 {
            let earlier = MEMORY * self.squares;
            self.squares = earlier + self.excited;
            let excess = self.per_square * earlier + larger(self.innovations - self.expected, 0.0);
            self.per_square = excess / self.squares;
        }
    }
}
