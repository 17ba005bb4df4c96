//! Batched sine and cosine; see [`sine_cosine`](crate::turn::sine_cosine).

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, u64x8};

use super::vector::{Vector, all};
use crate::turn::{COSINE, ROUNDING_OFFSET, SINE};

/// Returns sine and cosine of each angle.
#[inline(always)]
pub(super) fn sine_cosine<S: Simd>(turns: Vector<S>) -> (Vector<S>, Vector<S>) {
    let quarters = turns * 4.0 + ROUNDING_OFFSET;
    let angle = (turns - (quarters - ROUNDING_OFFSET) * 0.25) * std::f64::consts::TAU;
    let square = angle * angle;
    let sine = angle + angle * square * series(&SINE, square);
    let cosine = (all(turns.simd, 1.0) - square * 0.5) + square * square * series(&COSINE, square);
    let quarter = quarters.to_bits();
    let odd = (quarter & 1).simd_eq(1);
    (flip(odd.select(cosine, sine), quarter), flip(odd.select(sine, cosine), quarter + 1))
}

/// Changes the sign in the third and fourth quarter.
#[inline(always)]
fn flip<S: Simd>(value: Vector<S>, quarter: u64x8<S>) -> Vector<S> {
    (value.to_bits() ^ ((quarter & 2) << 62)).bitcast()
}

#[inline(always)]
fn series<S: Simd>(c: &[f64], x: Vector<S>) -> Vector<S> {
    let square = x * x;
    let even = ((square * c[6] + c[4]) * square + c[2]) * square + c[0];
    let odd = (square * c[5] + c[3]) * square + c[1];
    even + x * odd
}
