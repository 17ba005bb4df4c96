//! Scattering parameters of two ports against the reference of port 1.
//!
//! With voltages `v` and currents `i` into the ports, they are a relation `P v + Q i = 0`:
//!
//! ```text
//! Z  v = Z i     H  (v1, i2) = H (i1, v2)
//! Y  i = Y v     G  (i1, v2) = G (v1, i2)
//! v = d (a + b),  i = (a - b) / d,  d = sqrt R:   (P d - Q / d) b = -(P d + Q / d) a
//! ```

use num_complex::Complex64;

use super::options::Kind;

/// Matrix of two ports.
pub(super) type Matrix = [[Complex64; 2]; 2];

/// Returns the scattering parameters of two ports against the reference of port 1, not finite if
/// there are none. `ohm` contains the references of the ports, ohm.
pub(super) fn scattering(own: Matrix, kind: Kind, ohm: [f64; 2], is_normalised: bool) -> Matrix {
    const ONE: Complex64 = Complex64::ONE;
    const ZERO: Complex64 = Complex64::ZERO;
    let [[a, b], [c, d]] = own;
    let (p, q) = match kind {
        Kind::S => return renormalised(own, ohm),
        Kind::Z => ([[ONE, ZERO], [ZERO, ONE]], [[-a, -b], [-c, -d]]),
        Kind::Y => (own, [[-ONE, ZERO], [ZERO, -ONE]]),
        Kind::H => ([[ONE, -b], [ZERO, -d]], [[-a, ZERO], [-c, ONE]]),
        Kind::G => ([[-a, ZERO], [-c, ONE]], [[ONE, -b], [ZERO, -d]]),
    };
    // Normalised parameters belong to ports with a reference of one.
    let root = if is_normalised { 1.0 } else { ohm[0].sqrt() };
    let term = |row: usize, column: usize, sign: f64| p[row][column] * root + sign * q[row][column] / root;
    let [left, right] = [-1.0, 1.0].map(|sign| [0, 1].map(|row| [0, 1].map(|column| term(row, column, sign))));
    let determinant = left[0][0] * left[1][1] - left[0][1] * left[1][0];
    let inverse = [[left[1][1], -left[0][1]], [-left[1][0], left[0][0]]];
    let entry = |row: usize, column: usize| -(inverse[row][0] * right[0][column] + inverse[row][1] * right[1][column]);
    let found = [0, 1].map(|row| [0, 1].map(|column| entry(row, column) / determinant));
    if is_normalised { renormalised(found, ohm) } else { found }
}

/// Converts scattering parameters so that port 2 has the reference of port 1.
fn renormalised([[s11, s12], [s21, s22]]: Matrix, ohm: [f64; 2]) -> Matrix {
    let step = (ohm[0] - ohm[1]) / (ohm[0] + ohm[1]);
    let [back, through] = [step, (1.0 - step * step).sqrt()].map(|part| part / (1.0 - step * s22));
    [[s11 + s12 * s21 * back, s12 * through], [s21 * through, (s22 - step) / (1.0 - step * s22)]]
}
