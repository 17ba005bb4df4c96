//! Batched search for the reversals of eight contacts within a part; see
//! [`first_reversal`](crate::method::polynomial::first_reversal).
//!
//! The usual cases are batched: no reversal, or one between a beginning and an end of opposite
//! sign. The scalar search handles dips, and slips that begin at zero.

use fearless_simd::{Select, Simd, SimdBase, SimdFloat, SimdMask};

use super::vector::{Mask, Vector, all, numbers, slope, times_k, value};
use crate::method::polynomial::{QUADRATIC_STEP_RATIO, SECTIONS, first_reversal};

/// Returns the contacts in `on` that reverse, and the moments.
#[inline(always)]
pub(super) fn reversals<S: Simd, const N: usize>(
    velocity: &[Vector<S>; N],
    sense: Vector<S>,
    enough: f64,
    on: Mask<S>,
) -> (Mask<S>, Vector<S>) {
    let simd = sense.simd;
    let one = all(simd, 1.0);
    let end = value(velocity, one);
    let crosses = on & (sense * end).simd_lt(0.0);
    let plain = crosses & (sense * velocity[0]).simd_gt(0.0);
    // No term can lower the value by more than its own size.
    let mut fall = all(simd, -0.0);
    for c in &velocity[1..] {
        let term = sense * *c;
        fall += term.simd_lt(0.0).select(term, all(simd, 0.0));
    }
    let stays = (sense * velocity[0] + fall).simd_gt(0.0);
    let mut odd = crosses & !plain;
    let unsure = on & !crosses & !stays;
    if unsure.any_true() {
        odd |= unsure & may_dip(velocity, sense);
    }
    let (mut reverses, mut at) = (plain, one);
    if plain.any_true() {
        at = plain.select(root(velocity, end, enough, plain), at);
    }
    for number in numbers(odd) {
        let alone: [f64; N] = std::array::from_fn(|k| velocity[k][number]);
        if let Some(when) = first_reversal(&alone, sense[number], enough) {
            reverses.set(number, true);
            at[number] = when;
        }
    }
    (reverses, at)
}

/// Returns the contacts that may reverse although the ends do not show it.
#[inline(always)]
fn may_dip<S: Simd, const N: usize>(velocity: &[Vector<S>; N], sense: Vector<S>) -> Mask<S> {
    let slopes = times_k(velocity);
    let mut low = sense * velocity[1];
    let mut dips = sense.simd_lt(all(sense.simd, f64::NEG_INFINITY));
    for part in 1..=SECTIONS {
        let at = all(sense.simd, f64::from(part) / f64::from(SECTIONS));
        let high = sense * slope(&slopes, at);
        dips |= (sense * value(velocity, at)).simd_lt(0.0) | (low.simd_lt(0.0) & high.simd_gt(0.0));
        low = high;
    }
    dips
}

/// Returns the roots between 0 and 1 of polynomials that have the values `last` at 1.
#[inline(always)]
fn root<S: Simd, const N: usize>(c: &[Vector<S>; N], last: Vector<S>, enough: f64, on: Mask<S>) -> Vector<S> {
    let simd = last.simd;
    let (zero, half) = (all(simd, 0.0), all(simd, 0.5));
    let (mut low, mut high, first) = (zero, all(simd, 1.0), c[0]);
    let falls = first.simd_gt(0.0);
    let steep = c[1] * (high - low);
    let bend = last - first - steep;
    let square = steep * steep - bend * 4.0 * first;
    let under = square.simd_gt(0.0).select(square, zero).sqrt().copysign(steep);
    let far = (steep + under) * -0.5;
    let (near, other) = (first / far, far / bend);
    let part = is_inside(near).select(near, is_inside(other).select(other, half));
    let mut s = low + (high - low) * part;
    let mut slopes: [Vector<S>; N] = [zero; N];
    for k in 1..N {
        slopes[k - 1] = c[k] * k as f64;
    }
    let (mut before, mut found, mut left) = (all(simd, f64::INFINITY), s, on);
    for _ in 0..80 {
        let here = value(c, s);
        let above = here.simd_gt(0.0).simd_eq(falls);
        low = above.select(s, low);
        high = above.select(high, s);
        let newton = s - here / value(&slopes, s);
        let inside = newton.simd_ge(low) & newton.simd_le(high);
        let next = inside.select(newton, (low + high) * 0.5);
        let step = (next - s).abs();
        let squares = step.simd_le(before * QUADRATIC_STEP_RATIO) | step.simd_le(enough * enough);
        let done = (inside & step.simd_le(enough) & squares) | (high - low).simd_le(2e-16);
        (s, before) = (next, step);
        found = left.select(s, found);
        left &= !done;
        if !left.any_true() {
            break;
        }
    }
    found
}

#[inline(always)]
fn is_inside<S: Simd>(part: Vector<S>) -> Mask<S> {
    part.simd_gt(0.0) & part.simd_lt(1.0)
}
