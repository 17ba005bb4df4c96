//! Phasors: the complex peak amplitude `X` of a signal `x(n) = Re{X exp(j theta(n))}`, in f32.
//!
//! The reference `theta` is the phase of the drive's oscillator; `arg` is relative to it.

use crate::seam::units::Turns;

/// Complex peak amplitude.
pub type Phasor = num_complex::Complex32;

/// Radians in a turn.
const TAU: f32 = core::f32::consts::TAU;
/// Largest tangent for which the series is used.
const SMALL_TANGENT: f32 = 0.125;

/// Returns the magnitude.
pub fn magnitude(x: Phasor) -> f32 {
    fpu::sqrtf(x.norm_sqr())
}

/// Returns the argument, in (-0.5, 0.5] turns. Near zero, where a tracker operates, a series is
/// used, which takes a fifth of the time of `atan2f`:
///
/// ```text
/// atan t = t - t^3 / 3 + t^5 / 5 - t^7 / 7,    error t^9 / 9 < 1e-9 for t < 1 / 8
/// ```
#[inline]
pub fn argument(x: Phasor) -> Turns {
    if x.im.abs() < SMALL_TANGENT * x.re {
        let t = x.im / x.re;
        let u = t * t;
        return Turns(t * (1.0 / TAU - u * (1.0 / (3.0 * TAU) - u * (1.0 / (5.0 * TAU) - u * (1.0 / (7.0 * TAU))))));
    }
    Turns(libm::atan2f(x.im, x.re) * (1.0 / TAU))
}

/// Returns the unit phasor in the direction of `x`; 1 if `x` is zero.
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
    fn a_small_argument_is_as_accurate_as_a_large_one() {
        let error = |n: i32| {
            let (im, re) = (n as f32 / 10_000.0, 0.9);
            (f64::from(argument(Phasor::new(re, im)).0) - libm::atan2(im.into(), re.into()) / core::f64::consts::TAU).abs()
        };
        // Tangents to 0.22, beyond the range of the series. Measured: 1.1e-9 turns with the series,
        // 4.6e-9 beyond it, from the rounding of `atan2f`.
        let largest = (-2000..=2000).map(error).fold(0.0, f64::max);
        assert!(largest < 6e-9, "{largest}");
    }

    #[test]
    fn direction_has_unit_size_even_for_zero() {
        assert!((magnitude(direction(Phasor::new(3.0, -4.0))) - 1.0).abs() < 1e-6);
        assert_eq!(direction(Phasor::new(0.0, 0.0)), Phasor::new(1.0, 0.0));
    }
}
