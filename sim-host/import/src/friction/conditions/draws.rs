//! Random draws of the parameters from a fit: all intervals follow from them.
//!
//! A draw chooses a stiffness by its probability and a scale of the scatter of each group from its
//! chi-squared distribution, and then the other parameters from the normal distribution of the
//! weighted least squares. With many measurements the intervals are those of Student.

use nalgebra::{Cholesky, DVector};

use super::fit::Fit;
use super::model::Parameters;
use crate::synthetic::random::Random;
use report::statistics::{ascending, quantile};

/// Number of draws.
const DRAWS: usize = 4000;
/// Largest number of degrees of freedom that is drawn; more are equal to infinitely many.
const MAX_FREEDOM: usize = 400;
/// Probability of an interval.
const INTERVAL: f64 = 0.95;

/// Drawn parameters and scatter.
pub(super) struct Draw {
    pub(super) parameters: Parameters,
    /// Relative scatter of OFF and ON.
    pub(super) scatter: [f64; 2],
    /// Standard normal numbers, for the scatter of a new measurement.
    pub(super) normal: [f64; 2],
}

/// Value with an interval that contains the truth with a probability of 95 %.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Interval {
    /// Value.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Draws parameters from a fit.
pub(super) fn draw(fit: &Fit) -> Vec<Draw> {
    let mut random = Random::new(1);
    let total: f64 = fit.slices.iter().map(|slice| slice.weight).sum();
    let p = fit.model.count();
    let mut draws = Vec::with_capacity(DRAWS);
    let (mut at, mut sum) = (0, fit.slices[0].weight);
    for n in 0..DRAWS {
        while sum < total * (n as f64 + 0.5) / DRAWS as f64 && at + 1 < fit.slices.len() {
            at += 1;
            sum += fit.slices[at].weight;
        }
        let slice = &fit.slices[at];
        // Both groups share one scatter if either is too small.
        let mut scales = fit.freedom.map(|free| scale(&mut random, free));
        if fit.freedom[0] == fit.freedom[1] {
            scales[1] = scales[0];
        }
        let matrix = &slice.matrices[0] / scales[0].powi(2) + &slice.matrices[1] / scales[1].powi(2);
        let Some(factor) = Cholesky::new(matrix) else { continue };
        let z = DVector::from_fn(p, |_, _| random.normal());
        let Some(step) = factor.l().transpose().solve_upper_triangular(&z) else { continue };
        let fitted: Vec<f64> = slice.fitted.iter().zip(step.iter()).map(|(value, step)| value + step).collect();
        let scatter = [fit.scatter[0] * scales[0], fit.scatter[1] * scales[1]];
        let parameters = fit.model.parameters(&fitted, slice.ln_compliance);
        draws.push(Draw { parameters, scatter, normal: [random.normal(), random.normal()] });
    }
    draws
}

/// Draws a standard deviation relative to its estimate.
fn scale(random: &mut Random, free: f64) -> f64 {
    if !free.is_finite() {
        return 1.0;
    }
    let count = (free.round() as usize).clamp(1, MAX_FREEDOM);
    let square: f64 = (0..count).map(|_| random.normal().powi(2)).sum();
    (count as f64 / square).sqrt()
}

/// Returns the interval of a value of the draws.
pub(super) fn interval(value: f64, draws: &[Draw], of: impl Fn(&Draw) -> f64) -> Interval {
    let values = ascending(draws.iter().map(of).filter(|value| value.is_finite()));
    let at = |part: f64| quantile(&values, part).unwrap_or(f64::NAN);
    Interval { value, low: at(0.5 * (1.0 - INTERVAL)), high: at(0.5 * (1.0 + INTERVAL)) }
}
