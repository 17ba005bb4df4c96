//! Functions in lanes, for the arguments that occur: not for all, and therefore short.
//!
//! `wide` has an exponential of its own, as precise, which also looks after overflow, NaN and rounding to even; here the arguments are
//! between -inf and zero. The tests print both errors, and the test `cost` both times.

use wide::bytemuck::cast;
use wide::{f64x4, i64x4};

/// Numbers abreast, and their bits.
pub(super) type Lanes = f64x4;
type Bits = i64x4;

/// 1.5 2^52: added, it leaves the nearest whole number in the lowest bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// ln 2 in two parts; the first has room for eleven bits more, so that its multiples are exact (fdlibm's e_exp.c).
const LN_2: (f64, f64) = (0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10);

/// `exp(x)` for x <= 0, to two units in the last place; below -700, exp(-700).
#[inline]
pub(super) fn exponential(x: Lanes) -> Lanes {
    let x = x.fast_max(Lanes::splat(-700.0));
    let whole = x * std::f64::consts::LOG2_E + WHOLE;
    let n = whole - WHOLE;
    let r = x - n * LN_2.0 - n * LN_2.1;
    // 2^n: its exponent is added to that of the sum
    let bits: Bits = cast(whole);
    cast(cast::<Lanes, Bits>(1.0 + r * over_factorials(r)) + (bits << 52))
}

/// `exp(x) - 1` for x <= 0, without cancelling.
#[inline]
pub(super) fn less_one(x: Lanes) -> Lanes {
    let small = x.simd_gt(Lanes::splat(-0.35));
    if small.all() {
        return x * over_factorials(x);
    }
    if !small.any() {
        return exponential(x) - 1.0;
    }
    small.select(x * over_factorials(x), exponential(x) - 1.0)
}

/// `(exp(r) - 1) / r` for |r| <= 0.35: of the next term, 2e-18 of the sum is left. Even and odd powers apart.
#[inline]
fn over_factorials(r: Lanes) -> Lanes {
    const TERMS: usize = 14;
    const OVER: [f64; TERMS] = {
        let mut out = [1.0; TERMS];
        let mut k = 1;
        while k < TERMS {
            out[k] = out[k - 1] / (k + 1) as f64;
            k += 1;
        }
        out
    };
    let square = r * r;
    let (mut even, mut odd) = (Lanes::splat(OVER[TERMS - 2]), Lanes::splat(OVER[TERMS - 1]));
    for k in (0..TERMS / 2 - 1).rev() {
        even = even * square + OVER[2 * k];
        odd = odd * square + OVER[2 * k + 1];
    }
    even + r * odd
}

/// `acos(x)` for 0 <= x <= 1, as `2 asin(sqrt((1 - x) / 2))`: relative error of round-off up to x = 1.
#[inline]
pub(super) fn arc_cosine(x: Lanes) -> Lanes {
    ((1.0 - x) * 0.5).sqrt().asin() * 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest relative error over arguments, four at a time.
    fn worst(of: impl Fn(Lanes) -> Lanes, exact: impl Fn(f64) -> f64, arguments: &[f64]) -> f64 {
        let mut worst = 0.0f64;
        for &x in arguments {
            for got in of(Lanes::splat(x)).to_array() {
                worst = worst.max((got / exact(x) - 1.0).abs());
            }
        }
        worst
    }

    #[test]
    fn as_precise_as_the_standard_library() {
        let many: Vec<f64> = (1..400_000).map(|i| -f64::from(i) * 1e-4).chain((1..300).map(|i| -2f64.powi(-i))).collect();
        let [exp, less, wides] =
            [worst(exponential, f64::exp, &many), worst(less_one, f64::exp_m1, &many), worst(Lanes::exp, f64::exp, &many)];
        println!("exp {exp:e} (wide's own {wides:e}), exp - 1 {less:e}");
        assert!(exp < 5e-16 && less < 7e-16, "{exp:e} {less:e}");
        assert!(exponential(Lanes::splat(-1e12)).to_array().iter().all(|x| *x < 1e-300));
        let angles: Vec<f64> = (0..100_000).map(|i| f64::from(i) * 1e-5).chain((2..53).map(|i| 1.0 - 2f64.powi(-i))).collect();
        let exact = |x: f64| ((1.0 - x) * (1.0 + x)).sqrt().atan2(x);
        let angle = worst(arc_cosine, exact, &angles);
        println!("acos {angle:e}");
        assert!(angle < 7e-16, "{angle:e}");
    }
}
