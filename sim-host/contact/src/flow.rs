//! Exact flow of a linear system over a fixed step.
//!
//! For `x' = A x + B u` with `u` held, `x(t + h) = exp(A h) x + (integral of exp(A s) ds) B u`.
//! Both come from one matrix exponential of the augmented matrix (Van Loan 1978), here by scaling
//! and squaring of its Taylor series. If a DAC holds `u`, this solution is exact, and the fast pole
//! of the clamped capacitance does not limit the step.
//!
//! For a matrix that is a polynomial in some variables, the same arithmetic on truncated
//! polynomials gives the exponential as a polynomial. Its coefficients are the Taylor coefficients
//! in those variables, without difference quotients.

mod monomials;

pub use monomials::Monomials;

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

/// Computes the exponential of a polynomial `a` in several variables as a polynomial, to
/// round-off. The constant equals [`exponential`] of the constant of `a` bit for bit. Only the
/// first `size` rows and columns of `a` are used; the others of the result are those of one.
pub fn exponential_series<const M: usize>(a: &[Matrix<M>], size: usize, monomials: &Monomials) -> Vec<Matrix<M>> {
    let halvings = halvings(&a[0]);
    let scale = 0.5f64.powi(halvings);
    let scaled: Vec<Matrix<M>> = a.iter().map(|matrix| matrix.map(|row| row.map(|x| x * scale))).collect();
    let all = &monomials.products;
    let with_a: Vec<[usize; 3]> = all.iter().copied().filter(|&[_, second, _]| a[second] != [[0.0; M]; M]).collect();
    let mut sum = vec![[[0.0; M]; M]; a.len()];
    sum[0] = identity();
    let (mut term, mut next) = (sum.clone(), sum.clone());
    for k in 1..=TERMS {
        series_product(&mut next, &term, &scaled, size, &with_a);
        for (sum, term) in sum.iter_mut().zip(&mut next) {
            term[..size].as_flattened_mut().iter_mut().for_each(|x| *x /= f64::from(k));
            accumulate(&mut sum[..size], &term[..size]);
        }
        std::mem::swap(&mut term, &mut next);
    }
    for _ in 0..halvings {
        series_product(&mut next, &sum, &sum, size, all);
        std::mem::swap(&mut sum, &mut next);
    }
    sum
}

/// Multiplies two polynomials in their first `size` rows and columns; `products` are the places of
/// two factors and of their product.
#[inline(never)]
fn series_product<const M: usize>(to: &mut [Matrix<M>], a: &[Matrix<M>], b: &[Matrix<M>], size: usize, products: &[[usize; 3]]) {
    to.iter_mut().for_each(|matrix| matrix[..size].fill([0.0; M]));
    for &[first, second, place] in products {
        add_product(&mut to[place], &a[first], &b[second], size);
    }
}

/// Number of terms of the Taylor series for a norm below 1/8; the last term is below 1e-23.
const TERMS: i32 = 14;

/// Returns the number of halvings that bring the norm below 1/8.
fn halvings<const M: usize>(a: &Matrix<M>) -> i32 {
    let norm = a.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    if norm > 0.125 { (norm * 8.0).log2().ceil() as i32 } else { 0 }
}

fn accumulate<const M: usize>(sum: &mut [[f64; M]], term: &[[f64; M]]) {
    for (row, add) in sum.iter_mut().zip(term) {
        row.iter_mut().zip(add).for_each(|(x, y)| *x += y);
    }
}

fn identity<const M: usize>() -> Matrix<M> {
    std::array::from_fn(|r| std::array::from_fn(|c| if r == c { 1.0 } else { 0.0 }))
}

fn product<const M: usize>(a: &Matrix<M>, b: &Matrix<M>) -> Matrix<M> {
    let mut product = [[0.0; M]; M];
    add_product(&mut product, a, b, M);
    product
}

#[inline(always)]
fn add_product<const M: usize>(sum: &mut Matrix<M>, a: &Matrix<M>, b: &Matrix<M>, size: usize) {
    // Working row by row lets the compiler use vector registers.
    for (row, factors) in sum[..size].iter_mut().zip(a) {
        for (factor, other) in factors[..size].iter().zip(b) {
            row[..size].iter_mut().zip(other).for_each(|(x, y)| *x += factor * y);
        }
    }
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

    /// Rotation by `angle + slope s + r`: the coefficient of `s^n r^m` is the derivative of the
    /// cosine, times `slope^n / (n! m!)`.
    #[test]
    fn a_series_has_the_derivatives() {
        let (angle, slope) = (1.3, 0.4);
        let matrix = |angle: f64| [[0.0, -angle], [angle, 0.0]];
        let monomials = Monomials::new(2, 3);
        let mut a = vec![matrix(0.0); monomials.exponents().len()];
        for (exponents, by) in [([0, 0], angle), ([1, 0], slope), ([0, 1], 1.0)] {
            a[monomials.place(&exponents).unwrap()] = matrix(by);
        }
        let series = exponential_series(&a, 2, &monomials);
        let derivatives = [angle.cos(), -angle.sin(), -angle.cos(), angle.sin(), angle.cos()];
        let factorial = |n: u32| f64::from((1..=n).product::<u32>());
        for (matrix, exponents) in series.iter().zip(monomials.exponents()) {
            let (n, m) = (exponents[0], exponents[1]);
            let expected = derivatives[(n + m) as usize] * slope.powi(n as i32) / (factorial(n) * factorial(m));
            // Measured 2e-15: four squarings multiply a round-off of 1e-16 by up to 16.
            assert!((matrix[0][0] - expected).abs() < 3e-15, "{exponents:?}: {matrix:?}");
        }
        assert_eq!(series.len(), 10 + 2);
        assert_eq!(series[0], exponential(&matrix(angle)));
    }

    #[test]
    fn stiff_and_slow_parts_are_accurate_together() {
        // Twelve squarings multiply a round-off error near one by up to 2^12: 9e-13.
        let e = exponential(&[[-300.0, 0.0], [0.0, -1e-6]]);
        assert!(e[0][0] < 1e-100 && (e[1][1] - (-1e-6f64).exp()).abs() < 1e-12, "{e:?}");
    }
}
