//! Sums, products, quotients, roots, comparison.

use super::number::{Finite, Number, SINGLE, infinity, invalid, is_nan, propagate, round, shift_sticky, unpack, zero};
use super::{DZC, IOC, Rounding, as_host, is_plain};

fn finish(number: Finite, fpscr: &mut u32) -> u32 {
    round(number, SINGLE, Rounding::from_fpscr(*fpscr), fpscr)
}

/// Inverts the sign, also of a NaN.
#[inline]
pub(crate) fn negate(bits: u32) -> u32 {
    bits ^ 1 << 31
}

/// Returns the exact sum of two numbers, rounded. A sum of zero is negative if both are, or if the
/// mode rounds down.
fn sum(x: Finite, y: Finite, fpscr: &mut u32) -> u32 {
    let vanishing = if x.negative == y.negative { x.negative } else { Rounding::from_fpscr(*fpscr) == Rounding::Down };
    let normal = |number: Finite| {
        let by = number.significand.leading_zeros() - 2;
        Finite { significand: number.significand << by, exponent: number.exponent - by as i32, ..number }
    };
    match (x.significand, y.significand) {
        (0, 0) => return zero(vanishing),
        (0, _) => return finish(y, fpscr),
        (_, 0) => return finish(x, fpscr),
        _ => {}
    }
    let (x, y) = (normal(x), normal(y));
    let (big, small) = if (x.exponent, x.significand) >= (y.exponent, y.significand) { (x, y) } else { (y, x) };
    let small_digits = shift_sticky(small.significand, (big.exponent - small.exponent) as u32);
    let significand = match big.negative == small.negative {
        true => big.significand + small_digits,
        false => big.significand - small_digits,
    };
    match significand {
        0 => zero(vanishing),
        significand => finish(Finite { significand, ..big }, fpscr),
    }
}

fn add_exactly(a: u32, b: u32, fpscr: &mut u32) -> u32 {
    match (unpack(a, fpscr), unpack(b, fpscr)) {
        (Number::Finite(x), Number::Finite(y)) => sum(x, y, fpscr),
        (Number::Infinite { negative: x }, Number::Infinite { negative: y }) if x != y => invalid(fpscr),
        (Number::Infinite { negative }, _) | (_, Number::Infinite { negative }) => infinity(negative),
        _ => unreachable!("NaNs are propagated earlier"),
    }
}

/// `FPAdd`
#[inline]
pub(crate) fn add(a: u32, b: u32, fpscr: &mut u32) -> u32 {
    let result = f32::from_bits(a) + f32::from_bits(b);
    // A sum that is zero or subnormal is exact.
    if as_host(*fpscr) && result.is_finite() {
        return result.to_bits();
    }
    if is_nan(a) || is_nan(b) { propagate(&[a, b], fpscr) } else { add_exactly(a, b, fpscr) }
}

/// `FPSub`
#[inline]
pub(crate) fn subtract(a: u32, b: u32, fpscr: &mut u32) -> u32 {
    let result = f32::from_bits(a) - f32::from_bits(b);
    if as_host(*fpscr) && result.is_finite() {
        return result.to_bits();
    }
    if is_nan(a) || is_nan(b) { propagate(&[a, b], fpscr) } else { add_exactly(a, negate(b), fpscr) }
}

/// `FPMul`
#[inline]
pub(crate) fn multiply(a: u32, b: u32, fpscr: &mut u32) -> u32 {
    let result = f32::from_bits(a) * f32::from_bits(b);
    if as_host(*fpscr) && (is_plain(result) || (a << 1 == 0 || b << 1 == 0) && result == 0.0) {
        return result.to_bits();
    }
    if is_nan(a) || is_nan(b) {
        return propagate(&[a, b], fpscr);
    }
    let negative = (a ^ b) >> 31 == 1;
    match (unpack(a, fpscr), unpack(b, fpscr)) {
        (Number::Finite(x), Number::Finite(y)) => match x.significand * y.significand {
            0 => zero(negative),
            significand => finish(Finite { negative, exponent: x.exponent + y.exponent, significand }, fpscr),
        },
        (Number::Finite(x), _) | (_, Number::Finite(x)) if x.significand == 0 => invalid(fpscr),
        _ => infinity(negative),
    }
}

