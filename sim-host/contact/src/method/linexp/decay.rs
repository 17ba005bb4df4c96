//! `exp(-x)` of several numbers at once, for small exponents.
//!
//! The slip of one step is usually a fraction of the Dahl length, so the short series suffices: it
//! evaluates all lanes at once, without a function call.

use super::simd_nodes::SimdNodes;
use crate::turn::ROUNDING_OFFSET;

/// Largest exponent of the series, which is then accurate to a few units of the last place: the
/// next term is below 1e-15.
pub(super) const SERIES_LIMIT: f64 = 0.5;

/// Smallest exponent; below it the result counts as zero.
pub(super) const SMALLEST_EXPONENT: f64 = -700.0;
/// Upper part of ln 2; its lowest eleven bits are free, so that its multiples are exact (fdlibm's
/// e_exp.c).
pub(super) const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
/// Lower part of ln 2.
pub(super) const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// Returns `exp(-x)` of each number. A slip against its sign is round-off, so the result is limited
/// to `exp(0.5)`; an infinite factor would turn zero into NaN.
#[inline]
pub(super) fn decay<L: SimdNodes>(x: L) -> L {
    if (0..=L::END).any(|lane| x.lane(lane).abs() > SERIES_LIMIT) {
        return exponential(x);
    }
    series(x)
}

/// Returns `exp(-x)` by powers of two and the series: to two units of the last place, and at least
/// `exp(-700)`.
#[inline]
fn exponential<L: SimdNodes>(x: L) -> L {
    let y = (L::all(0.0) - x).at_most(SERIES_LIMIT).at_least(SMALLEST_EXPONENT);
    let whole = y * L::all(std::f64::consts::LOG2_E) + L::all(ROUNDING_OFFSET);
    let n = whole - L::all(ROUNDING_OFFSET);
    let r = y - n * L::all(LN_2_HIGH) - n * L::all(LN_2_LOW);
    series(L::all(0.0) - r).times_two_to(whole)
}

#[inline]
fn series<L: SimdNodes>(x: L) -> L {
    // Series up to the thirteenth power, in pairs (Estrin) for short chains.
    let pair = |even: usize| L::all(INVERSE[even]) - x * L::all(INVERSE[even + 1]);
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = pair(0) + x2 * pair(2);
    let low = low + x4 * (pair(4) + x2 * pair(6));
    let high = pair(8) + x2 * pair(10) + x4 * pair(12);
    low + (x4 * x4) * high
}

/// Reciprocal factorials.
pub(super) const INVERSE: [f64; 14] = {
    let mut inverse = [1.0; 14];
    let mut k = 1;
    while k < 14 {
        inverse[k] = inverse[k - 1] / k as f64;
        k += 1;
    }
    inverse
};

#[cfg(test)]
mod tests {
    use wide::f64x4;

    use super::*;

    #[test]
    fn decay_equals_the_exponential() {
        for n in -100..=2000 {
            let x = 0.005 * f64::from(n);
            let got = decay(f64x4::new([x, 0.1, x, 0.0])).to_array();
            assert!((got[0] / (-x).exp() - 1.0).abs() < 2e-15, "{x}");
            assert!((got[1] / (-0.1f64).exp() - 1.0).abs() < 2e-15 && (got[3] - 1.0).abs() < 2e-16);
        }
        for x in [30.0, 300.0, 690.0, 5e3, f64::INFINITY] {
            let got = decay(f64x4::splat(x)).to_array()[2];
            assert!((got / (-x).exp() - 1.0).abs() < 2e-15 || (x > 700.0 && got < 1e-300), "{x}: {got:e}");
        }
    }
}
