//! The free vibration, as the steady drive that would hold it (V). Block by block it follows
//! `R' = -a (R - u)` under a drive of `u`.
//!
//! It is known up to the end of the last planned block. A measurement is of an earlier block, whose
//! ends are stored until it arrives.

use crate::seam::block::LATENCY_BLOCKS;

/// Gain of the correction: the part of the deviation from the model that is applied.
const CORRECTION_GAIN: f32 = 0.5;
/// Relative deviation from the drive below which the ring-up is complete.
const RING_UP_REL: f32 = 0.1;

/// Model of the vibration.
#[derive(Clone, Debug, Default)]
pub(super) struct Ring {
    /// `a`, 1/sample; zero before it is known.
    per_sample: f32,
    /// Part that remains after half a block.
    half_retained: f32,
    /// Part that remains after a block of `samples`.
    block_retained: f32,
    samples: usize,
    volts: f32,
    /// Vibration at the ends of the last planned blocks, V; the second is the end of the measured
    /// block.
    ends: [f32; LATENCY_BLOCKS + 1],
    /// `true` if a block has been measured.
    measured: bool,
}

impl Ring {
    /// Returns the present vibration, V.
    pub(super) fn volts(&self) -> f32 {
        self.volts
    }

    /// Sets the decay rate, 1/sample, for blocks of this number of samples.
    pub(super) fn set_rate(&mut self, per_sample: f32, samples: usize) {
        (self.per_sample, self.samples) = (per_sample, samples);
        self.block_retained = self.retained(samples as f32);
        self.half_retained = self.retained(0.5 * samples as f32);
    }

    /// Advances by this number of samples under a drive of `volts`.
    pub(super) fn advance(&mut self, volts: f32, samples: usize) {
        let retained = if samples == self.samples { self.block_retained } else { self.retained(samples as f32) };
        self.volts = volts + (self.volts - volts) * retained;
    }

    /// Ends a block.
    pub(super) fn end_block(&mut self) {
        self.ends = [self.ends[1], self.ends[2], self.volts];
    }

    /// Takes the vibration in the middle of the measured block, V.
    pub(super) fn update(&mut self, volts: f32) {
        let [begins, ends, now] = self.ends;
        let deviation = volts - 0.5 * (begins + ends);
        let correction = if self.measured { CORRECTION_GAIN * deviation } else { deviation } * self.half_retained;
        self.measured = true;
        self.volts = now + correction * self.block_retained;
        self.ends = [begins, ends + correction, self.volts];
    }

    /// Returns `true` if the ring-up to a drive of `volts` was complete before the last block.
    pub(super) fn was_rung_up(&self, volts: f32) -> bool {
        self.measured && (self.ends[1] - volts).abs() < RING_UP_REL * volts
    }

    /// Returns `exp(-a n)`: (12 - 6 x + x^2) / (12 + 6 x + x^2), error 7e-4 up to x = 1, 4e-5 up to
    /// 1 / 2.
    fn retained(&self, samples: f32) -> f32 {
        let x = self.per_sample * samples;
        let even = 12.0 + x * x;
        (even - 6.0 * x) / (even + 6.0 * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(per_sample: f32) -> Ring {
        let mut ring = Ring { measured: true, ..Ring::default() };
        ring.set_rate(per_sample, 32);
        ring
    }

    #[test]
    fn the_vibration_decays_exponentially() {
        for (x, bound) in [(0.07f32, 1e-6), (0.5, 4e-5), (1.0, 7e-4)] {
            let mut ring = ring(x / 32.0);
            ring.advance(1.0, 32);
            assert!((ring.volts() - (1.0 - libm::expf(-x))).abs() < bound, "{x}: {}", ring.volts());
        }
    }

    /// A measurement two blocks late is applied once, with its decay since then.
    #[test]
    fn a_measurement_is_applied_once() {
        let mut ring = ring(2e-3);
        let mut truth = 0.3;
        let mut measured = std::vec::Vec::new();
        for n in 0..12 {
            ring.advance(0.0, 32);
            ring.end_block();
            let retained = libm::expf(-2e-3 * 32.0);
            measured.push(truth * fpu::sqrtf(retained));
            truth *= retained;
            if n >= LATENCY_BLOCKS {
                // The measured block ended a block ago.
                ring.update(measured[n - 1]);
            }
        }
        // Measured: 0.139, and 0.139 expected.
        assert!((ring.volts() / truth - 1.0).abs() < 0.01, "{} {truth}", ring.volts());
    }
}
