//! Codes of a plain sine in one lane, sample by sample, which is most of the time of a block. The
//! loops write four samples at a time, and repeat nothing that can be done once.
//!
//! A lane that is the opposite of another is written from it: its codes mirror the other's about
//! mid-code, to the last bit.

use crate::generate::shape::sine::Steps;
use crate::seam::fixed_point::upper;

/// Shift of a small coefficient of the steps.
const SMALL_SHIFT: u32 = 0;

/// Writes steps under an envelope of one. With `base`, truncation rounds to the nearest code.
/// Returns the sum of the codes.
#[inline(never)]
pub(super) fn even(mut steps: Steps, base: f32, codes: &mut [u16]) -> i32 {
    let (mut sum, base) = (0, fixed(base));
    let (fours, rest) = codes.as_chunks_mut::<4>();
    // Written out: a compiler that optimizes for size leaves a loop of four here.
    for [first, second, third, fourth] in fours {
        sum += step(first, &mut steps, base);
        sum += step(second, &mut steps, base);
        sum += step(third, &mut steps, base);
        sum += step(fourth, &mut steps, base);
    }
    for code in rest {
        sum += step(code, &mut steps, base);
    }
    sum
}

/// Writes steps under an envelope that varies from sample to sample, given as parts: 2^31 for the
/// largest level.
#[inline(never)]
pub(super) fn edge(mut steps: Steps, base: f32, parts: &[i32], codes: &mut [u16]) -> i32 {
    // A product with a level has one bit less.
    let (mut sum, base) = (0, fixed(base) >> 1);
    let ((fours, rest), (parts, last)) = (codes.as_chunks_mut::<4>(), parts.as_chunks::<4>());
    for ([first, second, third, fourth], [a, b, c, d]) in fours.iter_mut().zip(parts) {
        sum += level_step(first, *a, &mut steps, base);
        sum += level_step(second, *b, &mut steps, base);
        sum += level_step(third, *c, &mut steps, base);
        sum += level_step(fourth, *d, &mut steps, base);
    }
    for (code, part) in rest.iter_mut().zip(last) {
        sum += level_step(code, *part, &mut steps, base);
    }
    sum
}

/// Writes the opposites of codes about a mid-code, two at a time: neither half borrows from the
/// other, because opposites have 16 bits, too.
#[inline(never)]
pub(super) fn opposite(mid: u16, codes: &[u16], opposites: &mut [u16]) {
    let twice = u32::from(mid).wrapping_mul(2 * 0x1_0001);
    let both = |first: u16, second: u16| {
        let both = twice.wrapping_sub(u32::from(first) | u32::from(second) << 16);
        (both as u16, (both >> 16) as u16)
    };
    let ((fours, rest), (opposite_fours, opposite_rest)) = (codes.as_chunks::<4>(), opposites.as_chunks_mut::<4>());
    for ([a, b, c, d], [first, second, third, fourth]) in fours.iter().zip(opposite_fours) {
        (*first, *second) = both(*a, *b);
        (*third, *fourth) = both(*c, *d);
    }
    for (code, opposite) in rest.iter().zip(opposite_rest) {
        *opposite = both(*code, 0).0;
    }
}

/// Converts codes to the scale of the steps.
#[inline(always)]
fn fixed(codes: f32) -> u32 {
    (codes * (1 << Steps::FRACTION_BITS) as f32) as u32
}

/// Writes the next code, and returns it.
#[inline(always)]
fn step(place: &mut u16, steps: &mut Steps, base: u32) -> i32 {
    let code = base.wrapping_add(steps.take::<SMALL_SHIFT>() as u32) >> Steps::FRACTION_BITS;
    *place = code as u16;
    code as i32
}

/// Writes the next code at a part of the largest level, and returns it.
#[inline(always)]
fn level_step(place: &mut u16, part: i32, steps: &mut Steps, base: u32) -> i32 {
    let swung = upper(steps.take::<SMALL_SHIFT>(), part);
    let code = base.wrapping_add(swung as u32) >> (Steps::FRACTION_BITS - 1);
    *place = code as u16;
    code as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::nco::{Stretch, tuning_word};
    use crate::generate::shape::sine::Steady;
    use crate::seam::phasor::Phasor;

    /// The opposite of a lane equals its own sine, except for the few codes near a rounding
    /// boundary.
    #[test]
    fn an_opposite_equals_its_own_sine() {
        let parts = core::array::from_fn::<i32, 64, _>(|n| (n as i32) << 25);
        let (mut different, mut all) = (0, 0);
        for trial in 0..2000u64 {
            // All lengths, so that the remainder is written, too; codes of 12 and of 16 bits.
            let samples = 25 + trial as usize % 40;
            let (mid, amplitude) = if trial % 2 == 0 { (2048, 1500.0) } else { (32_768, 32_000.0) };
            let phase = trial.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let steady = Steady::new(&Stretch { phase, word: tuning_word(0.0404), step: 0 });
            let of = |amplitude: f32| steady.swing(Phasor::new(amplitude, 0.0)).steps().0;
            let ([mut lane, mut opposites, mut own], parts) = ([[0; 64]; 3], &parts[..samples]);
            let (lane, opposites, own) = (&mut lane[..samples], &mut opposites[..samples], &mut own[..samples]);
            let base = f32::from(mid) + 0.5;
            for flat in [true, false] {
                let sum = if flat { even(of(amplitude), base, lane) } else { edge(of(amplitude), base, parts, lane) };
                let _ = if flat { even(of(-amplitude), base, own) } else { edge(of(-amplitude), base, parts, own) };
                opposite(mid, lane, opposites);
                assert_eq!(sum, lane.iter().map(|&code| i32::from(code)).sum::<i32>());
                assert!(lane.iter().zip(&*opposites).all(|(a, b)| u32::from(*a) + u32::from(*b) == 2 * u32::from(mid)));
                assert!(opposites.iter().zip(&*own).all(|(a, b)| a.abs_diff(*b) <= 1));
                different += opposites.iter().zip(&*own).filter(|(a, b)| a != b).count();
                all += samples;
            }
        }
        // Codes differ only if the exact value is near half a code.
        assert!(different < 100 && all == 178_000, "{different} of {all}");
    }
}
