//! The registers for four numbers: those of a certain processor, or portable ones.

use super::{LANES, Quad};

/// Operations on four numbers of 64 bits.
pub(crate) trait Registers: Copy {
    /// Four floating-point numbers.
    type Numbers: Copy;
    /// Four words.
    type Words: Copy;

    /// Loads from memory.
    fn load(self, quad: Quad) -> Self::Numbers;
    /// Stores in memory.
    fn store(self, numbers: Self::Numbers) -> Quad;
    /// Computes `a + b`
    fn add(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// Computes `a - b`
    fn sub(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// Computes `a * b`
    fn mul(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// Computes `|a|`
    fn abs(self, a: Self::Numbers) -> Self::Numbers;
    /// Computes `if a > b { a } else { b }`
    fn larger(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// Computes `if a < b { a } else { b }`
    fn smaller(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// Returns `true` if every `a < b`.
    fn are_below(self, a: Self::Numbers, b: Self::Numbers) -> bool;
    /// Returns `true` if any `a == b`.
    fn any_equal(self, a: Self::Numbers, b: Self::Numbers) -> bool;
    /// Rounds towards zero; the numbers must fit into 32 bits.
    fn truncated(self, a: Self::Numbers) -> [i32; LANES];

    /// Converts from an array.
    fn words(self, words: [u64; LANES]) -> Self::Words;
    /// Converts to an array.
    fn array(self, words: Self::Words) -> [u64; LANES];
    /// Computes `a + b`, modulo 2^64.
    fn wrapping_sum(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Computes `a ^ b`
    fn xor(self, a: Self::Words, b: Self::Words) -> Self::Words;
    /// Shifts towards the upper bits.
    fn left<const BITS: i32>(self, a: Self::Words) -> Self::Words;
    /// Shifts towards the lower bits.
    fn right<const BITS: i32>(self, a: Self::Words) -> Self::Words;
    /// Returns the numbers with these bits.
    fn numbers(self, bits: Self::Words) -> Self::Numbers;

    /// Rotates to the left by `LEFT`; `LEFT + RIGHT` is 64.
    #[inline(always)]
    fn rotated<const LEFT: i32, const RIGHT: i32>(self, a: Self::Words) -> Self::Words {
        const { assert!(LEFT + RIGHT == 64) };
        self.xor(self.left::<LEFT>(a), self.right::<RIGHT>(a))
    }
}

/// Portable arrays; the compiler selects the registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

#[inline(always)]
fn each<T: Copy, U>(a: [T; LANES], b: [T; LANES], both: impl Fn(T, T) -> U) -> [U; LANES] {
    std::array::from_fn(|n| both(a[n], b[n]))
}

impl Registers for Portable {
    type Numbers = [f64; LANES];
    type Words = [u64; LANES];

    #[inline(always)]
    /// Loads from memory.
    fn load(self, quad: Quad) -> [f64; LANES] {
        quad.0
    }
    #[inline(always)]
    fn store(self, numbers: [f64; LANES]) -> Quad {
        Quad(numbers)
    }
    #[inline(always)]
    fn add(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each(a, b, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each(a, b, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each(a, b, |a, b| a * b)
    }
    #[inline(always)]
    fn abs(self, a: [f64; LANES]) -> [f64; LANES] {
        a.map(f64::abs)
    }
    #[inline(always)]
    fn larger(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each(a, b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn smaller(self, a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
        each(a, b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn are_below(self, a: [f64; LANES], b: [f64; LANES]) -> bool {
        each(a, b, |a, b| a < b) == [true; LANES]
    }
    #[inline(always)]
    fn any_equal(self, a: [f64; LANES], b: [f64; LANES]) -> bool {
        each(a, b, |a, b| a == b) != [false; LANES]
    }
    #[inline(always)]
    fn truncated(self, a: [f64; LANES]) -> [i32; LANES] {
        a.map(|a| a as i32)
    }

    #[inline(always)]
    fn words(self, words: [u64; LANES]) -> [u64; LANES] {
        words
    }
    #[inline(always)]
    fn array(self, words: [u64; LANES]) -> [u64; LANES] {
        words
    }
    #[inline(always)]
    fn wrapping_sum(self, a: [u64; LANES], b: [u64; LANES]) -> [u64; LANES] {
        each(a, b, u64::wrapping_add)
    }
    #[inline(always)]
    fn xor(self, a: [u64; LANES], b: [u64; LANES]) -> [u64; LANES] {
        each(a, b, |a, b| a ^ b)
    }
    #[inline(always)]
    fn left<const BITS: i32>(self, a: [u64; LANES]) -> [u64; LANES] {
        a.map(|a| a << BITS)
    }
    #[inline(always)]
    fn right<const BITS: i32>(self, a: [u64; LANES]) -> [u64; LANES] {
        a.map(|a| a >> BITS)
    }
    #[inline(always)]
    fn numbers(self, bits: [u64; LANES]) -> [f64; LANES] {
        bits.map(f64::from_bits)
    }
}
