//! What the controller itself uses.

use firmware::shape::sine;

use crate::generator::{Generator, Pair};

/// [`sine::rotation`].
pub struct Rotation;

impl Generator for Rotation {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "firmware rotation";
    const FAMILY: &'static str = "the controller";
    const HOW: &'static str = "what the controller turns its lock-in by";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        let turned = sine::rotation(phase);
        Pair { sin: turned.im, cos: turned.re }
    }
}
