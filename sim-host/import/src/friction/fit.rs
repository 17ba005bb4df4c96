//! Fits of the contact models to the OFF part of a log, and the choice of a model.
//!
//! A model is started from several stiffnesses and Stribeck velocities within the resolution of the
//! log, and the best result is used. Another result that explains the log nearly as well is also
//! reported. The choice is by Bayes's information criterion, `n ln(sum of squares) + p ln n`. `n`
//! is the number of samples divided by the memory of the best model's residuals, because the
//! samples of a slow drift are not independent.

use nalgebra::DMatrix;

use super::certainty::{covariance, memory};
use super::log::Log;
use super::models::Model;
use super::start;
use crate::least_squares::{Linear, Solution, minimise};

/// A fitted model with its residuals.
pub(crate) struct Searched {
    /// Model.
    pub(super) model: Model,
    /// Parameters of the fit.
    pub(super) fitted: Vec<f64>,
    /// Covariance of the parameters.
    pub(super) covariance: DMatrix<f64>,
    /// Other parameters that explain the log nearly as well.
    pub(super) rivals: Vec<Vec<f64>>,
    /// Residuals of the used samples, N.
    pub(super) residuals: Vec<f64>,
}

/// Largest rise of `n ln(sum of squares)` of another result that explains the log nearly as well:
/// three standard deviations.
const MAX_RIVAL_RISE: f64 = 9.0;

/// Fits a model; `None` if no start leads to a finite result.
pub(super) fn search(model: Model, log: &Log, used: &[bool]) -> Option<Searched> {
    let evaluate = |fitted: &[f64]| residuals(model, fitted, log, used);
    let linear = |fitted: &[f64]| {
        let residuals = evaluate(fitted)?;
        Some(Linear { residuals, columns: slopes(model, fitted, evaluate)? })
    };
    let cost = |fitted: &Vec<f64>| evaluate(fitted).map_or(f64::INFINITY, |r| r.iter().map(|r| r * r).sum::<f64>());
    let starts = start::followed(model, log, used, cost);
    let mut ends: Vec<Solution> = starts.iter().filter_map(|start| minimise(start, linear)).collect();
    ends.retain(|end| end.cost.is_finite());
    ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let best = ends.first()?;
    let places: Vec<usize> = (0..used.len()).filter(|at| used[*at]).collect();
    let covariance = covariance(&best.linear, &places)?;
    let samples = best.linear.residuals.len() as f64 / memory(&best.linear.residuals);
    let is_near =
        |end: &&Solution| end.converged && samples * libm::log(end.cost / best.cost.max(f64::MIN_POSITIVE)) < MAX_RIVAL_RISE;
    let rivals = ends[1..].iter().filter(is_near).map(|end| end.parameters.clone()).collect();
    let (fitted, residuals) = (best.parameters.clone(), best.linear.residuals.clone());
    Some(Searched { model, fitted, covariance, rivals, residuals })
}

/// Computes the derivatives by each parameter of a model, by central differences.
pub(crate) fn slopes(model: Model, fitted: &[f64], of: impl Fn(&[f64]) -> Option<Vec<f64>>) -> Option<Vec<Vec<f64>>> {
    const STEP: f64 = 1e-5;
    let column = |at: usize| {
        let step = if model.parameters()[at].1 { STEP } else { STEP * (1e-3 + fitted[at].abs()) };
        let moved = |by: f64| {
            let mut moved = fitted.to_vec();
            moved[at] += by;
            of(&moved)
        };
        let (up, down) = (moved(step)?, moved(-step)?);
        Some(up.iter().zip(&down).map(|(up, down)| (up - down) / (2.0 * step)).collect())
    };
    (0..fitted.len()).map(column).collect()
}

/// Returns model minus measurement at the used samples, N.
fn residuals(model: Model, fitted: &[f64], log: &Log, used: &[bool]) -> Option<Vec<f64>> {
    let force = model.force(fitted, log);
    let error = force.iter().zip(&log.force_n).zip(used).filter(|(_, used)| **used).map(|((f, measured), _)| f - measured);
    let errors: Vec<f64> = error.collect();
    errors.iter().all(|error| error.is_finite()).then_some(errors)
}

/// Returns Bayes's information criterion of residuals with this memory.
pub(super) fn criterion(residuals: &[f64], parameters: usize, memory: f64) -> f64 {
    let n = residuals.len() as f64 / memory;
    let mean = residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len().max(1) as f64;
    n * libm::log(mean.max(f64::MIN_POSITIVE)) + parameters as f64 * libm::log(n.max(2.0))
}
