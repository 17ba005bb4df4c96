//! A table of sine and cosine together, corrected by the remaining angle `d`:
//!
//! ```text
//! first order    sin(a + d) = s + c d              cos(a + d) = c - s d              error d^2 / 2
//! second order   sin(a + d) = s + c d - s d^2 / 2  cos(a + d) = c - s d - c d^2 / 2  error d^3 / 6
//! ```
//!
//! Entries stand in the middle of their steps, so that `|d| <= pi / entries`.

use core::f32::consts::TAU;

use crate::generator::{Generator, Pair};
use crate::sines::sine_and_cosine;

/// `(sin, cos)` in the middle of each of `N` steps.
const fn entries<const N: usize>() -> [(f32, f32); N] {
    let mut entries = [(0.0, 0.0); N];
    let mut n = 0;
    while n < N {
        let (sin, cos) = sine_and_cosine((n as f64 + 0.5) / N as f64);
        entries[n] = (sin as f32, cos as f32);
        n += 1;
    }
    entries
}

static OF_256: [(f32, f32); 256] = entries();
static OF_512: [(f32, f32); 512] = entries();
static OF_1024: [(f32, f32); 1024] = entries();

/// The entry of a phase, and the angle from it, in radians.
#[inline]
fn entry<const N: usize>(table: &[(f32, f32); N], phase: u64) -> (f32, f32, f32) {
    let bits = const { N.trailing_zeros() };
    let phase = (phase >> 32) as u32;
    let (s, c) = table[(phase >> (32 - bits)) as usize];
    // What remains, about the middle of the step, 2^32 a step.
    let rest = ((phase << bits) ^ (1 << 31)) as i32;
    (s, c, rest as f32 * const { TAU / N as f32 / 4_294_967_296.0 })
}

#[inline]
fn first_order<const N: usize>(table: &[(f32, f32); N], phase: u64) -> Pair<f32> {
    let (s, c, d) = entry(table, phase);
    Pair { sin: s + c * d, cos: c - s * d }
}

#[inline]
fn second_order<const N: usize>(table: &[(f32, f32); N], phase: u64) -> Pair<f32> {
    let (s, c, d) = entry(table, phase);
    let half = 0.5 * d;
    Pair { sin: s + d * (c - half * s), cos: c - d * (s + half * c) }
}

macro_rules! of_pairs {
    ($($(#[$doc:meta])* $type:ident $name:literal $family:literal $how:literal $order:ident $table:ident;)*) => {$(
        $(#[$doc])*
        pub struct $type;

        impl Generator for $type {
            type Number = f32;
            const ONE: f64 = 1.0;
            const NAME: &'static str = $name;
            const FAMILY: &'static str = $family;
            const HOW: &'static str = $how;

            #[inline]
            fn pair(phase: u64) -> Pair<f32> {
                $order(&$table, phase)
            }
        }
    )*};
}

of_pairs! {
    /// 256 pairs, first order: 7.5e-5.
    FirstOrder256 "256 pairs, first order" "256, 512, 1024 pairs, first order" "s + c d" first_order OF_256;
    /// 512 pairs, first order: 1.9e-5.
    FirstOrder512 "512 pairs, first order" "256, 512, 1024 pairs, first order" "s + c d" first_order OF_512;
    /// 1024 pairs, first order: 4.7e-6.
    FirstOrder1024 "1024 pairs, first order" "256, 512, 1024 pairs, first order" "s + c d" first_order OF_1024;
    /// 256 pairs, second order: 3.1e-7.
    SecondOrder256 "256 pairs, second order" "256, 512 pairs, second order" "s + c d - s d^2 / 2" second_order OF_256;
    /// 512 pairs, second order: 3.9e-8, below what f32 rounds.
    SecondOrder512 "512 pairs, second order" "256, 512 pairs, second order" "s + c d - s d^2 / 2" second_order OF_512;
}
