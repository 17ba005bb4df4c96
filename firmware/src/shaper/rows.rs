//! The codes of one lane, sample by sample: where a block spends most of its time. Eight samples at a time, and without anything that could be done once.
//!
//! A lane that is the opposite of another is written with it: its codes are the other's about mid-code, to the last bit.

use crate::shape::sine::Swing;

/// What is to be written.
#[derive(Clone, Copy)]
pub(super) struct Row {
    /// The sine, codes.
    pub(super) swing: Swing,
    /// What truncation rounds to the nearest code with.
    pub(super) base: f32,
    /// Twice mid-code: what a code and its opposite add up to, but for what 16 bits cannot hold.
    pub(super) twice: u16,
}

/// Under an envelope of one. Returns the sum of the codes.
#[inline(never)]
pub(super) fn even(Row { mut swing, base, .. }: Row, codes: &mut [u16]) -> i32 {
    let mut sum = 0;
    let mut put = |code: &mut u16| sum += write(code, base + swing.take());
    let (eights, rest) = codes.as_chunks_mut::<8>();
    for eight in eights {
        eight.iter_mut().for_each(&mut put);
    }
    rest.iter_mut().for_each(&mut put);
    sum
}

/// The same, and its opposite.
#[inline(never)]
pub(super) fn even_both(Row { mut swing, base, twice }: Row, codes: &mut [u16], opposites: &mut [u16]) -> i32 {
    let mut sum = 0;
    let mut put = |(code, opposite): (&mut u16, &mut u16)| {
        sum += write(code, base + swing.take());
        *opposite = twice.wrapping_sub(*code);
    };
    let ((eights, rest), (opposite_eights, opposite_rest)) = (codes.as_chunks_mut::<8>(), opposites.as_chunks_mut::<8>());
    for (eight, opposites) in eights.iter_mut().zip(opposite_eights) {
        eight.iter_mut().zip(opposites).for_each(&mut put);
    }
    rest.iter_mut().zip(opposite_rest).for_each(&mut put);
    sum
}

/// Under an envelope that differs from sample to sample.
#[inline(never)]
pub(super) fn edge(Row { mut swing, base, .. }: Row, levels: &[f32], codes: &mut [u16]) -> i32 {
    let mut sum = 0;
    let mut put = |(code, level): (&mut u16, &f32)| sum += write(code, base + level * swing.take());
    let ((eights, rest), (levels, last)) = (codes.as_chunks_mut::<8>(), levels.as_chunks::<8>());
    for (eight, levels) in eights.iter_mut().zip(levels) {
        eight.iter_mut().zip(levels).for_each(&mut put);
    }
    rest.iter_mut().zip(last).for_each(&mut put);
    sum
}

/// The same, and its opposite.
#[inline(never)]
pub(super) fn edge_both(row: Row, levels: &[f32], codes: &mut [u16], opposites: &mut [u16]) -> i32 {
    let Row { mut swing, base, twice } = row;
    let mut sum = 0;
    let mut put = |((code, opposite), level): ((&mut u16, &mut u16), &f32)| {
        sum += write(code, base + level * swing.take());
        *opposite = twice.wrapping_sub(*code);
    };
    let ((eights, rest), (levels, last)) = (codes.as_chunks_mut::<8>(), levels.as_chunks::<8>());
    let (opposite_eights, opposite_rest) = opposites.as_chunks_mut::<8>();
    for ((eight, opposites), levels) in eights.iter_mut().zip(opposite_eights).zip(levels) {
        eight.iter_mut().zip(opposites).zip(levels).for_each(&mut put);
    }
    rest.iter_mut().zip(opposite_rest).zip(last).for_each(&mut put);
    sum
}

/// Writes a code, and returns it.
#[inline(always)]
fn write(place: &mut u16, value: f32) -> i32 {
    let code = value as i32;
    *place = code as u16;
    code
}
