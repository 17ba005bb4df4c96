//! Four numbers in a batch, as in a register of 256 bits.
//!
//! Each number is computed by itself, bit for bit: nothing is contracted, on any processor.
//! `run_widest` runs a `Kernel` in registers of 256 bits if the processor has them (AVX2, detected
//! at run time), otherwise in the registers of the build target.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod four;

use std::ops::{Add, Index, IndexMut, Mul, Sub};

pub(crate) use four::{Portable, Registers};

/// Numbers in a [`Quad`].
pub const LANES: usize = 4;

/// Four numbers in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct Quad(pub [f64; LANES]);

/// Four numbers in a register.
#[derive(Clone, Copy)]
pub(crate) struct Wide<F: Registers>(F, F::Numbers);

/// A computation that is the same in any registers.
pub(crate) trait Kernel {
    /// Result of the computation.
    type Output;
    /// Runs the computation. It and everything that it calls must be inlined, to be compiled for
    /// these registers.
    fn with<F: Registers>(self, four: F) -> Self::Output;
}

/// Runs the kernel in the widest registers of this processor.
#[inline(always)]
pub(crate) fn run_widest<W: Kernel>(kernel: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let pulp::Arch::V3(registers) = pulp::Arch::new() {
        return pulp::Simd::vectorize(registers, avx2::In(registers, kernel));
    }
    kernel.with(Portable)
}

impl Quad {
    /// Returns the same number four times.
    #[inline(always)]
    pub fn splat(x: f64) -> Self {
        Quad([x; LANES])
    }

    /// Loads it into a register.
    #[inline(always)]
    pub(crate) fn wide<F: Registers>(self, four: F) -> Wide<F> {
        Wide(four, four.load(self))
    }
}

impl<F: Registers> Wide<F> {
    /// Returns the same number four times.
    #[inline(always)]
    pub(crate) fn splat(four: F, x: f64) -> Self {
        Quad::splat(x).wide(four)
    }

    /// Returns the numbers with these bits.
    #[inline(always)]
    pub(crate) fn from_bits(four: F, bits: F::Words) -> Self {
        Wide(four, four.numbers(bits))
    }

    /// Returns the registers that hold it.
    #[inline(always)]
    pub(crate) fn four(self) -> F {
        self.0
    }

    /// Stores it in memory.
    #[inline(always)]
    pub(crate) fn quad(self) -> Quad {
        self.0.store(self.1)
    }

    /// Returns the absolute values.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Wide(self.0, self.0.abs(self.1))
    }

    /// Returns the larger number of each pair; the one of `other` if one is NaN.
    #[inline(always)]
    pub(crate) fn larger(self, other: Self) -> Self {
        Wide(self.0, self.0.larger(self.1, other.1))
    }

    /// Returns the smaller number of each pair; the one of `other` if one is NaN.
    #[inline(always)]
    pub(crate) fn smaller(self, other: Self) -> Self {
        Wide(self.0, self.0.smaller(self.1, other.1))
    }

    /// Returns `true` if each number is below its counterpart.
    #[inline(always)]
    pub(crate) fn is_below(self, other: Self) -> bool {
        self.0.are_below(self.1, other.1)
    }

    /// Returns `true` if any number equals its counterpart.
    #[inline(always)]
    pub(crate) fn equals_any(self, other: Self) -> bool {
        self.0.any_equal(self.1, other.1)
    }

    /// Rounds towards zero; the numbers must fit into `i32`.
    #[inline(always)]
    pub(crate) fn truncated(self) -> [i32; LANES] {
        self.0.truncated(self.1)
    }
}

impl<F: Registers> Add for Wide<F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Wide(self.0, self.0.add(self.1, other.1))
    }
}

impl<F: Registers> Sub for Wide<F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Wide(self.0, self.0.sub(self.1, other.1))
    }
}

impl<F: Registers> Mul for Wide<F> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Wide(self.0, self.0.mul(self.1, other.1))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation once, on numbers of all kinds.
    struct All([[f64; LANES]; 2]);

    impl Kernel for All {
        type Output = Vec<u64>;
        fn with<F: Registers>(self, four: F) -> Vec<u64> {
            let [a, b] = self.0.map(|x| Quad(x).wide(four));
            let limited = a.larger(Wide::splat(four, -1e9)).smaller(Wide::splat(four, 1e9));
            let numbers = [a + b, a - b, a * b, a.abs(), a.larger(b), a.smaller(b), limited];
            let bits = self.0.map(|x| four.words(x.map(f64::to_bits)));
            let words = [
                four.wrapping_sum(bits[0], bits[1]),
                four.xor(bits[0], bits[1]),
                four.left::<17>(bits[0]),
                four.right::<12>(bits[0]),
                four.rotated::<23, 41>(bits[1]),
            ];
            let flags = [a.is_below(b), a.abs().is_below(Wide::splat(four, f64::INFINITY)), a.equals_any(b)];
            let all = numbers.iter().flat_map(|x| x.quad().0.map(f64::to_bits));
            let all = all.chain(words.iter().flat_map(|x| four.array(*x)));
            let all = all.chain(limited.truncated().map(|x| x as u64)).chain(flags.map(u64::from));
            all.chain(Wide::from_bits(four, bits[0]).quad().0.map(f64::to_bits)).collect()
        }
    }

    #[test]
    fn all_register_types_agree() {
        let kinds = [0.0, -0.0, 1.0, -2.5, 1e-310, 1e300, -1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 0.3, 4095.99];
        for first in 0..kinds.len() {
            for second in 0..kinds.len() {
                let pick = |from: usize| std::array::from_fn(|lane| kinds[(from + 5 * lane) % kinds.len()]);
                let operands = [pick(first), pick(second)];
                // The bits of a NaN, as from a sum of infinities, are unspecified.
                let same = |bits: Vec<u64>| {
                    bits.into_iter().map(|x| if f64::from_bits(x).is_nan() { u64::MAX } else { x }).collect::<Vec<_>>()
                };
                assert_eq!(same(run_widest(All(operands))), same(All(operands).with(Portable)), "{operands:?}");
            }
        }
    }
}