/// `FPDiv`
#[inline]
pub(crate) fn divide(a: u32, b: u32, fpscr: &mut u32) -> u32 {
    let result = f32::from_bits(a) / f32::from_bits(b);
    if as_host(*fpscr) && is_plain(result) {
        return result.to_bits();
    }
    if is_nan(a) || is_nan(b) {
        return propagate(&[a, b], fpscr);
    }
    let negative = (a ^ b) >> 31 == 1;
    match (unpack(a, fpscr), unpack(b, fpscr)) {
        (Number::Finite(x), Number::Finite(y)) => match (x.significand, y.significand) {
            (0, 0) => invalid(fpscr),
            (0, _) => zero(negative),
            (_, 0) => {
                *fpscr |= DZC;
                infinity(negative)
            }
            (dividend, divisor) => {
                let wide = dividend << 64;
                let significand = (wide / divisor) | u128::from(wide % divisor != 0);
                finish(Finite { negative, exponent: x.exponent - y.exponent - 64, significand }, fpscr)
            }
        },
        (Number::Infinite { .. }, Number::Infinite { .. }) => invalid(fpscr),
        (Number::Infinite { .. }, _) => infinity(negative),
        _ => zero(negative),
    }
}

/// `FPSqrt`
#[inline]
pub(crate) fn square_root(a: u32, fpscr: &mut u32) -> u32 {
    let result = f32::from_bits(a).sqrt();
    if as_host(*fpscr) && is_plain(result) {
        return result.to_bits();
    }
    if is_nan(a) {
        return propagate(&[a], fpscr);
    }
    match unpack(a, fpscr) {
        Number::Finite(x) if x.significand == 0 => zero(x.negative),
        Number::Infinite { negative: false } => infinity(false),
        Number::Finite(x) if !x.negative => {
            // An even exponent, and more than twice the digits of the root.
            let by = 80 + (x.exponent & 1);
            let wide = x.significand << by;
            let root = wide.isqrt();
            let significand = root << 1 | u128::from(root * root != wide);
            finish(Finite { negative: false, exponent: (x.exponent - by) / 2 - 1, significand }, fpscr)
        }
        _ => invalid(fpscr),
    }
}

/// `FPMulAdd`: `addend + a · b` with one rounding.
#[inline]
pub(crate) fn multiply_add(addend: u32, a: u32, b: u32, fpscr: &mut u32) -> u32 {
    if as_host(*fpscr) {
        let result = f32::from_bits(a).mul_add(f32::from_bits(b), f32::from_bits(addend));
        if is_plain(result) {
            return result.to_bits();
        }
    }
    let negative = (a ^ b) >> 31 == 1;
    if is_nan(addend) || is_nan(a) || is_nan(b) {
        let result = propagate(&[addend, a, b], fpscr);
        // Infinity times zero is invalid even if the addend is a quiet NaN.
        let (a, b) = (unpack(a, fpscr), unpack(b, fpscr));
        let is_zero = |number| matches!(number, Number::Finite(Finite { significand: 0, .. }));
        let is_infinite = |number| matches!(number, Number::Infinite { .. });
        let without_product = is_zero(a) && is_infinite(b) || is_infinite(a) && is_zero(b);
        return if without_product { invalid(fpscr) } else { result };
    }
    let product = match (unpack(a, fpscr), unpack(b, fpscr)) {
        (Number::Finite(x), Number::Finite(y)) => {
            Number::Finite(Finite { negative, exponent: x.exponent + y.exponent, significand: x.significand * y.significand })
        }
        (Number::Finite(x), _) | (_, Number::Finite(x)) if x.significand == 0 => Number::Nan,
        _ => Number::Infinite { negative },
    };
    match (unpack(addend, fpscr), product) {
        (_, Number::Nan) => invalid(fpscr),
        (Number::Infinite { negative: x }, Number::Infinite { negative: y }) if x != y => invalid(fpscr),
        (Number::Infinite { negative }, _) | (_, Number::Infinite { negative }) => infinity(negative),
        (Number::Finite(x), Number::Finite(y)) => sum(x, y, fpscr),
        (Number::Nan, _) => unreachable!("NaNs are propagated earlier"),
    }
}

/// `FPCompare`: returns N, Z, C, V in the lowest four bits.
pub(crate) fn compare(a: u32, b: u32, signal: bool, fpscr: &mut u32) -> u32 {
    if is_nan(a) || is_nan(b) {
        let _ = propagate(&[a, b], fpscr);
        if signal {
            *fpscr |= IOC;
        }
        return 0b0011;
    }
    let value = |bits, fpscr: &mut u32| match unpack(bits, fpscr) {
        Number::Finite(Finite { significand: 0, .. }) => 0.0,
        _ => f32::from_bits(bits),
    };
    let (a, b) = (value(a, fpscr), value(b, fpscr));
    if a == b {
        0b0110
    } else if a < b {
        0b1000
    } else {
        0b0010
    }
}
