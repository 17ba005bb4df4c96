//! What the controller itself uses.

use firmware::nco::Stretch;
use firmware::phasor::Phasor;
use firmware::shape::sine::{self, Steady};

use crate::generator::{Generator, Pair};

/// [`sine::rotation`].
pub struct Rotation;

impl Generator for Rotation {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "firmware rotation";
    const FAMILY: &'static str = "firmware rotation";
    const HOW: &'static str = "512 pairs, second order";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        let turned = sine::rotation(phase);
        Pair { sin: turned.im, cos: turned.re }
    }
}

/// Two of [`sine::Swing`], one a quarter turn ahead of the other.
pub struct Swung;

impl Generator for Swung {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "firmware swing";
    const FAMILY: &'static str = "firmware swing";
    const HOW: &'static str = "y + d, d - c y, set anew each block";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        Rotation::pair(phase)
    }

    #[inline]
    fn block(phase: u64, word: u64, samples: usize, mut sink: impl FnMut(Pair<f32>)) {
        let steady = Steady::new(&Stretch { phase, word, step: 0 });
        let (mut sine, mut cosine) = (steady.swing(Phasor::new(1.0, 0.0)), steady.swing(Phasor::new(0.0, 1.0)));
        (0..samples).for_each(|_| sink(Pair { sin: sine.take(), cos: cosine.take() }));
    }
}
