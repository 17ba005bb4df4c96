//! Fits of the contact models to the OFF part of a log, and the choice of a model.
//!
//! A model is started from several stiffnesses and Stribeck velocities within the resolution of the
//! log, and the best result is used. Another result that explains the log nearly as well is also
//! reported. The choice is by Bayes's information criterion, `n ln(sum of squares) + p ln n`. `n`
//! is the number of samples divided by the memory of the best model's residuals, because the
//! samples of a slow drift are not independent.
//!
//! A long log is searched in two shorter ones. The result that explains all samples best is fitted
//! to all of them in a few steps. Parameters, covariance and residuals are those of the whole log.

use nalgebra::DMatrix;

use super::certainty::covariance;
use super::log::Log;
use super::models::Model;
use super::start;
use crate::least_squares::{Linear, Solution, minimise_within};
use crate::rows::memory;

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

/// Maximum number of samples of a log that is searched itself.
const MAX_SEARCHED_SAMPLES: usize = 2000;
/// Maximum number of steps of the fit to all samples of a long log, times their number.
const MAX_SAMPLE_STEPS: usize = 300_000;

/// Fits a model to the part without vibration; `None` if no start leads to a finite result.
pub(super) fn search(model: Model, log: &Log) -> Option<Searched> {
    let used: &[bool] = &log.on.iter().map(|on| !on).collect::<Vec<_>>();
    let long = used.len() > MAX_SEARCHED_SAMPLES;
    let evaluate = |fitted: &[f64]| residuals(model, fitted, log, used);
    let linear = |fitted: &[f64]| {
        let residuals = evaluate(fitted)?;
        let columns = slopes(model, fitted, evaluate, long.then_some(&residuals))?;
        Some(Linear { residuals, columns })
    };
    let cost = |fitted: &Vec<f64>| evaluate(fitted).map_or(f64::INFINITY, |r| r.iter().map(|r| r * r).sum::<f64>());
    let (starts, mut rivals, steps) = if long {
        let found = log.shortened(MAX_SEARCHED_SAMPLES / 2).into_iter().filter_map(|log| search(model, &log));
        let found = found.min_by(|a, b| cost(&a.fitted).total_cmp(&cost(&b.fitted)))?;
        // Ends in the same minimum differ by less than their uncertainty.
        let is_other = |rival: &&Vec<f64>| {
            (0..rival.len()).any(|at| (rival[at] - found.fitted[at]).powi(2) > MAX_RIVAL_RISE * found.covariance[(at, at)])
        };
        let rivals = found.rivals.iter().filter(is_other).cloned().collect();
        (vec![found.fitted], rivals, (MAX_SAMPLE_STEPS / used.len()).max(1))
    } else {
        (start::followed(model, log, used, cost), Vec::new(), usize::MAX)
    };
    let mut ends: Vec<Solution> = starts.iter().filter_map(|start| minimise_within(steps, start, linear)).collect();
    ends.retain(|end| end.cost.is_finite());
    ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let best = ends.first()?;
    let places: Vec<usize> = (0..used.len()).filter(|at| used[*at]).collect();
    let covariance = covariance(&best.linear, &places)?;
    let samples = best.linear.residuals.len() as f64 / memory(&[&best.linear.residuals]).1;
    let is_near =
        |end: &&Solution| end.converged && samples * libm::log(end.cost / best.cost.max(f64::MIN_POSITIVE)) < MAX_RIVAL_RISE;
    rivals.extend(ends[1..].iter().filter(is_near).map(|end| end.parameters.clone()));
    let (fitted, residuals) = (best.parameters.clone(), best.linear.residuals.clone());
    Some(Searched { model, fitted, covariance, rivals, residuals })
}

/// Computes the derivatives by each parameter of a model, by central differences; by one-sided ones
/// if the values at the parameters are given.
pub(crate) fn slopes(
    model: Model,
    fitted: &[f64],
    of: impl Fn(&[f64]) -> Option<Vec<f64>>,
    here: Option<&Vec<f64>>,
) -> Option<Vec<Vec<f64>>> {
    const STEP: f64 = 1e-5;
    let column = |at: usize| {
        let step = if model.parameters()[at].1 { STEP } else { STEP * (1e-3 + fitted[at].abs()) };
        let moved = |by: f64| {
            let mut moved = fitted.to_vec();
            moved[at] += by;
            of(&moved)
        };
        let mut column = moved(step)?;
        match here {
            Some(here) => column.iter_mut().zip(here).for_each(|(up, here)| *up = (*up - here) / step),
            None => column.iter_mut().zip(moved(-step)?).for_each(|(up, down)| *up = (*up - down) / (2.0 * step)),
        }
        Some(column)
    };
    (0..fitted.len()).map(column).collect()
}

/// Returns model minus measurement at the used samples, N.
fn residuals(model: Model, fitted: &[f64], log: &Log, used: &[bool]) -> Option<Vec<f64>> {
    let mut errors = model.force(fitted, log);
    errors.iter_mut().zip(&log.force_n).for_each(|(error, measured)| *error -= measured);
    let mut used = used.iter();
    errors.retain(|_| used.next() == Some(&true));
    errors.iter().all(|error| error.is_finite()).then_some(errors)
}

/// Returns Bayes's information criterion of residuals with this memory.
pub(super) fn criterion(residuals: &[f64], parameters: usize, memory: f64) -> f64 {
    let n = residuals.len() as f64 / memory;
    let mean = residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len().max(1) as f64;
    n * libm::log(mean.max(f64::MIN_POSITIVE)) + parameters as f64 * libm::log(n.max(2.0))
}
