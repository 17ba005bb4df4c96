//! Passages of the drive through zero, by its phase: edges of bursts wait for them.

use crate::generate::nco::Stretch;
use crate::seam::block::MAX_BLOCK_SAMPLES;

/// Whether the sine falls below zero after this phase: the second half of the turn.
pub(super) fn falling(phase: u64) -> bool {
    phase >> 63 == 1
}

/// Half cycles shorter than this, of a turn a sample times 2^64, are looked at one by one: five samples.
const SHORT: u64 = u64::MAX / 10;
/// Passages that are looked for at once.
const MOST: u32 = 8;

/// How many zeros are certainly passed within the next samples, up to as many as [`until_passage`] can be asked for.
pub(super) fn passages_within(phase: u64, word: u64, samples: usize) -> u32 {
    if word > SHORT {
        return 0;
    }
    // In half turns, 2^32 each: what is cut off makes it less.
    let halves = |wide: u64| u64::from((wide << 1 >> 32) as u32);
    ((halves(phase) + halves(word) * samples.saturating_sub(1) as u64) >> 32).min(u64::from(MOST)) as u32
}

/// After how many samples so many zeros have been passed, one sample at least; and the phase then.
pub(super) fn until_passage(phase: u64, word: u64, passages: u32) -> (usize, u64) {
    // In half turns, 2^28 each. Not more than that many, by a division of 32 bits; the rest one by one. Above 0.01 cycles a sample that is one or two.
    let (rest, step) = ((passages << 28) - 1 - (phase << 1 >> 36) as u32, (word >> 35) as u32);
    let mut samples = rest / (step + 1);
    let mut there = phase.wrapping_add(u64::from(samples).wrapping_mul(word));
    let before = falling(phase) ^ passages.is_multiple_of(2);
    while falling(there) == before && samples < MAX_BLOCK_SAMPLES as u32 {
        samples += 1;
        there = there.wrapping_add(word);
    }
    (samples as usize, there)
}

/// The same of a frequency that moves, sample by sample: after how many samples, `most` of them, the next zero has been passed.
pub(super) fn until_passage_of_chirp(phase: u64, word: u64, step: u64, most: usize) -> (usize, u64) {
    let (mut there, mut word, mut samples) = (phase, word, 0);
    while samples < most && falling(there) == falling(phase) {
        there = there.wrapping_add(word);
        word = word.wrapping_add(step);
        samples += 1;
    }
    (samples, there)
}

/// Whether the sine falls after the last sample of a block.
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

    /// By looking at every sample.
    #[test]
    fn passages_are_those_of_every_sample() {
        let mut found = [0; MOST as usize + 1];
        for n in 0..20_000u64 {
            let word = tuning_word(0.002 + 0.448 * n as f64 / 20_000.0);
            let phase = n.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let falls = |at: usize| falling(phase.wrapping_add(word.wrapping_mul(at as u64)));
            let passages: std::vec::Vec<usize> = (1..MAX_BLOCK_SAMPLES).filter(|&at| falls(at) != falls(at - 1)).collect();
            let within = passages_within(phase, word, MAX_BLOCK_SAMPLES);
            assert!(within as usize <= passages.len());
            assert!(word > SHORT || passages.len() > MOST as usize || passages.len() == within as usize);
            found[within as usize] += 1;
            for count in 1..=within.max(1) {
                let (samples, there) = until_passage(phase, word, count);
                let expected = passages.get(count as usize - 1).copied().unwrap_or(MAX_BLOCK_SAMPLES);
                assert_eq!(samples.min(MAX_BLOCK_SAMPLES), expected, "{count} at {n}");
                assert_eq!(there, phase.wrapping_add(word.wrapping_mul(samples as u64)));
            }
        }
        assert!(found[1..].iter().all(|&times| times > 100), "{found:?}");
    }
}
