//! Numerically controlled oscillator: a phase accumulator of 2^64 steps a turn.
//!
//! `phase(n + 1) = phase(n) + word`, `frequency = word / 2^64 * sample_hz`. At 1 Msps one step is 5e-14 Hz, so that the
//! phase does not drift in any run; a 32-bit accumulator is off by 28 degrees after 1e9 samples of 40 000.1 Hz.

/// 2^64 as a number: steps in a turn.
const STEPS_PER_TURN: f64 = 18_446_744_073_709_551_616.0;

/// The tuning word for a frequency, in turns a sample times 2^64.
///
/// `cycles_per_sample` must lie in 0 to 1; outside, the cast saturates.
pub fn tuning_word(cycles_per_sample: f64) -> u64 {
    (cycles_per_sample * STEPS_PER_TURN) as u64
}

/// The frequency of a tuning word, in turns a sample.
pub fn cycles_per_sample(word: u64) -> f64 {
    word as f64 / STEPS_PER_TURN
}

/// The oscillator's phase.
#[derive(Clone, Debug, Default)]
pub struct Nco {
    phase: u64,
}

impl Nco {
    /// Phase of the next sample.
    pub fn phase(&self) -> u64 {
        self.phase
    }

    /// Moves on by `samples` samples of tuning word `word`.
    pub fn advance(&mut self, word: u64, samples: usize) {
        self.phase = self.phase.wrapping_add(word.wrapping_mul(samples as u64));
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
            nco.advance(word, 1_000_000);
        }
        assert_eq!(nco.phase(), word.wrapping_mul(1_000_000_000));
    }

    /// Why 64 bits: rounded to 32, the word of 40 000.1 Hz is off by 28 degrees of phase after 1e9 samples.
    #[test]
    fn a_word_of_32_bits_would_drift() {
        let exact = tuning_word(40_000.1 / 1e6);
        let short = (exact + (1 << 31)) >> 32 << 32;
        let degrees = 360.0 * (exact as f64 - short as f64) / STEPS_PER_TURN * 1e9;
        assert!((27.0..29.0).contains(&degrees.abs()), "{degrees}");
    }

    #[test]
    fn word_resolves_a_millionth_of_a_hertz() {
        let word = tuning_word(40_000.000_001 / 1e6);
        assert!((cycles_per_sample(word) * 1e6 - 40_000.000_001).abs() < 1e-9);
    }
}
