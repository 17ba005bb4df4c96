//! Magnitude and angle of complex numbers by `libm`, with the same bits on every machine.

use num_complex::Complex64;

/// Returns the magnitude of a number.
pub(crate) fn size(z: Complex64) -> f64 {
    z.norm_sqr().sqrt()
}

/// Returns the angle of a number, rad.
pub(crate) fn angle(z: Complex64) -> f64 {
    libm::atan2(z.im, z.re)
}

/// Returns the number with this magnitude and angle, rad.
pub(crate) fn polar(size: f64, angle: f64) -> Complex64 {
    Complex64::new(size * libm::cos(angle), size * libm::sin(angle))
}
