//! What other crates offer. idsp takes 2^32 a turn and gives Q31; micromath and libm take radians in f32, which is counted with them.

use core::f32::consts::TAU;

use crate::generator::{Generator, Pair};

/// Radians from half a turn before zero to half a turn after.
#[inline]
fn radians(phase: u64) -> f32 {
    ((phase >> 32) as i32) as f32 * (TAU / 4_294_967_296.0)
}

/// `idsp::cossin`.
pub struct Idsp;

impl Generator for Idsp {
    type Number = i32;
    const ONE: f64 = i32::MAX as f64;
    const NAME: &'static str = "idsp cossin";
    const FAMILY: &'static str = "idsp cossin";
    const HOW: &'static str = "octant table, interpolated, integer";

    #[inline]
    fn pair(phase: u64) -> Pair<i32> {
        let (cos, sin) = idsp::cossin((phase >> 32) as i32);
        Pair { sin, cos }
    }
}

/// micromath's `sin_cos`.
pub struct Micromath;

impl Generator for Micromath {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "micromath";
    const FAMILY: &'static str = "micromath";
    const HOW: &'static str = "sin_cos";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        // By name: as a trait's method it would be std's on the host.
        let (sin, cos) = micromath::F32(radians(phase)).sin_cos();
        Pair { sin: sin.0, cos: cos.0 }
    }
}

/// libm's `sinf` and `cosf`.
pub struct Libm;

impl Generator for Libm {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "libm";
    const FAMILY: &'static str = "libm";
    const HOW: &'static str = "sinf and cosf, f64 inside";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        let angle = radians(phase);
        Pair { sin: libm::sinf(angle), cos: libm::cosf(angle) }
    }
}
