//! Ringing of resonances that the observer does not know.
//!
//! A step of the drive excites every resonance of the transducer. The others beat with the drive,
//! and the observer would take that for a detuning: an edge boosted to four times the drive leaves
//! several percent of the current. The size of this disturbance after a step is learned from the
//! innovations, as a variance relative to the square of the step. It counts as noise, and follows
//! the innovations until it is no longer visible. A transducer with a single resonance has none.

use crate::seam::compare::{larger, smaller};

/// Number of blocks after a step that are evaluated.
const WINDOW_BLOCKS: f32 = 64.0;
/// Smallest number of blocks that are evaluated.
const MIN_BLOCKS: f32 = 8.0;
/// Ratio of the squares of innovations, or of the disturbance, to what is expected without it, from
/// which it is visible.
const VISIBLE: f32 = 4.0;
/// Weight of earlier steps against the last one.
const MEMORY: f32 = 0.5;
/// Part of the difference from the innovations that the variance follows in a block.
const FOLLOWED: f32 = 1.0 / 32.0;

/// Disturbance after steps of the drive.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ringing {
    /// Variance of the disturbance, A².
    variance: f32,
    /// Variance after a step, relative to its square, S².
    per_square: f32,
    /// Sum of squares of steps that this was learned from, V².
    squares: f32,
    /// Square of the last step, V².
    square: f32,
    /// Since that step: number of blocks, and sums of the squares of innovations, A², and of their
    /// expected values without the disturbance, A².
    blocks: f32,
    innovations: f32,
    expected: f32,
}

impl Ringing {
    /// Returns `true` if the next innovation matters: it is one of the first after a step, or there
    /// is a disturbance.
    #[inline]
    pub(super) fn listens(&self) -> bool {
        self.blocks < WINDOW_BLOCKS || self.variance > 0.0
    }

    /// Takes the square of a step of the drive, V².
    #[inline(never)]
    pub(super) fn step(&mut self, square: f32) {
        self.evaluate();
        // An edge takes several steps.
        self.square = if self.blocks < MIN_BLOCKS { self.square + square } else { square };
        (self.blocks, self.innovations, self.expected) = (0.0, 0.0, 0.0);
        self.variance += self.per_square * square;
    }

    /// Takes the square of an innovation and its expected value without the disturbance, A², which
    /// decays by `retained` a block. Returns the variance of the disturbance, A².
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(super) fn take(&mut self, innovation: f32, expected: f32, retained: f32) -> f32 {
        if self.variance > 0.0 {
            self.variance *= retained;
            if self.variance > expected {
                // A jump of the load, which opens the gate, hardly counts.
                let seen = smaller(innovation, VISIBLE * self.variance);
                self.variance += FOLLOWED * (seen - expected - self.variance);
            }
        }
        if self.blocks < WINDOW_BLOCKS {
            self.blocks += 1.0;
            self.innovations += innovation;
            self.expected += expected;
        }
        self.variance
    }

    /// Learns from the blocks since the last step, if the disturbance was visible or should have
    /// been.
    fn evaluate(&mut self) {
        let excited = self.square * self.blocks;
        let visible = larger(self.innovations, self.per_square * excited) > VISIBLE * self.expected;
        if visible && self.blocks >= MIN_BLOCKS {
            let earlier = MEMORY * self.squares;
            self.squares = earlier + excited;
            let excess = self.per_square * earlier + larger(self.innovations - self.expected, 0.0);
            self.per_square = excess / self.squares;
        }
    }
}
