//! SIMD vectors with a lane for each evaluation point of a step: its nodes, and its end in the last
//! lane.

use std::ops::{Add, Mul, Sub};

use wide::bytemuck::cast;
use wide::{f64x2, f64x4, f64x8, i64x2, i64x4, i64x8};

use super::quadrature::Nodes;
use crate::method::polynomial::every_second;

/// Vector of numbers.
pub(super) trait SimdNodes:
    Copy + Default + PartialEq + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
    /// Index of the last lane.
    const END: usize;

    /// Creates a vector from a number for each lane.
    fn each(of: impl Fn(usize) -> f64) -> Self;

    /// Creates a vector with the same number in all lanes.
    fn all(value: f64) -> Self;

    /// Returns the number in a lane.
    fn lane(self, lane: usize) -> f64;

    /// Limits the numbers to an upper bound; NaN becomes the bound.
    fn at_most(self, bound: f64) -> Self;

    /// Limits the numbers to a lower bound; NaN becomes the bound.
    fn at_least(self, bound: f64) -> Self;

    /// Multiplies each number by the power of two in the lowest bits of `whole`.
    fn times_two_to(self, whole: Self) -> Self;
}

/// Implements [`SimdNodes`] for a vector of numbers and its vector of whole numbers.
macro_rules! simd_nodes {
    ($numbers:ident, $whole:ident, $lanes:literal) => {
        impl SimdNodes for $numbers {
            const END: usize = $lanes - 1;

            #[inline]
            fn each(of: impl Fn(usize) -> f64) -> Self {
                Self::new(std::array::from_fn(of))
            }

            #[inline]
            fn all(value: f64) -> Self {
                Self::splat(value)
            }

            #[inline]
            fn lane(self, lane: usize) -> f64 {
                self.to_array()[lane]
            }

            #[inline]
            fn at_most(self, bound: f64) -> Self {
                self.simd_lt(Self::splat(bound)).select(self, Self::splat(bound))
            }

            #[inline]
            fn at_least(self, bound: f64) -> Self {
                self.simd_gt(Self::splat(bound)).select(self, Self::splat(bound))
            }

            #[inline]
            fn times_two_to(self, whole: Self) -> Self {
                let bits: $whole = cast(whole);
                cast(cast::<Self, $whole>(self) + (bits << 52))
            }
        }
    };
}

simd_nodes!(f64x2, i64x2, 2);
simd_nodes!(f64x4, i64x4, 4);
simd_nodes!(f64x8, i64x8, 8);

/// Vector type for the evaluation points of a step.
pub(super) trait Places {
    /// Type that holds a number for each node.
    type Lanes: SimdNodes;
}

impl Places for Nodes<1> {
    type Lanes = f64x2;
}

impl Places for Nodes<2> {
    type Lanes = f64x4;
}

impl Places for Nodes<3> {
    type Lanes = f64x4;
}

impl Places for Nodes<5> {
    type Lanes = f64x8;
}

/// Lanes of a step with `K` nodes.
pub(super) type Lanes<const K: usize> = <Nodes<K> as Places>::Lanes;

/// Returns the position of a lane in a step from 0 to 1: a node, or the end.
pub(super) fn place<const K: usize>(lane: usize) -> f64 {
    Nodes::<K>::AT.get(lane).copied().unwrap_or(1.0)
}

/// Returns the values of a polynomial, from the even and the odd part: two short chains instead of
/// a long one.
#[inline]
pub(super) fn values<L: SimdNodes, const N: usize>(c: &[f64; N], s: L) -> L {
    let square = s * s;
    let part = |first: usize| every_second::<N, _>(first, |k| L::all(c[k]), |sum, c| sum * square + c);
    part(0) + s * part(1)
}

/// Returns the sum of vectors, each times the number in one lane.
#[inline]
pub(super) fn combine<L: SimdNodes, const K: usize>(numbers: L, vectors: &[L; K]) -> L {
    let mut sum = L::all(-0.0);
    for (lane, vector) in vectors.iter().enumerate() {
        sum = sum + L::all(numbers.lane(lane)) * *vector;
    }
    sum
}
