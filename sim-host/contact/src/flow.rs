//! Exact flow of a linear system over a fixed step.
//!
//! For `x' = A x + B u` with `u` held, `x(t + h) = exp(A h) x + (integral of exp(A s) ds) B u`.
//! Both come from one matrix exponential of the augmented matrix (Van Loan 1978), here by scaling
//! and squaring of its Taylor series. If a DAC holds `u`, this solution is exact, and the fast pole
//! of the clamped capacitance does not limit the step.
//!
//! For a matrix that is a polynomial in a parameter, the same arithmetic on truncated polynomials
//! gives the exponential as a polynomial. Its coefficients are the Taylor coefficients in that
//! parameter, without difference quotients.

/// Square matrix, in row-major order.
pub type Matrix<const M: usize> = [[f64; M]; M];

/// Computes the matrix exponential `exp(a)`, to round-off.
pub fn exponential<const M: usize>(a: &Matrix<M>) -> Matrix<M> {
    let halvings = halvings(a);
    let scale = 0.5f64.powi(halvings);
    let scaled = a.map(|row| row.map(|x| x * scale));
    let mut term = identity();
    let mut sum = identity();
    for k in 1..=TERMS {
        term = product(&term, &scaled).map(|row| row.map(|x| x / f64::from(k)));
        accumulate(&mut sum, &term);
    }
    (0..halvings).fold(sum, |squared, _| product(&squared, &squared))
}

/// Computes the first `K` coefficients of `exp(a0 + a1 s + a2 s^2)` as a polynomial in `s`, to
/// round-off. The first equals [`exponential`] bit for bit.
pub fn exponential_series<const M: usize, const K: usize>(a: &[Matrix<M>; 3]) -> [Matrix<M>; K] {
    let halvings = halvings(&a[0]);
    let scale = 0.5f64.powi(halvings);
    let mut scaled = [[[0.0; M]; M]; K];
    for (to, from) in scaled.iter_mut().zip(a) {
        *to = from.map(|row| row.map(|x| x * scale));
    }
    let mut sum = [[[0.0; M]; M]; K];
    sum[0] = identity();
    let mut term = sum;
    for k in 1..=TERMS {
        term = series_product(&term, &scaled, a.len()).map(|matrix| matrix.map(|row| row.map(|x| x / f64::from(k))));
        sum.iter_mut().zip(&term).for_each(|(sum, term)| accumulate(sum, term));
    }
    (0..halvings).fold(sum, |squared, _| series_product(&squared, &squared, K))
}

/// Multiplies two polynomials, of which the second has `terms` coefficients, and truncates the
/// product.
fn series_product<const M: usize, const K: usize>(a: &[Matrix<M>; K], b: &[Matrix<M>; K], terms: usize) -> [Matrix<M>; K] {
    std::array::from_fn(|degree| {
        let first = product(&a[degree], &b[0]);
        (1..terms.min(degree + 1)).fold(first, |mut sum, j| {
            accumulate(&mut sum, &product(&a[degree - j], &b[j]));
            sum
        })
    })
}

/// Number of terms of the Taylor series for a norm below 1/8; the last term is below 1e-23.
const TERMS: i32 = 14;

/// Returns the number of halvings that bring the norm below 1/8.
fn halvings<const M: usize>(a: &Matrix<M>) -> i32 {
    let norm = a.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    if norm > 0.125 { (norm * 8.0).log2().ceil() as i32 } else { 0 }
}

fn accumulate<const M: usize>(sum: &mut Matrix<M>, term: &Matrix<M>) {
    for (row, add) in sum.iter_mut().zip(term) {
        row.iter_mut().zip(add).for_each(|(x, y)| *x += y);
    }
}

fn identity<const M: usize>() -> Matrix<M> {
    std::array::from_fn(|r| std::array::from_fn(|c| if r == c { 1.0 } else { 0.0 }))
}

fn product<const M: usize>(a: &Matrix<M>, b: &Matrix<M>) -> Matrix<M> {
    let mut product = [[0.0; M]; M];
    // Working row by row lets the compiler use vector registers.
    for (row, factors) in product.iter_mut().zip(a) {
        for (factor, other) in factors.iter().zip(b) {
            row.iter_mut().zip(other).for_each(|(x, y)| *x += factor * y);
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotation_is_exact_over_many_turns() {
        let angle = 100.3;
        let e = exponential(&[[0.0, -angle], [angle, 0.0]]);
        assert!((e[0][0] - angle.cos()).abs() < 1e-12 && (e[1][0] - angle.sin()).abs() < 1e-12, "{e:?}");
    }

    /// Rotation whose angle is linear in `s`: the coefficients are the derivatives of a cosine over
    /// the factorials.
    #[test]
    fn a_series_has_the_derivatives() {
        let (angle, slope) = (1.3, 0.4);
        let matrix = |angle: f64| [[0.0, -angle], [angle, 0.0]];
        let series: [Matrix<2>; 5] = exponential_series(&[matrix(angle), matrix(slope), matrix(0.0)]);
        let derivatives = [angle.cos(), -angle.sin(), -angle.cos(), angle.sin(), angle.cos()];
        let mut factor = 1.0;
        for (k, (matrix, derivative)) in series.iter().zip(derivatives).enumerate() {
            assert!((matrix[0][0] - derivative * factor).abs() < 1e-15, "{k}: {matrix:?}");
            factor *= slope / (k + 1) as f64;
        }
        assert_eq!(series[0], exponential(&matrix(angle)));
    }

    #[test]
    fn stiff_and_slow_parts_are_accurate_together() {
        // Twelve squarings multiply a round-off error near one by up to 2^12: 9e-13.
        let e = exponential(&[[-300.0, 0.0], [0.0, -1e-6]]);
        assert!(e[0][0] < 1e-100 && (e[1][1] - (-1e-6f64).exp()).abs() < 1e-12, "{e:?}");
    }
}
