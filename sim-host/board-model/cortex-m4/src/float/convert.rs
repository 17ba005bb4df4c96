//! Conversions: integers, fixed point, half precision.

use super::number::{
    DEFAULT_NAN, Finite, HALF, INFINITY, Number, SINGLE, infinity, is_nan, propagate, round, rounds_up, unpack, zero,
};
use super::{AHP, DN, IOC, IXC, Rounding};

/// `FixedToFP`: converts the lowest 16 or 32 bits with `fraction` bits below the point.
pub(crate) fn from_fixed(value: u32, signed: bool, half: bool, fraction: u8, mode: Rounding, fpscr: &mut u32) -> u32 {
    let value = match (signed, half) {
        (true, true) => i64::from(value as i16),
        (true, false) => i64::from(value as i32),
        (false, true) => i64::from(value as u16),
        (false, false) => i64::from(value),
    };
    if value == 0 {
        return 0;
    }
    let number = Finite { negative: value < 0, exponent: -i32::from(fraction), significand: value.unsigned_abs().into() };
    round(number, SINGLE, mode, fpscr)
}

/// `FPToFixed`: saturates; NaN gives 0. A result of 16 bits is extended to 32.
pub(crate) fn to_fixed(bits: u32, signed: bool, half: bool, fraction: u8, mode: Rounding, fpscr: &mut u32) -> u32 {
    let width = if half { 16 } else { 32 };
    let (low, high) = match signed {
        true => (-(1i64 << (width - 1)), (1i64 << (width - 1)) - 1),
        false => (0, (1i64 << width) - 1),
    };
    let (value, inexact) = match unpack(bits, fpscr) {
        Number::Nan => {
            *fpscr |= IOC;
            return 0;
        }
        Number::Infinite { negative } => (if negative { i64::MIN } else { i64::MAX }, false),
        Number::Finite(Finite { negative, exponent, significand }) => {
            let exponent = exponent + i32::from(fraction);
            let (magnitude, inexact) = match exponent {
                // At least 2^63 unless zero, which saturates.
                40.. => (if significand == 0 { 0 } else { i64::MAX as u128 }, false),
                0..40 => (significand << exponent, false),
                _ => {
                    let by = (-exponent).min(100) as u32;
                    let (kept, rest) = (significand >> by, significand & ((1 << by) - 1));
                    (kept + u128::from(rounds_up(mode, negative, kept & 1 == 1, rest, 1 << (by - 1))), rest != 0)
                }
            };
            let magnitude = magnitude.min(i64::MAX as u128) as i64;
            (if negative { -magnitude } else { magnitude }, inexact)
        }
    };
    let result = value.clamp(low, high);
    if result != value {
        *fpscr |= IOC;
    } else if inexact {
        *fpscr |= IXC;
    }
    result as u32
}

/// `FPHalfToSingle`
pub(crate) fn from_half(half: u16, fpscr: &mut u32) -> u32 {
    let half = u32::from(half);
    let negative = half >> 15 == 1;
    let (exponent, fraction) = (half >> 10 & 0x1F, half & 0x3FF);
    let (exponent, significand) = match (exponent, fraction) {
        (0x1F, 0) if *fpscr & AHP == 0 => return infinity(negative),
        (0x1F, _) if *fpscr & AHP == 0 => {
            if fraction & 0x200 == 0 {
                *fpscr |= IOC;
            }
            let quiet = zero(negative) | DEFAULT_NAN | fraction << 13;
            return if *fpscr & DN == 0 { quiet } else { DEFAULT_NAN };
        }
        (0, 0) => return zero(negative),
        (0, _) => (-24, fraction),
        _ => (exponent as i32 - 25, fraction | 0x400),
    };
    round(Finite { negative, exponent, significand: significand.into() }, SINGLE, Rounding::Nearest, fpscr)
}

/// `FPSingleToHalf`
pub(crate) fn to_half(bits: u32, fpscr: &mut u32) -> u32 {
    let sign = bits >> 31 << 15;
    let alternative = *fpscr & AHP != 0;
    if is_nan(bits) {
        if alternative {
            *fpscr |= IOC;
            return sign;
        }
        let quiet = propagate(&[bits], fpscr);
        return quiet >> 31 << 15 | 0x7E00 | quiet >> 13 & 0x1FF;
    }
    match unpack(bits, fpscr) {
        Number::Finite(Finite { significand: 0, .. }) => sign,
        Number::Finite(number) => round(number, HALF, Rounding::from_fpscr(*fpscr), fpscr),
        _ if alternative => {
            *fpscr |= IOC;
            sign | 0x7FFF
        }
        _ => sign | INFINITY >> 13 & 0x7C00,
    }
}
