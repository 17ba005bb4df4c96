//! Least squares by Levenberg and Marquardt, by normal equations with columns scaled to unit
//! length.
//!
//! ```text
//! (A + lambda I) d = -g,   A = D J'J D,   g = D J'r,   D = 1 / |column|
//! ```
//!
//! K. Levenberg, Q. Appl. Math. 2 (1944) 164; D. Marquardt, J. SIAM 11 (1963) 431. A problem has a
//! dozen parameters at most and is solved by a Cholesky factor of [`nalgebra`]. No product uses
//! kernels that differ between processors, so that the result is the same everywhere.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Residuals at given parameters, and their derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    /// Residuals.
    pub residuals: Vec<f64>,
    /// Derivatives of all residuals, for each parameter.
    pub columns: Vec<Vec<f64>>,
}

/// Result of a minimisation.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Parameters at the minimum.
    pub parameters: Vec<f64>,
    /// Residuals and derivatives at the minimum.
    pub linear: Linear,
    /// Sum of the squares of the residuals.
    pub cost: f64,
    /// `true` if the last step was small relative to a standard deviation.
    pub converged: bool,
}

/// Maximum number of steps.
const MAX_STEPS: usize = 200;
/// Step that counts as converged, standard deviations.
const CONVERGED_STEP_SIGMAS: f64 = 1e-5;
/// Maximum damping, beyond which a step would not change a number.
const MAX_DAMPING: f64 = 1e14;

impl Linear {
    fn cost(&self) -> f64 {
        self.residuals.iter().map(|r| r * r).sum()
    }

    /// Returns the normal equations: scaled matrix, scaled gradient, scales.
    pub fn normal(&self) -> (DMatrix<f64>, DVector<f64>, Vec<f64>) {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let columns = &self.columns;
        let scale = |column: &Vec<f64>| {
            let length = dot(column, column).sqrt();
            if length > 0.0 { 1.0 / length } else { 1.0 }
        };
        let scales: Vec<f64> = columns.iter().map(scale).collect();
        let n = columns.len();
        let mut matrix = DMatrix::zeros(n, n);
        for (i, j) in (0..n).flat_map(|i| (i..n).map(move |j| (i, j))) {
            matrix[(i, j)] = scales[i] * scales[j] * dot(&columns[i], &columns[j]);
            matrix[(j, i)] = matrix[(i, j)];
        }
        let gradient = DVector::from_fn(n, |i, _| scales[i] * dot(&columns[i], &self.residuals));
        (matrix, gradient, scales)
    }
}

impl Solution {
    /// Returns the covariance of the parameters for residuals of variance one; `None` if the data
    /// do not determine them.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        let (matrix, _, scales) = self.linear.normal();
        let inverse = factor(matrix)?.inverse();
        let n = scales.len();
        let covariance = DMatrix::from_fn(n, n, |i, j| scales[i] * scales[j] * inverse[(i, j)]);
        covariance.iter().all(|value| value.is_finite()).then_some(covariance)
    }
}

/// Factorises a matrix with ones on its diagonal; `None` if it is singular to numerical precision.
fn factor(matrix: DMatrix<f64>) -> Option<Cholesky<f64, Dyn>> {
    const MIN_PIVOT: f64 = 1e-7;
    let n = matrix.nrows();
    let factor = Cholesky::new(matrix)?;
    (0..n).all(|i| factor.l_dirty()[(i, i)] > MIN_PIVOT).then_some(factor)
}

/// Minimises the sum of squares from a start; `None` if the residuals at the start are undefined.
pub fn minimise(start: &[f64], evaluate: impl Fn(&[f64]) -> Option<Linear>) -> Option<Solution> {
    minimise_within(MAX_STEPS, &[], start, evaluate)
}

