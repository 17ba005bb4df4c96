//! Vectors of eight numbers, one for each contact, and polynomials of them. The operations are
//! those of [`polynomial`](crate::method::polynomial), in the same order.
//!
//! No function here or in the neighbouring modules passes vectors to a closure, or to a function
//! that calls one: a closure that is not inlined does not use the instructions chosen at run time.
//! Functions that are not inlined are called through [`Simd::vectorize`].

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f64x8, mask64x8};

/// Number of contacts in a batch.
pub const WIDTH: usize = 8;

/// One number for each contact.
pub(super) type Vector<S> = f64x8<S>;
/// One flag for each contact.
pub(super) type Mask<S> = mask64x8<S>;

/// Returns the same number for all contacts.
#[inline(always)]
pub(super) fn all<S: Simd>(simd: S, value: f64) -> Vector<S> {
    f64x8::splat(simd, value)
}

/// Returns a number for each contact.
#[inline(always)]
pub(super) fn each<S: Simd>(simd: S, of: impl FnMut(usize) -> f64) -> Vector<S> {
    f64x8::load_array(simd, std::array::from_fn(of))
}

/// Sets `slot` to `new` for the chosen contacts.
#[inline(always)]
pub(super) fn put<S: Simd>(slot: &mut Vector<S>, chosen: Mask<S>, new: Vector<S>) {
    *slot = chosen.select(new, *slot);
}

/// Returns the indices of the chosen contacts.
#[inline(always)]
pub(super) fn numbers<S: Simd>(chosen: Mask<S>) -> impl Iterator<Item = usize> {
    let mut bits = chosen.to_bitmask();
    std::iter::from_fn(move || {
        let number = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            number
        })
    })
}

/// Batched [`value`](crate::method::polynomial::value).
#[inline(always)]
pub(super) fn value<S: Simd, const N: usize>(c: &[Vector<S>; N], s: Vector<S>) -> Vector<S> {
    let square = s * s;
    chain(c, 0, square) + s * chain(c, 1, square)
}

/// Batched [`slope`](crate::method::polynomial::slope), from the coefficients `k c[k]`.
#[inline(always)]
pub(super) fn slope<S: Simd, const N: usize>(times_k: &[Vector<S>; N], s: Vector<S>) -> Vector<S> {
    let square = s * s;
    chain(times_k, 1, square) + s * chain(times_k, 2, square)
}

/// Returns the coefficients times their index.
#[inline(always)]
pub(super) fn times_k<S: Simd, const N: usize>(c: &[Vector<S>; N]) -> [Vector<S>; N] {
    let mut out = *c;
    for k in 0..N {
        out[k] = c[k] * k as f64;
    }
    out
}

/// Evaluates every second coefficient from `first` by Horner's rule.
#[inline(always)]
fn chain<S: Simd, const N: usize>(c: &[Vector<S>; N], first: usize, square: Vector<S>) -> Vector<S> {
    let mut sum = all(square.simd, 0.0);
    for k in (first..N).rev().filter(|k| (k - first).is_multiple_of(2)) {
        sum = if k + 2 < N { sum * square + c[k] } else { c[k] };
    }
    sum
}
