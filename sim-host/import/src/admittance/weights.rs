//! Weights: standard deviation of the noise in each coordinate of each point, from residuals.
//!
//! A residual `e` is in the coordinate of the instrument. For a scattering parameter it is the
//! difference, for an immittance that of the logarithms: its real part is an error of the
//! magnitude, its imaginary part one of the angle. Its variance is
//!
//! ```text
//! scattering    v = a + b |S|^2                          receiver noise, trace noise
//! immittance    v = a + b / |Y|^2 + c |Y|^2              error of ratio, floor of current, floor of voltage
//! ```
//!
//! with non-negative coefficients, by maximum likelihood. A term is used only if Bayes's
//! information criterion accepts it.

use num_complex::Complex64;

use super::coordinate::Coordinate;
use crate::complex::size;

/// Smallest standard deviation, relative to a scattering parameter of one or to an admittance.
const MIN_SD_REL: f64 = 1e-8;
/// Smallest variance of a scattering parameter, relative to the mean.
const MIN_VARIANCE_REL: f64 = 0.3;

/// Standard deviations of the real and imaginary part of each point's residual.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Weights(pub(super) Vec<[f64; 2]>);

impl Weights {
    /// Creates equal weights of rows for the means of these numbers of rows.
    pub(super) fn equal(counts: &[f64]) -> Self {
        Weights(counts.iter().map(|count| [1.0 / count.sqrt(); 2]).collect())
    }

    /// Determines weights from the residuals of a fit with the admittances `fitted`. A mean of `n`
    /// rows has the variance `v / n`.
    pub(super) fn from_residuals(coordinate: Coordinate, fitted: &[Complex64], means: &[Complex64], counts: &[f64]) -> Self {
        let residuals: Vec<Complex64> = means.iter().zip(counts).map(|(mean, count)| mean * count.sqrt()).collect();
        let square = |of: &dyn Fn(&Complex64) -> f64| residuals.iter().map(of).map(|e| e * e).collect::<Vec<f64>>();
        let (re, im) = (square(&|e| e.re), square(&|e| e.im));
        let (of_re, of_im) = match coordinate {
            Coordinate::Scattering(..) => {
                let terms = [fitted.iter().map(|_| 1.0).collect(), fitted.iter().map(|y| coordinate.of(*y).norm_sqr()).collect()];
                let both: Vec<f64> = re.iter().zip(&im).map(|(re, im)| 0.5 * (re + im)).collect();
                let mut variance = variances(&terms, &both);
                // A receiver has noise even for a small signal: a few such points must not
                // dominate.
                let least = MIN_VARIANCE_REL * variance.iter().sum::<f64>() / variance.len().max(1) as f64;
                variance.iter_mut().for_each(|v| *v = v.max(least));
                (variance.clone(), variance)
            }
            Coordinate::Immittance => {
                // Relative to the geometric mean, so that the terms have similar magnitudes.
                let ln = fitted.iter().map(|y| libm::log(size(*y).max(1e-30))).sum::<f64>() / fitted.len().max(1) as f64;
                let middle = libm::exp(2.0 * ln);
                let of = |y: &Complex64| y.norm_sqr().max(1e-60) / middle;
                let terms = [
                    fitted.iter().map(|_| 1.0).collect(),
                    fitted.iter().map(|y| 1.0 / of(y)).collect(),
                    fitted.iter().map(of).collect(),
                ];
                (variances(&terms, &re), variances(&terms, &im))
            }
        };
        let sd = |((re, im), count): ((&f64, &f64), &f64)| [re, im].map(|v| v.sqrt().max(MIN_SD_REL) / count.sqrt());
        Weights(of_re.iter().zip(&of_im).zip(counts).map(sd).collect())
    }
}

/// Fits the variance of each point to the squared residuals: the combination of terms with the best
/// value of the information criterion.
fn variances(terms: &[Vec<f64>], squares: &[f64]) -> Vec<f64> {
    let floor = MIN_SD_REL * MIN_SD_REL;
    let points = squares.len();
    let sum = |coefficients: &[f64]| -> Vec<f64> {
        (0..points).map(|t| coefficients.iter().zip(terms).map(|(a, term)| a * term[t]).sum::<f64>().max(floor)).collect()
    };
    let mean = (squares.iter().sum::<f64>() / points.max(1) as f64).max(floor);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for subset in 1_usize..1 << terms.len() {
        let used: Vec<usize> = (0..terms.len()).filter(|term| subset >> term & 1 == 1).collect();
        let Some(coefficients) = likely(terms, &used, squares, mean, &sum) else { continue };
        let variance = sum(&coefficients);
        let loss: f64 = variance.iter().zip(squares).map(|(v, q)| libm::log(*v) + q / v).sum();
        let score = loss + used.len() as f64 * libm::log(points as f64);
        if best.as_ref().is_none_or(|(least, _)| score < *least) {
            best = Some((score, variance));
        }
    }
    best.map_or_else(|| vec![mean; points], |(_, variance)| variance)
}

/// Returns the coefficients of the used terms by Fisher scoring; `None` if one becomes negative.
fn likely(terms: &[Vec<f64>], used: &[usize], squares: &[f64], mean: f64, sum: &dyn Fn(&[f64]) -> Vec<f64>) -> Option<Vec<f64>> {
    const SCORING_ROUNDS: usize = 12;
    let n = used.len();
    let mut variance = vec![mean; squares.len()];
    let mut coefficients = vec![0.0; terms.len()];
    for _ in 0..SCORING_ROUNDS {
        let weighted = |a: &dyn Fn(usize) -> f64, b: &dyn Fn(usize) -> f64| {
            (0..squares.len()).map(|t| a(t) * b(t) / (variance[t] * variance[t])).sum::<f64>()
        };
        let matrix = nalgebra::DMatrix::from_fn(n, n, |i, j| weighted(&|t| terms[used[i]][t], &|t| terms[used[j]][t]));
        let right = nalgebra::DVector::from_fn(n, |i, _| weighted(&|t| terms[used[i]][t], &|t| squares[t]));
        let found = nalgebra::Cholesky::new(matrix)?.solve(&right);
        if found.iter().any(|a| !(*a > 0.0 && a.is_finite())) {
            return None;
        }
        used.iter().zip(found.iter()).for_each(|(term, a)| coefficients[*term] = *a);
        variance = sum(&coefficients);
    }
    Some(coefficients)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_noise_term_is_used_only_if_significant() {
        let x: Vec<f64> = (0..400).map(|t| 0.01 + f64::from(t) / 40.0).collect();
        let terms = [vec![1.0; 400], x.clone()];
        // Squares that alternate between 0.5 and 1.5 times their mean.
        let of = |mean: &dyn Fn(f64) -> f64| -> Vec<f64> {
            x.iter().enumerate().map(|(t, x)| mean(*x) * (0.5 + (t % 2) as f64)).collect()
        };
        let flat = variances(&terms, &of(&|_| 3.0));
        assert!(flat.iter().all(|v| (v - 3.0).abs() < 0.02), "{:?}", &flat[..3]);
        let rising = variances(&terms, &of(&|x| x));
        assert!(rising.iter().zip(&x).all(|(v, x)| (v / x - 1.0).abs() < 0.2), "{:?} {:?}", &rising[..3], &x[..3]);
    }
}
