//! `exp(-x)` at the places of a step, as [`decay`](super::super::decay) has it.

use fearless_simd::{Bytes, Select, Simd, SimdBase, SimdFloat, SimdMask};

use super::super::decay::{INVERSE, LEAST, LN_2, SHORT};
use super::vector::{Each, Which, all};
use crate::turn::WHOLE;

/// `exp(-x)` of the contacts that are `on`, at all their places: by the short series where all of a contact's are short.
#[inline(always)]
pub(super) fn decay<S: Simd, const P: usize>(x: &[Each<S>; P], on: Which<S>) -> [Each<S>; P] {
    let mut long = x[0].abs().simd_gt(SHORT);
    for x in &x[1..] {
        long |= x.abs().simd_gt(SHORT);
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

/// As [`exponential`](super::super::decay::exponential).
#[inline(always)]
fn exponential<S: Simd>(x: Each<S>) -> Each<S> {
    let y = -x;
    let y = y.simd_lt(SHORT).select(y, all(x.simd, SHORT));
    let y = y.simd_gt(LEAST).select(y, all(x.simd, LEAST));
    let whole = y * std::f64::consts::LOG2_E + WHOLE;
    let n = whole - WHOLE;
    let small = series(-(y - n * LN_2.0 - n * LN_2.1));
    (small.to_bits() + (whole.to_bits() << 52)).bitcast()
}

#[inline(always)]
fn series<S: Simd>(x: Each<S>) -> Each<S> {
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = pair(x, 0) + x2 * pair(x, 2);
    let low = low + x4 * (pair(x, 4) + x2 * pair(x, 6));
    let high = pair(x, 8) + x2 * pair(x, 10) + x4 * pair(x, 12);
    low + (x4 * x4) * high
}

#[inline(always)]
fn pair<S: Simd>(x: Each<S>, even: usize) -> Each<S> {
    all(x.simd, INVERSE[even]) - x * INVERSE[even + 1]
}
