//! What the controller itself uses.

use firmware::nco::Stretch;
use firmware::shape::sine::{self, Rotor};

use crate::generator::{Generator, Pair};

/// [`sine::rotation`].
pub struct Rotation;

impl Generator for Rotation {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "firmware rotation";
    const FAMILY: &'static str = "the controller";
    const HOW: &'static str = "512 pairs, second order";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        let turned = sine::rotation(phase);
        Pair { sin: turned.im, cos: turned.re }
    }
}

/// [`Rotor`], which is seeded by it.
pub struct Turning;

impl Generator for Turning {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "firmware rotor";
    const FAMILY: &'static str = "the controller";
    const HOW: &'static str = "z w, set anew each block";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        Rotation::pair(phase)
    }

    #[inline]
    fn block(phase: u64, word: u64, samples: usize, mut sink: impl FnMut(Pair<f32>)) {
        Rotor::new(&Stretch { phase, word, step: 0 }).each(samples, |z| sink(Pair { sin: z.im, cos: z.re }));
    }
}
