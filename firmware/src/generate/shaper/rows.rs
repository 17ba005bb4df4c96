//! The codes of one lane, sample by sample: where a block spends most of its time. Eight samples at a time, and without anything that could be done once.
//!
//! A lane that is the opposite of another is written with it: its codes are the other's about mid-code, to the last bit.

use crate::generate::shape::sine::{Coefficient, Steps, Swing};

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
pub(super) fn even(row: Row, codes: &mut [u16]) -> i32 {
    match row.swing.steps() {
        (steps, false) => even_of::<0>(steps, row.base, codes),
        (steps, true) => even_of::<{ Coefficient::SHIFT }>(steps, row.base, codes),
    }
}

#[inline(always)]
fn even_of<const SHIFT: u32>(mut steps: Steps, base: f32, codes: &mut [u16]) -> i32 {
    let (mut sum, base) = (0, fixed(base));
    let mut put = |code: &mut u16| sum += step::<SHIFT>(code, &mut steps, base);
    let (eights, rest) = codes.as_chunks_mut::<8>();
    for eight in eights {
        eight.iter_mut().for_each(&mut put);
    }
    rest.iter_mut().for_each(&mut put);
    sum
}

/// The same, and its opposite.
#[inline(never)]
pub(super) fn even_both(row: Row, codes: &mut [u16], opposites: &mut [u16]) -> i32 {
    match row.swing.steps() {
        (steps, false) => even_both_of::<0>(steps, &row, codes, opposites),
        (steps, true) => even_both_of::<{ Coefficient::SHIFT }>(steps, &row, codes, opposites),
    }
}

#[inline(always)]
fn even_both_of<const SHIFT: u32>(mut steps: Steps, row: &Row, codes: &mut [u16], opposites: &mut [u16]) -> i32 {
    let (mut sum, base, twice) = (0, fixed(row.base), row.twice);
    let mut put = |(code, opposite): (&mut u16, &mut u16)| {
        sum += step::<SHIFT>(code, &mut steps, base);
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

/// A number of codes, as large as the steps are.
#[inline(always)]
fn fixed(codes: f32) -> u32 {
    (codes * (1 << Steps::FRACTION) as f32) as u32
}

/// Writes the next code, and returns it.
#[inline(always)]
fn step<const SHIFT: u32>(place: &mut u16, steps: &mut Steps, base: u32) -> i32 {
    let code = base.wrapping_add(steps.take::<SHIFT>() as u32) >> Steps::FRACTION;
    *place = code as u16;
    code as i32
}

/// Writes a code, and returns it.
#[inline(always)]
fn write(place: &mut u16, value: f32) -> i32 {
    let code = value as i32;
    *place = code as u16;
    code
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::nco::{Stretch, tuning_word};
    use crate::generate::shape::sine::Steady;
    use crate::seam::phasor::Phasor;

    /// The opposite of a lane is what its own sine would be, but for the few codes that lie between two.
    #[test]
    fn an_opposite_is_its_own_sine() {
        let (mid, levels) = (2048, core::array::from_fn::<f32, 64, _>(|n| n as f32 / 64.0));
        let (mut different, mut all) = (0, 0);
        for trial in 0..2000u64 {
            // Of all lengths, so that the last few are written, too.
            let samples = 25 + trial as usize % 40;
            let phase = trial.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let steady = Steady::new(&Stretch { phase, word: tuning_word(0.0404), step: 0 });
            let of = |amplitude: f32| Row { swing: steady.swing(Phasor::new(amplitude, 0.0)), base: 2048.5, twice: 2 * mid };
            let ([mut lane, mut opposite, mut own], levels) = ([[0; 64]; 3], &levels[..samples]);
            let (lane, opposite, own) = (&mut lane[..samples], &mut opposite[..samples], &mut own[..samples]);
            for flat in [true, false] {
                let sums = if flat {
                    (even_both(of(1500.0), lane, opposite), even(of(-1500.0), own))
                } else {
                    (edge_both(of(1500.0), levels, lane, opposite), edge(of(-1500.0), levels, own))
                };
                let sum = |codes: &[u16]| codes.iter().map(|&code| i32::from(code)).sum::<i32>();
                assert_eq!(sums, (sum(lane), sum(own)));
                assert!(lane.iter().zip(&*opposite).all(|(a, b)| a + b == 2 * mid));
                assert!(opposite.iter().zip(&*own).all(|(a, b)| a.abs_diff(*b) <= 1));
                different += opposite.iter().zip(&*own).filter(|(a, b)| a != b).count();
                all += samples;
            }
        }
        // Measured: 39 of 178 000, where rounding meets half a code.
        assert!(different < 45 && all == 178_000, "{different} of {all}");
    }
}