/// Minimises the sum of squares from a start within a number of steps, as [`minimise`] does, and
/// keeps the parameters within bounds; none if `bounds` is empty. A parameter at its bound stays
/// there while the sum of squares falls beyond it.
pub(crate) fn minimise_within(
    steps: usize,
    bounds: &[(f64, f64)],
    start: &[f64],
    evaluate: impl Fn(&[f64]) -> Option<Linear>,
) -> Option<Solution> {
    let clamped = |at: usize, p: f64| bounds.get(at).map_or(p, |(least, most)| p.clamp(*least, *most));
    let mut parameters: Vec<f64> = start.iter().enumerate().map(|(at, p)| clamped(at, *p)).collect();
    let mut linear = evaluate(&parameters)?;
    let mut cost = linear.cost();
    let freedom = linear.residuals.len().saturating_sub(start.len()).max(1) as f64;
    let (mut damping, mut converged) = (1e-3, false);
    let (mut matrix, mut gradient, mut scales) = linear.normal();
    for _ in 0..steps.min(MAX_STEPS) {
        if !cost.is_finite() || cost == 0.0 {
            converged = cost == 0.0;
            break;
        }
        let n = parameters.len();
        let is_held = |at: usize| {
            let bound = bounds.get(at).map(|(least, most)| if gradient[at] > 0.0 { least } else { most });
            bound.is_some_and(|bound| parameters[at] == *bound)
        };
        let held: Vec<bool> = (0..n).map(is_held).collect();
        let damped = |i: usize, j: usize| match i == j {
            true => matrix[(i, i)] + damping,
            false if held[i] || held[j] => 0.0,
            false => matrix[(i, j)],
        };
        let free = DVector::from_fn(n, |at, _| if held[at] { 0.0 } else { gradient[at] });
        let step = Cholesky::new(DMatrix::from_fn(n, n, damped)).map(|factor| -factor.solve(&free));
        let next = step.as_ref().and_then(|step| {
            let next: Vec<f64> = (0..n).map(|at| clamped(at, parameters[at] + step[at] * scales[at])).collect();
            let linear = evaluate(&next)?;
            let new = linear.cost();
            (new <= cost).then_some((next, linear, new))
        });
        let deviations = step.map_or(f64::INFINITY, |step| (step.norm_squared() * freedom / cost).sqrt());
        match next {
            Some((next, better, new)) => {
                (parameters, linear, cost) = (next, better, new);
                (matrix, gradient, scales) = linear.normal();
                damping = (damping * 0.1).max(1e-12);
                if deviations < CONVERGED_STEP_SIGMAS {
                    converged = true;
                    break;
                }
            }
            None => {
                if deviations < CONVERGED_STEP_SIGMAS {
                    converged = true;
                    break;
                }
                damping *= 8.0;
                if damping > MAX_DAMPING {
                    break;
                }
            }
        }
    }
    Some(Solution { parameters, linear, cost, converged })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's function as residuals `10 (y - x^2)`, `1 - x`.
    #[test]
    fn rosenbrocks_function_is_minimised() {
        let valley = |p: &[f64]| {
            let (x, y) = (p[0], p[1]);
            Some(Linear { residuals: vec![10.0 * (y - x * x), 1.0 - x], columns: vec![vec![-20.0 * x, -1.0], vec![10.0, 0.0]] })
        };
        let found = minimise(&[-1.2, 1.0], valley).unwrap();
        assert!((found.parameters[0] - 1.0).abs() < 1e-9 && (found.parameters[1] - 1.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn a_bounded_minimum_is_at_the_bound_and_optimal_along_it() {
        let x = [0.0, 1.0, 2.0, 3.0];
        let line = |p: &[f64]| {
            let residuals = x.iter().map(|x| p[0] + p[1] * x - (1.0 + 2.0 * x)).collect();
            Some(Linear { residuals, columns: vec![vec![1.0; 4], x.to_vec()] })
        };
        let bounds = [(f64::NEG_INFINITY, f64::INFINITY), (0.0, 1.5)];
        let found = minimise_within(MAX_STEPS, &bounds, &[0.0, 3.0], line).unwrap();
        // The mean of x is 1.5: the rest of the slope, 0.5, is added to the offset there.
        assert!(found.converged && found.parameters[1] == 1.5 && (found.parameters[0] - 1.75).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn a_line_has_the_covariance_of_the_textbook() {
        let x = [0.0, 1.0, 2.0, 3.0];
        let line = |p: &[f64]| {
            let residuals = x.iter().map(|x| p[0] + p[1] * x - (1.0 + 2.0 * x)).collect();
            Some(Linear { residuals, columns: vec![vec![1.0; 4], x.to_vec()] })
        };
        let covariance = minimise(&[0.0, 0.0], line).unwrap().covariance().unwrap();
        assert!((covariance[(0, 0)] - 0.7).abs() < 1e-12 && (covariance[(1, 1)] - 0.2).abs() < 1e-12);
    }

    #[test]
    fn indistinguishable_parameters_have_no_covariance() {
        let same = |p: &[f64]| Some(Linear { residuals: vec![p[0] + p[1] - 1.0; 3], columns: vec![vec![1.0; 3], vec![1.0; 3]] });
        assert!(minimise(&[0.0, 0.0], same).unwrap().covariance().is_none());
    }
}
