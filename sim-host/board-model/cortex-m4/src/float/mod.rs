//! Floating-point arithmetic as ARMv7-M defines it (A2.5, appendix D): all rounding modes, flush-to-zero, default NaN, cumulative flags.
//!
//! Each operation has two ways with the same result: the host's own instruction where only a normal result is possible and no flag can
//! change, else integers.

mod arithmetic;
mod convert;
mod number;

pub(crate) use arithmetic::{add, compare, divide, multiply, multiply_add, negate, square_root, subtract};
pub(crate) use convert::{from_fixed, from_half, to_fixed, to_half};

/// FPSCR: invalid operation, division by zero, overflow, underflow, inexact, denormal input (A2.5.3).
pub(crate) const IOC: u32 = 1 << 0;
pub(crate) const DZC: u32 = 1 << 1;
pub(crate) const OFC: u32 = 1 << 2;
pub(crate) const UFC: u32 = 1 << 3;
pub(crate) const IXC: u32 = 1 << 4;
pub(crate) const IDC: u32 = 1 << 7;
/// FPSCR: rounding mode, flush to zero, default NaN, alternative half precision.
pub(crate) const MODE: u32 = 3 << 22;
pub(crate) const FZ: u32 = 1 << 24;
pub(crate) const DN: u32 = 1 << 25;
pub(crate) const AHP: u32 = 1 << 26;
/// The bits of FPSCR that exist.
pub(crate) const EXISTING: u32 = 0xF7C0_009F;

/// The rounding modes of FPSCR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rounding {
    Nearest,
    Up,
    Down,
    Zero,
}

impl Rounding {
    /// The mode that FPSCR asks for.
    pub(crate) fn of(fpscr: u32) -> Rounding {
        [Rounding::Nearest, Rounding::Up, Rounding::Down, Rounding::Zero][(fpscr >> 22 & 3) as usize]
    }
}

/// Whether the host's instruction does the same: rounding to nearest, no flushing, and inexactness is noted already.
#[inline(always)]
fn as_host(fpscr: u32) -> bool {
    fpscr & (MODE | FZ | IXC) == IXC
}

/// Whether a result is normal and above the least normal number, which a rounded subnormal may have become.
#[inline(always)]
fn is_plain(result: f32) -> bool {
    (2..255).contains(&(result.to_bits() >> 23 & 0xFF))
}
