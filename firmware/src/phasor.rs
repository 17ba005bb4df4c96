//! Phasors: the complex amplitude `X` of a signal `x(n) = Re{X exp(j theta(n))}`, peak value, in f32.
//!
//! The reference `theta` is the phase of the drive's own oscillator, so `arg` is always relative to it.

use crate::units::Turns;

/// A complex amplitude (peak).
pub type Phasor = num_complex::Complex32;

/// Radians in a turn.
const TAU: f32 = core::f32::consts::TAU;

/// Magnitude. `libm` is used rather than the processor's own root so that every target agrees.
pub fn magnitude(x: Phasor) -> f32 {
    libm::sqrtf(x.norm_sqr())
}

/// Argument, in (-0.5, 0.5] turns.
pub fn argument(x: Phasor) -> Turns {
    Turns(libm::atan2f(x.im, x.re) / TAU)
}

/// The unit phasor in the direction of `x`; one where `x` is zero.
pub fn direction(x: Phasor) -> Phasor {
    let size = magnitude(x);
    if size > 0.0 { x / size } else { Phasor::new(1.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn argument_is_in_turns() {
        assert_eq!(argument(Phasor::new(0.0, 2.0)), Turns(0.25));
        assert_eq!(argument(Phasor::new(-1.0, 0.0)).degrees(), 180.0);
    }

    #[test]
    fn direction_has_unit_size_even_of_nothing() {
        assert!((magnitude(direction(Phasor::new(3.0, -4.0))) - 1.0).abs() < 1e-6);
        assert_eq!(direction(Phasor::new(0.0, 0.0)), Phasor::new(1.0, 0.0));
    }
}
