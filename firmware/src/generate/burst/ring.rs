//! What rings, as the steady drive that would hold it (V), followed block by block: `R' = -a (R - u)` under a drive of `u`.
//!
//! It is known up to the end of the last block that was planned. What is heard is of a block before that, so that its ends are kept until then.

use crate::seam::block::LATENCY_BLOCKS;

/// Part of what is heard beside the model that is believed.
const BELIEVED: f32 = 0.5;
/// Rung up: within this part of the drive.
const RUNG_UP: f32 = 0.1;

/// What rings.
#[derive(Clone, Debug, Default)]
pub(super) struct Ring {
    /// `a`, 1/sample; zero as long as nothing is known.
    per_sample: f32,
    /// What is left of it after half a block, and after a block of `samples`.
    half_kept: f32,
    block_kept: f32,
    samples: usize,
    volts: f32,
    /// At the ends of the last blocks planned, and so at its own of the one that is heard: of the one before that, of that, and so on.
    ends: [f32; LATENCY_BLOCKS + 1],
    /// It has been heard.
    heard: bool,
}

impl Ring {
    /// Now, V.
    pub(super) fn volts(&self) -> f32 {
        self.volts
    }

    /// Takes the rate by which it decays, 1/sample, in blocks of so many samples.
    pub(super) fn set_rate(&mut self, per_sample: f32, samples: usize) {
        (self.per_sample, self.samples) = (per_sample, samples);
        self.block_kept = self.kept(samples as f32);
        self.half_kept = self.kept(0.5 * samples as f32);
    }

    /// So many samples under a drive of `volts`.
    pub(super) fn advance(&mut self, volts: f32, samples: usize) {
        let kept = if samples == self.samples { self.block_kept } else { self.kept(samples as f32) };
        self.volts = volts + (self.volts - volts) * kept;
    }

    /// A block ends.
    pub(super) fn end_block(&mut self) {
        self.ends = [self.ends[1], self.ends[2], self.volts];
    }

    /// Takes what was heard in the middle of the block that is heard now, V.
    pub(super) fn update(&mut self, volts: f32) {
        let [begins, ends, now] = self.ends;
        let beside = volts - 0.5 * (begins + ends);
        let correction = if self.heard { BELIEVED * beside } else { beside } * self.half_kept;
        self.heard = true;
        self.volts = now + correction * self.block_kept;
        self.ends = [begins, ends + correction, self.volts];
    }

    /// Whether it had come to what a drive of `volts` holds before the last block.
    pub(super) fn was_rung_up(&self, volts: f32) -> bool {
        self.heard && (self.ends[1] - volts).abs() < RUNG_UP * volts
    }

    /// `exp(-a n)`: (12 - 6 x + x^2) / (12 + 6 x + x^2), error 7e-4 up to x = 1, 4e-5 up to 1 / 2.
    fn kept(&self, samples: f32) -> f32 {
        let x = self.per_sample * samples;
        let even = 12.0 + x * x;
        (even - 6.0 * x) / (even + 6.0 * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(per_sample: f32) -> Ring {
        let mut ring = Ring { heard: true, ..Ring::default() };
        ring.set_rate(per_sample, 32);
        ring
    }

    #[test]
    fn it_decays_as_an_exponential() {
        for (x, bound) in [(0.07f32, 1e-6), (0.5, 4e-5), (1.0, 7e-4)] {
            let mut ring = ring(x / 32.0);
            ring.advance(1.0, 32);
            assert!((ring.volts() - (1.0 - libm::expf(-x))).abs() < bound, "{x}: {}", ring.volts());
        }
    }

    /// What is heard two blocks late is taken once, and has decayed meanwhile.
    #[test]
    fn what_is_heard_is_believed_once() {
        let mut ring = ring(2e-3);
        let mut truth = 0.3;
        let mut heard = std::vec::Vec::new();
        for n in 0..12 {
            ring.advance(0.0, 32);
            ring.end_block();
            let kept = libm::expf(-2e-3 * 32.0);
            heard.push(truth * libm::sqrtf(kept));
            truth *= kept;
            if n >= LATENCY_BLOCKS {
                // The block that is heard ended a block ago.
                ring.update(heard[n - 1]);
            }
        }
        // Measured: 0.139 for 0.139.
        assert!((ring.volts() / truth - 1.0).abs() < 0.01, "{} {truth}", ring.volts());
    }
}
