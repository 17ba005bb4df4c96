//! Zero crossings of the drive, from its phase: edges of bursts wait for them.

use crate::generate::nco::Stretch;
use crate::seam::block::MAX_BLOCK_SAMPLES;

/// Returns `true` if the sine is in its negative half cycle: the second half of the turn.
pub(super) fn falling(phase: u64) -> bool {
    phase >> 63 == 1
}

/// Tuning word above which zero crossings are found one by one: a half cycle of five samples.
const MAX_COUNTED_WORD: u64 = u64::MAX / 10;
/// Largest number of zero crossings that are found at once.
const MAX_CROSSINGS: u32 = 8;

/// Returns the number of zeros that are certainly crossed within the next samples, up to the
/// largest number for [`until_crossing`].
pub(super) fn crossings_within(phase: u64, word: u64, samples: usize) -> u32 {
    if word > MAX_COUNTED_WORD {
        return 0;
    }
    // In half turns, 2^32 each; truncation reduces the result.
    let halves = |wide: u64| u64::from((wide << 1 >> 32) as u32);
    ((halves(phase) + halves(word) * samples.saturating_sub(1) as u64) >> 32).min(u64::from(MAX_CROSSINGS)) as u32
}

/// Returns the number of samples until this number of zeros is crossed, and the phase then.
pub(super) fn until_crossing(phase: u64, word: u64, crossings: u32) -> (usize, u64) {
    // In half turns, 2^28 each. A 32-bit division gives a lower bound; the rest, one or two samples
    // above 0.01 cycles a sample, follows one by one.
    let (rest, step) = ((crossings << 28) - 1 - (phase << 1 >> 36) as u32, (word >> 35) as u32);
    let mut samples = rest / (step + 1);
    let mut there = phase.wrapping_add(u64::from(samples).wrapping_mul(word));
    let before = falling(phase) ^ crossings.is_multiple_of(2);
    while falling(there) == before && samples < MAX_BLOCK_SAMPLES as u32 {
        samples += 1;
        there = there.wrapping_add(word);
    }
    (samples as usize, there)
}

/// Returns the number of samples, up to `most`, until the next zero is crossed at a changing
/// frequency, and the phase then.
pub(super) fn until_crossing_of_chirp(phase: u64, word: u64, step: u64, most: usize) -> (usize, u64) {
    let (mut there, mut word, mut samples) = (phase, word, 0);
    while samples < most && falling(there) == falling(phase) {
        there = there.wrapping_add(word);
        word = word.wrapping_add(step);
        samples += 1;
    }
    (samples, there)
}

/// Returns `true` if a block ends in the negative half cycle of the sine.
#[inline]
pub(super) fn ends_falling(stretch: &Stretch, samples: usize) -> bool {
    let last = samples.saturating_sub(1);
    falling(if stretch.step == 0 {
        stretch.phase.wrapping_add(stretch.word.wrapping_mul(last as u64))
    } else {
        stretch.phase_at(last)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::nco::tuning_word;

    /// Compares with a search of every sample.
    #[test]
    fn crossings_match_a_search_of_every_sample() {
        let mut found = [0; MAX_CROSSINGS as usize + 1];
        for n in 0..20_000u64 {
            let word = tuning_word(0.002 + 0.448 * n as f64 / 20_000.0);
            let phase = n.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let falls = |at: usize| falling(phase.wrapping_add(word.wrapping_mul(at as u64)));
            let crossings: std::vec::Vec<usize> = (1..MAX_BLOCK_SAMPLES).filter(|&at| falls(at) != falls(at - 1)).collect();
            let within = crossings_within(phase, word, MAX_BLOCK_SAMPLES);
            assert!(within as usize <= crossings.len());
            assert!(word > MAX_COUNTED_WORD || crossings.len() > MAX_CROSSINGS as usize || crossings.len() == within as usize);
            found[within as usize] += 1;
            for count in 1..=within.max(1) {
                let (samples, there) = until_crossing(phase, word, count);
                let expected = crossings.get(count as usize - 1).copied().unwrap_or(MAX_BLOCK_SAMPLES);
                assert_eq!(samples.min(MAX_BLOCK_SAMPLES), expected, "{count} at {n}");
                assert_eq!(there, phase.wrapping_add(word.wrapping_mul(samples as u64)));
            }
        }
        assert!(found[1..].iter().all(|&times| times > 100), "{found:?}");
    }
}
