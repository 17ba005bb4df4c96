//! Eight numbers side by side, one of each contact, and polynomials of them: the operations of [`polynomial`](crate::method::polynomial) in
//! the same order.
//!
//! Nothing here or beside it hands numbers to a closure, or to what calls one: a closure that is not put in line has none of the
//! instructions chosen at run time. What is called as a function is called by [`Simd::vectorize`].

use fearless_simd::{Select, Simd, SimdBase, SimdMask, f64x8, mask64x8};

/// Contacts side by side.
pub const WIDTH: usize = 8;

/// A number of each contact.
pub(super) type Each<S> = f64x8<S>;
/// A yes or no of each contact.
pub(super) type Which<S> = mask64x8<S>;

/// The same number for all.
#[inline(always)]
pub(super) fn all<S: Simd>(simd: S, value: f64) -> Each<S> {
    f64x8::splat(simd, value)
}

/// A number for each.
#[inline(always)]
pub(super) fn each<S: Simd>(simd: S, of: impl FnMut(usize) -> f64) -> Each<S> {
    f64x8::load_array(simd, std::array::from_fn(of))
}

/// `new` where it is chosen, elsewhere what there is.
#[inline(always)]
pub(super) fn put<S: Simd>(slot: &mut Each<S>, chosen: Which<S>, new: Each<S>) {
    *slot = chosen.select(new, *slot);
}

/// The contacts that are chosen, by their number.
#[inline(always)]
pub(super) fn numbers<S: Simd>(chosen: Which<S>) -> impl Iterator<Item = usize> {
    let mut bits = chosen.to_bitmask();
    std::iter::from_fn(move || {
        let number = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            number
        })
    })
}

/// The values of polynomials, as [`value`](crate::method::polynomial::value) has them.
#[inline(always)]
pub(super) fn value<S: Simd, const N: usize>(c: &[Each<S>; N], s: Each<S>) -> Each<S> {
    let square = s * s;
    chain(c, 0, square) + s * chain(c, 1, square)
}

/// The values for polynomials of which the slopes' coefficients `k c[k]` are given, as [`slope`](crate::method::polynomial::slope) has them.
#[inline(always)]
pub(super) fn slope<S: Simd, const N: usize>(times_k: &[Each<S>; N], s: Each<S>) -> Each<S> {
    let square = s * s;
    chain(times_k, 1, square) + s * chain(times_k, 2, square)
}

/// The coefficients times their index.
#[inline(always)]
pub(super) fn times_k<S: Simd, const N: usize>(c: &[Each<S>; N]) -> [Each<S>; N] {
    let mut out = *c;
    for k in 0..N {
        out[k] = c[k] * k as f64;
    }
    out
}

/// Every second coefficient from `first` on, by Horner's rule.
#[inline(always)]
fn chain<S: Simd, const N: usize>(c: &[Each<S>; N], first: usize, square: Each<S>) -> Each<S> {
    let mut sum = all(square.simd, 0.0);
    for k in (first..N).rev().filter(|k| (k - first).is_multiple_of(2)) {
        sum = if k + 2 < N { sum * square + c[k] } else { c[k] };
    }
    sum
}
