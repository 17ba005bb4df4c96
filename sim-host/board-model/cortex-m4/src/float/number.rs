//! Unpacking of numbers, and rounding of exact ones.

use super::{AHP, DN, FZ, IDC, IOC, IXC, OFC, Rounding, UFC};

/// NaN result if no operand is propagated.
pub(super) const DEFAULT_NAN: u32 = 0x7FC0_0000;
pub(super) const INFINITY: u32 = 0x7F80_0000;

/// Number of single precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    Nan,
    Infinite {
        negative: bool,
    },
    /// `significand · 2^exponent`
    Finite(Finite),
}

/// `± significand · 2^exponent`; the lowest bit can represent all bits below it (sticky).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Finite {
    pub(super) negative: bool,
    pub(super) exponent: i32,
    pub(super) significand: u128,
}

/// `FPUnpack`: flushes subnormal numbers if FPSCR selects it.
pub(super) fn unpack(bits: u32, fpscr: &mut u32) -> Number {
    let negative = bits >> 31 == 1;
    let (exponent, fraction) = (bits >> 23 & 0xFF, bits & 0x7F_FFFF);
    let (exponent, significand) = match exponent {
        0xFF if fraction != 0 => return Number::Nan,
        0xFF => return Number::Infinite { negative },
        0 if fraction != 0 && *fpscr & FZ != 0 => {
            *fpscr |= IDC;
            (-149, 0)
        }
        0 => (-149, fraction),
        _ => (exponent as i32 - 150, fraction | 1 << 23),
    };
    Number::Finite(Finite { negative, exponent, significand: significand.into() })
}

fn is_signalling(bits: u32) -> bool {
    bits & 0x7FC0_0000 == INFINITY && bits & 0x3F_FFFF != 0
}

/// Returns `true` if `bits` are a NaN.
pub(super) fn is_nan(bits: u32) -> bool {
    bits & 0x7FFF_FFFF > INFINITY
}

/// `FPProcessNaNs`: returns the first signalling operand, made quiet, or else the first quiet one.
pub(super) fn propagate(operands: &[u32], fpscr: &mut u32) -> u32 {
    // Each operand is unpacked, and flushed if subnormal.
    for bits in operands {
        unpack(*bits, fpscr);
    }
    let signalling = operands.iter().find(|bits| is_signalling(**bits));
    if signalling.is_some() {
        *fpscr |= IOC;
    }
    match signalling.or_else(|| operands.iter().find(|bits| is_nan(**bits))) {
        Some(bits) if *fpscr & DN == 0 => bits | 1 << 22,
        _ => DEFAULT_NAN,
    }
}

/// Returns the default NaN and sets the flag of an invalid operation.
pub(super) fn invalid(fpscr: &mut u32) -> u32 {
    *fpscr |= IOC;
    DEFAULT_NAN
}

pub(super) fn zero(negative: bool) -> u32 {
    u32::from(negative) << 31
}

pub(super) fn infinity(negative: bool) -> u32 {
    zero(negative) | INFINITY
}

/// Shifts right; the lowest bit is set if a shifted-out bit was set.
pub(super) fn shift_sticky(significand: u128, by: u32) -> u128 {
    match significand.checked_shr(by) {
        _ if by == 0 => significand,
        None => u128::from(significand != 0),
        Some(shifted) => shifted | u128::from(shifted << by != significand),
    }
}

/// Returns `true` if a magnitude is rounded up. `odd` is the parity of its integer part, `rest` the
/// part below it, and `half` half a unit.
pub(super) fn rounds_up(mode: Rounding, negative: bool, odd: bool, rest: u128, half: u128) -> bool {
    match mode {
        Rounding::Nearest => rest > half || rest == half && odd,
        Rounding::Up => rest != 0 && !negative,
        Rounding::Down => rest != 0 && negative,
        Rounding::Zero => false,
    }
}

/// Format of IEEE 754.
#[derive(Clone, Copy)]
pub(super) struct Format {
    /// Number of bits of the fraction.
    pub(super) fraction: u32,
    /// Number of bits of the exponent.
    pub(super) exponent: u32,
}

pub(super) const SINGLE: Format = Format { fraction: 23, exponent: 8 };
pub(super) const HALF: Format = Format { fraction: 10, exponent: 5 };

/// `FPRound`: rounds an exact number that is not zero to a format. Subnormality is decided before
/// rounding.
pub(super) fn round(number: Finite, format: Format, mode: Rounding, fpscr: &mut u32) -> u32 {
    let Finite { negative, exponent, significand } = number;
    let bias = (1 << (format.exponent - 1)) - 1;
    let least = 1 - bias;
    let single = format.exponent == 8;
    let sign = u32::from(negative) << (format.fraction + format.exponent);
    let top = exponent + significand.ilog2() as i32;
    let tiny = top < least;
    if tiny && single && *fpscr & FZ != 0 {
        *fpscr |= UFC;
        return sign;
    }
    // Exponent of the unit of the last place.
    let mut unit = top.max(least) - format.fraction as i32;
    let mut digits = significand;
    let mut inexact = false;
    if unit <= exponent {
        digits <<= exponent - unit;
    } else {
        let by = (unit - exponent) as u32;
        // Beyond all digits the rest only has to stay below half a unit.
        let (kept, rest, half) = match by {
            0..=127 => (digits >> by, digits & ((1 << by) - 1), 1 << (by - 1)),
            _ => (0, 1, 2),
        };
        inexact = rest != 0;
        digits = kept + u128::from(rounds_up(mode, negative, kept & 1 == 1, rest, half));
    }
    if digits >> (format.fraction + 1) != 0 {
        digits >>= 1;
        unit += 1;
    }
    let digits = digits as u32;
    let normal = digits >> format.fraction != 0;
    let biased = if normal { (unit + format.fraction as i32 + bias) as u32 } else { 0 };
    let highest = (1 << format.exponent) - 1;
    let alternative = !single && *fpscr & AHP != 0;
    if alternative && biased > highest {
        *fpscr |= IOC;
        return sign | ((highest << format.fraction) | ((1 << format.fraction) - 1));
    }
    if !alternative && biased >= highest {
        *fpscr |= OFC | IXC;
        let away = match mode {
            Rounding::Nearest => true,
            Rounding::Up => !negative,
            Rounding::Down => negative,
            Rounding::Zero => false,
        };
        return sign | ((highest << format.fraction) - u32::from(!away));
    }
    if inexact {
        *fpscr |= IXC | if tiny { UFC } else { 0 };
    }
    sign | biased << format.fraction | digits & ((1 << format.fraction) - 1)
}
