//! Four numbers side by side, as a register of 256 bits holds them.
//!
//! What is computed with them is computed with each number by itself, bit for bit: nothing is contracted, whatever the processor. `widest` does a
//! `Work` in registers of 256 bits where the processor has them (AVX2, asked at run time), and else in what the build has.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod four;

use std::ops::{Add, Index, IndexMut, Mul, Sub};

pub(crate) use four::{Four, Portable};

/// Numbers in a [`Quad`].
pub const LANES: usize = 4;

/// Four numbers side by side, in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(32))]
pub struct Quad(pub [f64; LANES]);

/// Four numbers side by side, in a register.
#[derive(Clone, Copy)]
pub(crate) struct Wide<F: Four>(F, F::Numbers);

/// What is done the same with any registers.
pub(crate) trait Work {
    /// What comes of it.
    type Output;
    /// Does it. To be inlined, and all that it calls, so that it is compiled for these registers.
    fn with<F: Four>(self, four: F) -> Self::Output;
}

/// Does the work with the widest registers that this processor has.
#[inline(always)]
pub(crate) fn widest<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let pulp::Arch::V3(registers) = pulp::Arch::new() {
        return pulp::Simd::vectorize(registers, avx2::In(registers, work));
    }
    work.with(Portable)
}

impl Quad {
    /// The same number four times.
    #[inline(always)]
    pub fn splat(x: f64) -> Self {
        Quad([x; LANES])
    }

    /// Takes it into a register.
    #[inline(always)]
    pub(crate) fn wide<F: Four>(self, four: F) -> Wide<F> {
        Wide(four, four.load(self))
    }
}

impl<F: Four> Wide<F> {
    /// The same number four times.
    #[inline(always)]
    pub(crate) fn splat(four: F, x: f64) -> Self {
        Quad::splat(x).wide(four)
    }

    /// Numbers of these bits.
    #[inline(always)]
    pub(crate) fn of_bits(four: F, bits: F::Words) -> Self {
        Wide(four, four.numbers(bits))
    }

    /// The registers that it is in.
    #[inline(always)]
    pub(crate) fn four(self) -> F {
        self.0
    }

    /// Puts it into memory.
    #[inline(always)]
    pub(crate) fn quad(self) -> Quad {
        self.0.store(self.1)
    }

    /// Without signs.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Wide(self.0, self.0.abs(self.1))
    }

    /// The larger of each two; the other one's where one is not a number.
    #[inline(always)]
    pub(crate) fn larger(self, other: Self) -> Self {
        Wide(self.0, self.0.larger(self.1, other.1))
    }

    /// The smaller of each two; the other one's where one is not a number.
    #[inline(always)]
    pub(crate) fn smaller(self, other: Self) -> Self {
        Wide(self.0, self.0.smaller(self.1, other.1))
    }

    /// Whether each is below the other one's.
    #[inline(always)]
    pub(crate) fn is_below(self, other: Self) -> bool {
        self.0.are_below(self.1, other.1)
    }

    /// Whether any is equal to the other one's.
    #[inline(always)]
    pub(crate) fn equals_any(self, other: Self) -> bool {
        self.0.any_equal(self.1, other.1)
    }

    /// Whole numbers towards zero, of what fits into them.
    #[inline(always)]
    pub(crate) fn truncated(self) -> [i32; LANES] {
        self.0.truncated(self.1)
    }
}

impl<F: Four> Add for Wide<F> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Wide(self.0, self.0.add(self.1, other.1))
    }
}

impl<F: Four> Sub for Wide<F> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Wide(self.0, self.0.sub(self.1, other.1))
    }
}

impl<F: Four> Mul for Wide<F> {
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

    /// Every operation once, of numbers of all kinds.
    struct All([[f64; LANES]; 2]);

    impl Work for All {
        type Output = Vec<u64>;
        fn with<F: Four>(self, four: F) -> Vec<u64> {
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
            all.chain(Wide::of_bits(four, bits[0]).quad().0.map(f64::to_bits)).collect()
        }
    }

    #[test]
    fn every_register_computes_the_same() {
        let kinds = [0.0, -0.0, 1.0, -2.5, 1e-310, 1e300, -1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 0.3, 4095.99];
        for first in 0..kinds.len() {
            for second in 0..kinds.len() {
                let pick = |from: usize| std::array::from_fn(|lane| kinds[(from + 5 * lane) % kinds.len()]);
                let operands = [pick(first), pick(second)];
                // What a sum of infinities is has any bits of no number.
                let same = |bits: Vec<u64>| {
                    bits.into_iter().map(|x| if f64::from_bits(x).is_nan() { u64::MAX } else { x }).collect::<Vec<_>>()
                };
                assert_eq!(same(widest(All(operands))), same(All(operands).with(Portable)), "{operands:?}");
            }
        }
    }
}
