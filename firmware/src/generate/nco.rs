//! Numerically controlled oscillator: a phase accumulator of 2^64 steps a turn.
//!
//! `phase(n + 1) = phase(n) + word`, `frequency = word / 2^64 * sample_hz`. At 1 Msps one step is
//! 5e-14 Hz, so that the phase does not drift in any run; a 32-bit accumulator is off by 28 degrees
//! after 1e9 samples of 40 000.1 Hz.
//!
//! Within a block the word may grow by a constant, so that a chirp has no steps: [`Stretch`].

/// Number of phase steps in a turn, 2^64.
const STEPS_PER_TURN: f64 = 18_446_744_073_709_551_616.0;

/// Returns the tuning word of a frequency: turns a sample times 2^64.
///
/// `cycles_per_sample` must be between 0 and 1; outside, the cast saturates.
pub fn tuning_word(cycles_per_sample: f64) -> u64 {
    (cycles_per_sample * STEPS_PER_TURN) as u64
}

/// Returns the frequency of a tuning word, turns a sample.
pub fn cycles_per_sample(word: u64) -> f64 {
    word as f64 / STEPS_PER_TURN
}

/// Phase of the oscillator in a block: `phase(n) = phase + n word + n (n - 1) / 2 step`, 2^64 a
/// turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stretch {
    /// Phase of the first sample.
    pub phase: u64,
    /// Increment of the phase after the first sample.
    pub word: u64,
    /// Increment of the word after each sample, wrapping; zero at a constant frequency.
    pub step: u64,
}

impl Stretch {
    /// Returns the phase of sample `n`.
    pub fn phase_at(&self, n: usize) -> u64 {
        let (n, pairs) = (n as u64, (n as u64).wrapping_mul((n as u64).wrapping_sub(1)) / 2);
        self.phase.wrapping_add(n.wrapping_mul(self.word)).wrapping_add(pairs.wrapping_mul(self.step))
    }

    /// Returns the increment of the phase after sample `n`.
    pub(crate) fn word_at(&self, n: usize) -> u64 {
        self.word.wrapping_add((n as u64).wrapping_mul(self.step))
    }

    /// Returns the tone of constant frequency nearest to the first `samples` samples, in the sense
    /// of least squares. A chirp of rate `c` (Hz/s) deviates from it by `pi c (T / 2)^2 / 3` rad
    /// rms at most over a block of `T`.
    pub(crate) fn chord(&self, samples: usize) -> Stretch {
        if self.step == 0 {
            return *self;
        }
        let (step, samples) = (self.step as i64, samples as i64);
        // n (n - 1) / 2 rises by (N - 2) / 2 a sample on average; the means of the two differ by (N
        // - 1) (N - 2) / 12.
        let early = (step / 12).wrapping_mul((samples - 1) * (samples - 2));
        let word = self.word.wrapping_add_signed((step / 2).wrapping_mul(samples - 2));
        Stretch { phase: self.phase.wrapping_add_signed(early.wrapping_neg()), word, step: 0 }
    }
}

/// Phases of a stretch, sample after sample, in 32 bits. The truncation error is below 5e-7 turns
/// after a block, and is not carried into the next one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Phases {
    phase: u32,
    word: u32,
    step: u32,
}

impl Stretch {
    /// Returns the phases from the first sample on, `lead` (2^32 a turn) ahead of the oscillator.
    pub(crate) fn phases(&self, lead: u32) -> Phases {
        let high = |wide: u64| (wide >> 32) as u32;
        Phases { phase: high(self.phase).wrapping_add(lead), word: high(self.word), step: high(self.step) }
    }

    /// Returns the frequency of the first sample, cycles a sample.
    pub(crate) fn frequency(&self) -> f32 {
        (self.word >> 32) as u32 as f32 * (1.0 / 4_294_967_296.0)
    }
}

impl Phases {
    /// Returns the first phase and the increment, if the frequency is constant.
    #[inline]
    pub(crate) fn steady(&self) -> Option<(u32, u32)> {
        (self.step == 0).then_some((self.phase, self.word))
    }

    /// Returns the next phase, 2^32 a turn.
    #[inline]
    pub(crate) fn take(&mut self) -> u32 {
        let phase = self.phase;
        self.phase = phase.wrapping_add(self.word);
        self.word = self.word.wrapping_add(self.step);
        phase
    }
}

/// Numerically controlled oscillator, which consists of its phase.
#[derive(Clone, Debug, Default)]
pub struct Nco {
    phase: u64,
}

impl Nco {
    /// Advances by `samples` samples, the first of tuning word `word`, which grows by `step` a
    /// sample. Returns the phase over the block.
    pub fn advance(&mut self, (word, step): (u64, u64), samples: usize) -> Stretch {
        let stretch = Stretch { phase: self.phase, word, step };
        self.phase = stretch.phase_at(samples);
        stretch
    }

    /// Resets the phase to the beginning of a cycle.
    #[inline]
    pub(crate) fn rewind(&mut self) {
        self.phase = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phase_is_exact_after_1e9_samples() {
        let word = tuning_word(40_000.1 / 1e6);
        let mut nco = Nco::default();
        for _ in 0..1000 {
            nco.advance((word, 0), 1_000_000);
        }
        assert_eq!(nco.advance((word, 0), 0).phase, word.wrapping_mul(1_000_000_000));
    }

    /// Reason for 64 bits: rounded to 32, the word of 40 000.1 Hz is off by 28 degrees of phase
    /// after 1e9 samples.
    #[test]
    fn a_word_of_32_bits_would_drift() {
        let exact = tuning_word(40_000.1 / 1e6);
        let short = (exact + (1 << 31)) >> 32 << 32;
        let degrees = 360.0 * (exact as f64 - short as f64) / STEPS_PER_TURN * 1e9;
        assert!((27.0..29.0).contains(&degrees.abs()), "{degrees}");
    }

    #[test]
    fn a_block_of_a_chirp_is_summed_exactly() {
        let stretch = Stretch { phase: u64::MAX - 5, word: tuning_word(0.04), step: 123_456_789_012 };
        let (mut phase, mut word) = (stretch.phase, stretch.word);
        for n in 0..64 {
            assert_eq!(stretch.phase_at(n), phase);
            phase = phase.wrapping_add(word);
            word = word.wrapping_add(stretch.step);
        }
    }

    #[test]
    fn the_chord_leaves_no_mean_difference() {
        for step in [3_000_000_000_000_u64, 3_000_000_000_000_u64.wrapping_neg()] {
            let stretch = Stretch { phase: 77, word: tuning_word(0.04), step };
            let chord = stretch.chord(32);
            let apart = |n: usize| stretch.phase_at(n).wrapping_sub(chord.phase_at(n)) as i64;
            let (mean, slope) =
                (0..32).fold((0, 0), |sum, n| (sum.0 + apart(n) / 32, sum.1 + apart(n) / 32 * (2 * n as i64 - 31)));
            assert!(mean.abs() < 1000 && slope.abs() < 10_000, "{mean} {slope}");
            assert!((apart(0) - apart(31)).abs() < 1000 && apart(0).signum() == (step as i64).signum());
        }
    }

    #[test]
    fn word_resolves_a_millionth_of_a_hertz() {
        let word = tuning_word(40_000.000_001 / 1e6);
        assert!((cycles_per_sample(word) * 1e6 - 40_000.000_001).abs() < 1e-9);
    }
}
