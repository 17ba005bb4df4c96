//! Four numbers side by side, as a register of 256 bits holds them.
//!
//! The arithmetic is that of each number by itself, bit for bit, and nothing is contracted. What is called from [`widest`] is compiled for the widest
//! registers that the processor has, and everything on the way there must be inlined.

use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Sub};

use pulp::Arch;

/// Numbers in a [`Quad`].
pub const LANES: usize = 4;

/// Four numbers side by side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct Quad(pub [f64; LANES]);

/// Does what is asked with the widest registers that this processor has.
#[inline(always)]
pub(crate) fn widest<T>(work: impl FnOnce() -> T) -> T {
    Arch::new().dispatch(work)
}

impl Quad {
    /// The same number four times.
    #[inline(always)]
    pub fn splat(x: f64) -> Self {
        Quad([x; LANES])
    }

    /// Each number by itself.
    #[inline(always)]
    pub fn map(self, each: impl Fn(f64) -> f64) -> Self {
        Quad(self.0.map(each))
    }

    /// Two of them, number by number.
    #[inline(always)]
    pub fn zip(self, other: Self, both: impl Fn(f64, f64) -> f64) -> Self {
        Quad(std::array::from_fn(|n| both(self.0[n], other.0[n])))
    }

    /// The larger of each two; the other one's where this is not a number.
    #[inline(always)]
    pub fn larger(self, other: Self) -> Self {
        self.zip(other, |x, y| if x > y { x } else { y })
    }

    /// The smaller of each two; the other one's where this is not a number.
    #[inline(always)]
    pub fn smaller(self, other: Self) -> Self {
        self.zip(other, |x, y| if x < y { x } else { y })
    }
}

impl Add for Quad {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |x, y| x + y)
    }
}

impl Sub for Quad {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |x, y| x - y)
    }
}

impl Mul for Quad {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |x, y| x * y)
    }
}

impl Mul<f64> for Quad {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.map(|x| x * factor)
    }
}

impl AddAssign for Quad {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Index<usize> for Quad {
    type Output = f64;
    #[inline(always)]
    fn index(&self, lane: usize) -> &f64 {
        &self.0[lane]
    }
}

impl IndexMut<usize> for Quad {
    #[inline(always)]
    fn index_mut(&mut self, lane: usize) -> &mut f64 {
        &mut self.0[lane]
    }
}
