//! Generators that go from sample to sample, and are set anew at each block.
//!
//! ```text
//! rotating phasor   z(n + 1) = z(n) w,                 w = exp(j omega)
//! recurrence        y(n + 1) = 2 cos(omega) y(n) - y(n - 1), for sine and cosine each
//! ```
//!
//! An error of the step grows with the samples, so the step is read by the second-order table.

use crate::generator::{Generator, Pair};
use crate::table_of_pairs::SecondOrder512;

/// A phasor, multiplied by the step.
pub struct RotatingPhasor;

impl Generator for RotatingPhasor {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "rotating phasor";
    const FAMILY: &'static str = "rotating phasor";
    const HOW: &'static str = "z w, set anew each block";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        SecondOrder512::pair(phase)
    }

    #[inline]
    fn block(phase: u64, word: u64, samples: usize, mut sink: impl FnMut(Pair<f32>)) {
        let w = SecondOrder512::pair(word);
        let mut z = SecondOrder512::pair(phase);
        for _ in 0..samples {
            sink(z);
            z = Pair { sin: z.sin * w.cos + z.cos * w.sin, cos: z.cos * w.cos - z.sin * w.sin };
        }
    }
}

/// Chebyshev's recurrence, for sine and cosine.
pub struct Recurrence;

impl Generator for Recurrence {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "recurrence";
    const FAMILY: &'static str = "recurrence";
    const HOW: &'static str = "2 cos(omega) y1 - y2, set anew each block";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        SecondOrder512::pair(phase)
    }

    #[inline]
    fn block(phase: u64, word: u64, samples: usize, mut sink: impl FnMut(Pair<f32>)) {
        let twice_cos = 2.0 * SecondOrder512::pair(word).cos;
        // Two samples a turn of the loop, so that neither moves.
        let mut even = SecondOrder512::pair(phase);
        let mut odd = SecondOrder512::pair(phase.wrapping_add(word));
        for _ in 0..samples / 2 {
            sink(even);
            sink(odd);
            even = Pair { sin: twice_cos * odd.sin - even.sin, cos: twice_cos * odd.cos - even.cos };
            odd = Pair { sin: twice_cos * even.sin - odd.sin, cos: twice_cos * even.cos - odd.cos };
        }
        if samples % 2 == 1 {
            sink(even);
        }
    }
}
