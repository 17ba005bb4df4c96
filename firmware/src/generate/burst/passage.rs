//! Passages of the drive through zero, by its phase: edges of bursts wait for them.

use crate::generate::nco::Stretch;
use crate::seam::block::MAX_BLOCK_SAMPLES;

/// Whether the sine falls below zero after this phase: the second half of the turn.
pub(super) fn falling(phase: u64) -> bool {
    phase >> 63 == 1
}

/// After how many samples the next zero is passed, one at least; and the phase then.
pub(super) fn until_passage(phase: u64, word: u64) -> (usize, u64) {
    // Not more than that many, by a division of 32 bits; the rest one by one. Above 0.01 cycles a sample that is one or none.
    let (rest, step) = ((1 << 31) - 1 - (phase << 1 >> 33) as u32, (word >> 32) as u32);
    let mut samples = rest / step.saturating_add(1);
    let mut there = phase.wrapping_add(u64::from(samples).wrapping_mul(word));
    while falling(there) == falling(phase) && samples < MAX_BLOCK_SAMPLES as u32 {
        samples += 1;
        there = there.wrapping_add(word);
    }
    (samples as usize, there)
}

/// The same after the last sample of a block.
#[inline]
pub(super) fn ends_falling(stretch: &Stretch, samples: usize) -> bool {
    let last = samples.saturating_sub(1);
    falling(if stretch.step == 0 {
        stretch.phase.wrapping_add(stretch.word.wrapping_mul(last as u64))
    } else {
        stretch.phase_at(last)
    })
}
