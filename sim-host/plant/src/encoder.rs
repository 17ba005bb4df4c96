//! The encoder on a belt: two channels in quadrature. Every edge is a count, up as the belt pays
//! out and down as it is drawn back.
//!
//! `counts = floor(position / pitch + phase)`, with the phase by the initial position of the belt.
//! The edges are ideal: those of a real encoder are off by a fraction of a count, which shifts a
//! count in time but never loses one.

use firmware::seam::block::BeltSense;

/// An encoder and its decoder.
#[derive(Clone, Copy, Debug)]
pub struct Encoder {
    counts_per_m: f64,
    phase: f64,
}

impl Encoder {
    /// Creates an encoder of `counts_per_mm` counts a millimetre. At position zero the belt has
    /// passed a fraction `phase` of a count.
    pub fn new(counts_per_mm: f64, phase: f64) -> Self {
        Encoder { counts_per_m: 1e3 * counts_per_mm, phase }
    }

    /// Returns the reading of the decoder with the belt at `position_m`.
    pub fn read(&self, position_m: f64) -> BeltSense {
        // Through 64 bits, which wrap to 32 as the decoder's counter does.
        let counts = (position_m * self.counts_per_m + self.phase).floor() as i64;
        BeltSense { counts: counts as i32, broken: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_in_both_directions_and_wraps() {
        let encoder = Encoder::new(100.0, 0.5);
        let counts = [0.0, 4e-6, 6e-6, 1e-3, -4e-6, -6e-6].map(|position| encoder.read(position).counts);
        assert_eq!(counts, [0, 0, 1, 100, 0, -1]);
        let beyond = (f64::from(i32::MAX) + 10.6) * 1e-5;
        assert_eq!(encoder.read(beyond).counts, i32::MIN + 10);
    }
}
