//! Floating-point arithmetic of ARMv7-M (A2.5, appendix D): all rounding modes, flush-to-zero,
//! default NaN, cumulative flags.
//!
//! Each operation has two implementations with equal results. The host's own instruction is used if
//! the result can only be normal and no flag can change; otherwise integers are used.

mod arithmetic;
mod convert;
mod number;

pub(crate) use arithmetic::{add, compare, divide, multiply, multiply_add, negate, square_root, subtract};
pub(crate) use convert::{from_fixed, from_half, to_fixed, to_half};

/// FPSCR: flags of invalid operation, division by zero, overflow, underflow, inexact result and
/// denormal input (A2.5.3).
pub(crate) const IOC: u32 = 1 << 0;
pub(crate) const DZC: u32 = 1 << 1;
pub(crate) const OFC: u32 = 1 << 2;
pub(crate) const UFC: u32 = 1 << 3;
pub(crate) const IXC: u32 = 1 << 4;
pub(crate) const IDC: u32 = 1 << 7;
/// FPSCR: mask of the rounding mode.
pub(crate) const MODE: u32 = 3 << 22;
/// FPSCR: flush to zero.
pub(crate) const FZ: u32 = 1 << 24;
/// FPSCR: default NaN.
pub(crate) const DN: u32 = 1 << 25;
/// FPSCR: alternative half precision.
pub(crate) const AHP: u32 = 1 << 26;
/// Implemented bits of FPSCR.
pub(crate) const FPSCR_BITS: u32 = 0xF7C0_009F;

/// Rounding mode of FPSCR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rounding {
    Nearest,
    Up,
    Down,
    Zero,
}

impl Rounding {
    /// Returns the mode in FPSCR.
    pub(crate) fn from_fpscr(fpscr: u32) -> Rounding {
        [Rounding::Nearest, Rounding::Up, Rounding::Down, Rounding::Zero][(fpscr >> 22 & 3) as usize]
    }
}

/// Returns `true` if the host's instruction gives the same result: rounding to nearest, no
/// flushing, and the inexact flag is set already.
#[inline(always)]
fn as_host(fpscr: u32) -> bool {
    fpscr & (MODE | FZ | IXC) == IXC
}

/// Returns `true` if a result is above the lowest normal number, which can be a rounded subnormal.
#[inline(always)]
fn is_plain(result: f32) -> bool {
    (2..255).contains(&(result.to_bits() >> 23 & 0xFF))
}
