//! As many numbers side by side as a step has places to look at: its nodes, and its end in the last lane.

use std::ops::{Add, Mul, Sub};

use wide::{f64x2, f64x4};

use super::quadrature::Nodes;

/// Numbers side by side.
pub(super) trait SimdNodes: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// Number of the last lane.
    const END: usize;

    /// A number for each lane.
    fn each(of: impl Fn(usize) -> f64) -> Self;

    /// One number in all lanes.
    fn all(value: f64) -> Self;

    /// The number in a lane.
    fn lane(self, lane: usize) -> f64;
}

impl SimdNodes for f64x2 {
    const END: usize = 1;

    #[inline]
    fn each(of: impl Fn(usize) -> f64) -> Self {
        f64x2::new([of(0), of(1)])
    }

    #[inline]
    fn all(value: f64) -> Self {
        f64x2::splat(value)
    }

    #[inline]
    fn lane(self, lane: usize) -> f64 {
        self.to_array()[lane]
    }
}

impl SimdNodes for f64x4 {
    const END: usize = 3;

    #[inline]
    fn each(of: impl Fn(usize) -> f64) -> Self {
        f64x4::new([of(0), of(1), of(2), of(3)])
    }

    #[inline]
    fn all(value: f64) -> Self {
        f64x4::splat(value)
    }

    #[inline]
    fn lane(self, lane: usize) -> f64 {
        self.to_array()[lane]
    }
}

/// How many lanes that takes.
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

/// The lanes of a step with `K` nodes.
pub(super) type Lanes<const K: usize> = <Nodes<K> as Places>::Lanes;

/// Where in a step from 0 to 1 each lane looks: a node, or the end.
pub(super) fn place<const K: usize>(lane: usize) -> f64 {
    Nodes::<K>::AT.get(lane).copied().unwrap_or(1.0)
}

/// The values of a polynomial, by its even and its odd part: two short chains rather than a long one.
#[inline]
pub(super) fn values<L: SimdNodes, const N: usize>(c: &[f64; N], s: L) -> L {
    let square = s * s;
    let part = |first: usize| c.iter().skip(first).step_by(2).rev().fold(L::all(0.0), |sum, c| sum * square + L::all(*c));
    part(0) + s * part(1)
}
