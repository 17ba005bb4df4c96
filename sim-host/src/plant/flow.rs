//! Exact flow of a linear system over a fixed step.
//!
//! For `x' = A x + B u` with `u` held, `x(t + h) = exp(A h) x + (integral of exp(A s) ds) B u`. Both come from one matrix
//! exponential of the augmented matrix (Van Loan 1978), here by scaling and squaring of its Taylor series. Nothing is
//! approximated: a DAC that really holds makes this exact, and the fast pole of the clamped capacitance limits no step.

/// A square matrix, row by row.
pub type Matrix<const M: usize> = [[f64; M]; M];

/// `exp(a)`, to round-off.
pub fn exponential<const M: usize>(a: &Matrix<M>) -> Matrix<M> {
    let norm = a.iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
    // Halve until the norm is below 1/8; then the 14th term is below 1e-23.
    let halvings = if norm > 0.125 { (norm * 8.0).log2().ceil() as i32 } else { 0 };
    let scale = 0.5f64.powi(halvings);
    let scaled = a.map(|row| row.map(|x| x * scale));
    let mut term = identity();
    let mut sum = identity();
    for k in 1..=14 {
        term = product(&term, &scaled).map(|row| row.map(|x| x / f64::from(k)));
        for (row, add) in sum.iter_mut().zip(&term) {
            row.iter_mut().zip(add).for_each(|(x, y)| *x += y);
        }
    }
    (0..halvings).fold(sum, |squared, _| product(&squared, &squared))
}

fn identity<const M: usize>() -> Matrix<M> {
    std::array::from_fn(|r| std::array::from_fn(|c| if r == c { 1.0 } else { 0.0 }))
}

fn product<const M: usize>(a: &Matrix<M>, b: &Matrix<M>) -> Matrix<M> {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..M).map(|k| a[r][k] * b[k][c]).sum()))
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

    #[test]
    fn stiff_and_slow_parts_stand_together() {
        // Squaring twelve times carries the round-off of one up to 2^12 times: 9e-13.
        let e = exponential(&[[-300.0, 0.0], [0.0, -1e-6]]);
        assert!(e[0][0] < 1e-100 && (e[1][1] - (-1e-6f64).exp()).abs() < 1e-12, "{e:?}");
    }
}
