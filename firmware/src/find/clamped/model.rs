//! Model of the admittance off resonance, and its derivatives by each element.
//!
//! With `u = f / f_nominal = 1 + x`, and relative to the nominal clamped susceptance `w C0`:
//!
//! ```text
//! Y(u) = exp(j theta u) (g + h x + j c u + j k u / (us^2 - u^2 + j d u us) + j k2 u / (u2^2 - u^2 + j d2 u u2))
//! ```
//!
//! `c` is the clamped capacitance and `g + h x` its loss. A leak is constant; the loss of a
//! dielectric grows with frequency, and that of DAC images with its square. `k = Cm / C0 us^2` is
//! the motional branch, with its resonance `us` and its loss `d = 1 / Q`. `k2`, `u2`, `d2` describe
//! a second branch (Butterworth 1914, Van Dyke 1928). `theta` is the rotation by the sensing chain:
//! skew between the converters, delay of an image. Loss affects the clamped part only, skew also
//! the motional part; this distinguishes them.

use crate::generate::shape::sine;
use crate::seam::phasor::Phasor;

const J: Phasor = Phasor::new(0.0, 1.0);

/// Number of unknowns of the model.
pub(crate) const UNKNOWNS: usize = 10;
/// Index of the clamped capacitance `c`.
pub(crate) const C: usize = 0;
/// Index of the loss of the clamped branch at the nominal frequency, `g`.
pub(crate) const G: usize = 1;
/// Index of the slope of that loss, `h`.
pub(crate) const H: usize = 2;
/// Index of the strength of the resonance, `k`.
pub(crate) const K: usize = 3;
/// Index of the resonance, `us - 1`.
pub(crate) const XS: usize = 4;
/// Index of the loss of the resonance, `d`.
pub(crate) const D: usize = 5;
/// Index of the rotation by the sensing chain, `theta`, rad at the nominal frequency.
pub(crate) const THETA: usize = 6;
/// Index of the strength of a second resonance, `k2`.
pub(crate) const K2: usize = 7;
/// Index of the second resonance, `u2 - 1`.
pub(crate) const X2: usize = 8;
/// Index of the loss of the second resonance, `d2`.
pub(crate) const D2: usize = 9;

/// Elements of the model. Resonances are stored as `us - 1`, which f32 resolves to 1e-9.
pub(crate) type Elements = [f32; UNKNOWNS];

/// Computes `exp(j angle)` for an angle of less than half a turn, rad. Error: 2e-7.
pub(crate) fn turn(angle: f32) -> Phasor {
    /// Phase steps per radian, with 2^32 steps per turn.
    const STEPS_PER_RADIAN: f32 = 4_294_967_296.0 / core::f32::consts::TAU;
    sine::rotation(u64::from((angle * STEPS_PER_RADIAN) as i32 as u32) << 32)
}

/// Computes a motional branch `j u / (ur^2 - u^2 + j d u ur)` and its derivatives by `ur` and `d`.
fn branch(x: f32, resonance: f32, d: f32) -> (Phasor, Phasor, Phasor) {
    let (u, ur) = (1.0 + x, 1.0 + resonance);
    let below = Phasor::new((resonance - x) * (ur + u), d * u * ur);
    let inverse = below.inv();
    let branch = J * u * inverse;
    let by_resonance = -branch * inverse * Phasor::new(2.0 * ur, d * u);
    (branch, by_resonance, -branch * inverse * Phasor::new(0.0, u * ur))
}

/// Computes the admittance at `1 + x` and its derivatives by the elements.
pub(crate) fn admittance(e: &Elements, x: f32) -> (Phasor, [Phasor; UNKNOWNS]) {
    let u = 1.0 + x;
    let turned = turn(e[THETA] * u);
    let (first, first_by_x, first_by_d) = branch(x, e[XS], e[D]);
    let (second, second_by_x, second_by_d) = branch(x, e[X2], e[D2]);
    let y = turned * (Phasor::new(e[G] + e[H] * x, e[C] * u) + first * e[K] + second * e[K2]);
    let by = [
        turned * J * u,
        turned,
        turned * x,
        turned * first,
        turned * first_by_x * e[K],
        turned * first_by_d * e[K],
        J * u * y,
        turned * second,
        turned * second_by_x * e[K2],
        turned * second_by_d * e[K2],
    ];
    (y, by)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::phasor::magnitude;

    #[test]
    fn derivatives_are_those_of_the_admittance() {
        let e: Elements = [1.03, 0.01, 0.02, 0.07, 0.013, 0.02, 0.01, 0.015, 0.07, 0.01];
        for x in [-0.2, -0.05, 0.05, 0.15] {
            let (_, by) = admittance(&e, x);
            for n in 0..UNKNOWNS {
                let step = if n == XS || n == X2 { 1e-4 } else { 1e-3 };
                let moved = |by: f32| admittance(&core::array::from_fn(|k| e[k] + if k == n { by } else { 0.0 }), x).0;
                let slope = (moved(step) - moved(-step)) / (2.0 * step);
                // Measured: 1.1e-3 of the slope, by rounding.
                assert!(magnitude(slope - by[n]) < 2e-3 * (1.0 + magnitude(slope)), "{n} at {x}: {slope} {}", by[n]);
            }
        }
    }
}
