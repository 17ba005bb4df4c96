//! `exp(-x)` of several numbers at once, for exponents that are small.
//!
//! The slip of one step is a fraction of the Dahl length, so the short series is the usual way: all lanes at once, and nothing to call.

use super::simd_nodes::SimdNodes;
use crate::turn::WHOLE;

/// Up to here the series is good to a few units of the last place: the term left out is below 1e-15.
pub(super) const SHORT: f64 = 0.5;

/// Below this all is as good as nothing.
pub(super) const LEAST: f64 = -700.0;
/// ln 2 in two parts; the first has room for eleven bits more, so that its multiples are exact (fdlibm's e_exp.c).
pub(super) const LN_2: (f64, f64) = (0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10);

/// `exp(-x)` of each. A slip against its sign is round-off: it does not grow beyond `exp(0.5)`, so that nothing times it is nothing.
#[inline]
pub(super) fn decay<L: SimdNodes>(x: L) -> L {
    if (0..=L::END).any(|lane| x.lane(lane).abs() > SHORT) {
        return exponential(x);
    }
    series(x)
}

/// `exp(-x)` by powers of two and the series: to two units of the last place, and no less than `exp(-700)`.
#[inline]
fn exponential<L: SimdNodes>(x: L) -> L {
    let y = (L::all(0.0) - x).at_most(SHORT).at_least(LEAST);
    let whole = y * L::all(std::f64::consts::LOG2_E) + L::all(WHOLE);
    let n = whole - L::all(WHOLE);
    let r = y - n * L::all(LN_2.0) - n * L::all(LN_2.1);
    series(L::all(0.0) - r).times_two_to(whole)
}

#[inline]
fn series<L: SimdNodes>(x: L) -> L {
    // The series to the thirteenth power, in pairs (Estrin) for short chains.
    let pair = |even: usize| L::all(INVERSE[even]) - x * L::all(INVERSE[even + 1]);
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = pair(0) + x2 * pair(2);
    let low = low + x4 * (pair(4) + x2 * pair(6));
    let high = pair(8) + x2 * pair(10) + x4 * pair(12);
    low + (x4 * x4) * high
}

/// One over the factorial.
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
    fn it_is_the_exponential() {
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
