//! Batched `exp(-x)` at the evaluation points of a step; see [`decay`](super::super::decay).

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdMask};

use super::super::decay::{INVERSE, LN_2_HIGH, LN_2_LOW, SERIES_LIMIT, SMALLEST_EXPONENT};
use super::vector::{Mask, Vector, all};
use crate::turn::ROUNDING_OFFSET;

/// Returns `exp(-x)` at all evaluation points of the contacts in `on`: by the short series if all
/// exponents of a contact are small.
#[inline(always)]
pub(super) fn decay<S: Simd, const P: usize>(x: &[Vector<S>; P], on: Mask<S>) -> [Vector<S>; P] {
    let mut long = x[0].abs().simd_gt(SERIES_LIMIT);
    for x in &x[1..] {
        long |= x.abs().simd_gt(SERIES_LIMIT);
    }
    let long = long & on;
    let mut out = *x;
    for k in 0..P {
        out[k] = series(x[k]);
    }
    if long.any_true() {
        for k in 0..P {
            out[k] = long.select(exponential(x[k]), out[k]);
        }
    }
    out
}

/// Batched [`exponential`](super::super::decay::exponential).
#[inline(always)]
fn exponential<S: Simd>(x: Vector<S>) -> Vector<S> {
    let y = -x;
    let y = y.simd_lt(SERIES_LIMIT).select(y, all(x.simd, SERIES_LIMIT));
    let y = y.simd_gt(SMALLEST_EXPONENT).select(y, all(x.simd, SMALLEST_EXPONENT));
    let whole = y * std::f64::consts::LOG2_E + ROUNDING_OFFSET;
    let n = whole - ROUNDING_OFFSET;
    let small = series(-(y - n * LN_2_HIGH - n * LN_2_LOW));
    (small.to_bits() + (whole.to_bits() << 52)).bitcast()
}

#[inline(always)]
fn series<S: Simd>(x: Vector<S>) -> Vector<S> {
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = pair(x, 0) + x2 * pair(x, 2);
    let low = low + x4 * (pair(x, 4) + x2 * pair(x, 6));
    let high = pair(x, 8) + x2 * pair(x, 10) + x4 * pair(x, 12);
    low + (x4 * x4) * high
}

#[inline(always)]
fn pair<S: Simd>(x: Vector<S>, even: usize) -> Vector<S> {
    all(x.simd, INVERSE[even]) - x * INVERSE[even + 1]
}
