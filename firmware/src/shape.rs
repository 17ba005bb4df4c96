//! Phase to amplitude: the waveform of one period, of peak one, so that a voltage limit is a limit for every shape.
//!
//! Every shape is a table of one period read by linear interpolation. The error of the sine is
//! `(2 pi / 1024)^2 / 8 = 4.7e-6`, fifty times below half a step of a 12-bit converter; 1024 entries without
//! interpolation would reach 60 dB only.

pub mod sine;
pub mod square;

use crate::config::ShapeKind;

/// Entries in a period.
const LENGTH: usize = 1 << INDEX_BITS;
const INDEX_BITS: u32 = 10;
const FRACTION_BITS: u32 = 32 - INDEX_BITS;
const FRACTION_SCALE: f32 = 1.0 / (1u32 << FRACTION_BITS) as f32;

/// One period of a waveform; the first entry stands again at the end, for interpolation.
pub struct Table([f32; LENGTH + 1]);

impl Table {
    /// The waveform at a phase of `phase / 2^32` turns.
    #[inline]
    pub fn at(&self, phase: u32) -> f32 {
        let index = (phase >> FRACTION_BITS) as usize;
        let fraction = (phase & ((1 << FRACTION_BITS) - 1)) as f32 * FRACTION_SCALE;
        let here = self.0[index];
        here + (self.0[index + 1] - here) * fraction
    }
}

/// The table for a shape whose fundamental never exceeds `cycles_per_sample`.
pub fn table(shape: ShapeKind, cycles_per_sample: f32) -> &'static Table {
    match shape {
        ShapeKind::Sine => &sine::TABLE,
        ShapeKind::Square => square::table(cycles_per_sample),
    }
}
