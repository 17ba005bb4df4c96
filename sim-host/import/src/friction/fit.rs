//! Fits of the contact models to the OFF part of a log, and the errors that decide between them.
//!
//! A model is started from several stiffnesses and Stribeck velocities within the resolution of the
//! log, and the best result is used. Another result that explains the log nearly as well is also
//! reported. Two numbers compare models. Bayes's information criterion is
//! `n ln(sum of squares) + p ln n`; `n` is the number of samples divided by the memory of the best
//! model's residuals, because the samples of a slow drift are not independent. The held-out error
//! is that of segments of the log that the fit has not seen.
//!
//! The steps of the motion between two samples first suit the velocities of the log, and then the
//! fitted Stribeck velocity. All parameters stay within the bounds of a scene.
//!
//! A long log is searched in two shorter ones. The result that explains all samples best is fitted
//! to all of them in a few steps. Parameters, covariance and residuals are then those of the whole
//! log. A model that explains all samples much worse than another is not fitted to them.

use nalgebra::{Cholesky, DMatrix, DVector};
use rayon::prelude::*;

use super::certainty::covariance;
use super::log::Log;
use super::models::{Model, Parameter};
use super::motion::{self, Motion};
use super::start;
use crate::least_squares::{Linear, Solution, minimise_within};
use crate::rows::memory;

/// A fitted model with its residuals.
pub(crate) struct Searched {
    /// Model.
    pub(super) model: Model,
    /// Parameters, in the order of `fitted`.
    pub(super) parameters: Vec<Parameter>,
    /// Parameters of the fit.
    pub(super) fitted: Vec<f64>,
    /// `true` for parameters at a bound of a scene.
    pub(super) at_bound: Vec<bool>,
    /// Covariance of the parameters.
    pub(super) covariance: DMatrix<f64>,
    /// Other parameters that explain the log nearly as well.
    pub(super) rivals: Vec<Vec<f64>>,
    /// Residuals of the used samples, N.
    pub(super) residuals: Vec<f64>,
    /// Root mean square of the errors at samples that the fit has not seen, N.
    pub(super) held_out_n: f64,
    /// Force of the model at every sample, N.
    pub(super) force_n: Vec<f64>,
    /// Largest change of the velocity in a step of the motion, m/s.
    velocity_step: f64,
}

/// Largest rise of `n ln(sum of squares)` of another result that explains the log nearly as well:
/// three standard deviations.
const MAX_RIVAL_RISE: f64 = 9.0;

/// Maximum number of samples of a log that is searched itself.
const MAX_SEARCHED_SAMPLES: usize = 2000;
/// Maximum number of steps of the fit to all samples of a long log, times their number.
const MAX_SAMPLE_STEPS: usize = 300_000;
/// Largest mean square, relative to the best model's, of a model that is fitted to a long log.
const MAX_PART_RISE: f64 = 2.0;
/// Largest change of the velocity in a step of the motion, relative to the highest velocity.
const VELOCITY_STEP_REL: f64 = 0.05;
/// Smallest step of the velocity, relative to the highest velocity: a log hardly shows a Stribeck
/// velocity that needs a smaller one.
const MIN_VELOCITY_STEP_REL: f64 = 0.002;
/// Largest change of the velocity in a step of the motion, in Stribeck velocities.
const STRIBECK_STEP_REL: f64 = 0.25;
/// Largest new step of the motion for which a model is fitted again, relative to the step before.
const MIN_STEP_REDUCTION: f64 = 0.8;
/// Number of segments of a log for the held-out error.
const HELD_OUT_SEGMENTS: usize = 20;
/// Number of groups of these segments; the segments of one are held out together.
const HELD_OUT_GROUPS: usize = 5;
/// Number added to the diagonal of the held-out fit, whose columns have at most unit length.
const HELD_OUT_RIDGE: f64 = 1e-3;
/// Relative deviation of a stiffness, over the noise of the displacement relative to the travel
/// before sliding.
const STIFFNESS_PER_NOISE: f64 = 0.5;
/// Smallest and largest coefficient of friction of a fit; the largest is that of a scene.
pub(super) const MU: (f64, f64) = (1e-6, 5.0);

/// Returns the bounds of a fitted parameter: those of a scene.
fn bounds((name, is_log): &Parameter, normal_n: f64) -> (f64, f64) {
    let (least, most) = match *name {
        "coulomb_n" | "static_excess_n" => (MU.0 * normal_n, MU.1 * normal_n),
        "stribeck_m_per_s" => (1e-9, 1e3),
        "sigma2" => (0.0, 1e9),
        "stiffness_n_per_m" => (1.0, 1e12),
        _ => (f64::NEG_INFINITY, f64::INFINITY),
    };
    if *is_log { (libm::log(least), libm::log(most)) } else { (least, most) }
}

/// Fits all models to the part without vibration, with this number of parameters of the baseline.
/// A model without a finite result is left out.
pub(super) fn search(log: &Log, baseline: usize) -> Vec<Searched> {
    if log.on.len() <= MAX_SEARCHED_SAMPLES {
        return Model::SEARCHED.into_par_iter().filter_map(|model| search_model(model, log, baseline)).collect();
    }
    let parts = log.shortened(MAX_SEARCHED_SAMPLES / 2);
    let started = Model::SEARCHED.into_par_iter().filter_map(|model| {
        // A part does not show the drift of the whole, and may slide in one direction.
        let of_part =
            |part: &Log| Some(search_model(model, part, motion::baseline(part).min(baseline).min(1))?.extended(baseline));
        let found: Vec<Searched> = parts.iter().filter_map(of_part).collect();
        let step = found.iter().map(|found| found.velocity_step).fold(f64::INFINITY, f64::min);
        let problem = Problem::new(model, log, baseline, step);
        let best = found.into_iter().map(|found| (problem.mean_square(&found.fitted), found));
        best.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(square, found)| (problem, square, found))
    });
    let started: Vec<(Problem, f64, Searched)> = started.collect();
    let least = started.iter().map(|(_, square, _)| *square).fold(f64::INFINITY, f64::min);
    let finished = started.into_par_iter().filter_map(|(mut problem, square, mut found)| {
        if square > MAX_PART_RISE * least || found.is_bounded() {
            found.force_n = problem.model.response::<false>(&found.fitted, &problem.motion).0;
            found.residuals = problem.less_measured(found.force_n.clone())?;
            return Some(found);
        }
        let steps = (MAX_SAMPLE_STEPS / log.on.len()).max(1);
        let best = problem.minimised(&found.fitted, steps)?;
        // Ends in the same minimum differ by less than their uncertainty.
        let is_other = |rival: &Vec<f64>| {
            (0..rival.len()).any(|at| (rival[at] - found.fitted[at]).powi(2) > MAX_RIVAL_RISE * found.covariance[(at, at)])
        };
        let rivals = found.rivals.into_iter().filter(is_other).collect();
        problem.finished(best, rivals, steps)
    });
    finished.collect()
}

/// Fits a model to a short log.
fn search_model(model: Model, log: &Log, baseline: usize) -> Option<Searched> {
    let mut problem = Problem::new(model, log, baseline, f64::INFINITY);
    let starts = start::followed(model, log, &problem.used, baseline, |fitted| problem.mean_square(fitted));
    let ends = starts.iter().filter_map(|start| problem.minimised(start, usize::MAX));
    let mut ends: Vec<Solution> = ends.filter(|end| end.cost.is_finite()).collect();
    ends.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let residuals = &ends.first()?.linear.residuals;
    let (count, least) = (residuals.len() as f64 / memory(&[residuals]).1, ends[0].cost.max(f64::MIN_POSITIVE));
    let is_near = |end: &&Solution| end.converged && count * libm::log(end.cost / least) < MAX_RIVAL_RISE;
    let rivals = ends[1..].iter().filter(is_near).map(|end| end.parameters.clone()).collect();
    let best = ends.swap_remove(0);
    problem.finished(best, rivals, usize::MAX)
}

/// Fit of a model to a log.
struct Problem<'a> {
    model: Model,
    log: &'a Log,
    parameters: Vec<Parameter>,
    bounds: Vec<(f64, f64)>,
    /// `true` for the samples of the fit.
    used: Vec<bool>,
    motion: Motion,
    /// Largest change of the velocity in a step of the motion, m/s.
    velocity_step: f64,
}

impl<'a> Problem<'a> {
    fn new(model: Model, log: &'a Log, baseline: usize, velocity_step: f64) -> Self {
        let parameters = model.parameters(baseline);
        let bounds = parameters.iter().map(|parameter| bounds(parameter, log.normal_n)).collect();
        // Only a friction that depends on the velocity needs steps of it.
        let velocity_step = if model.falls() { velocity_step.min(VELOCITY_STEP_REL * fastest(log)) } else { f64::INFINITY };
        let motion = Motion::new(log, velocity_step, baseline);
        let mut used: Vec<bool> = log.on.iter().map(|on| !on).collect();
        if !model.has_spring() {
            // Close to a reversal, the force depends on the filter of the instrument and on the
            // resolution of the slip.
            let steady: Vec<bool> = used.iter().zip(motion.is_steady()).map(|(used, steady)| *used && steady).collect();
            let count = |rows: &[bool]| rows.iter().filter(|used| **used).count();
            if 2 * count(&steady) > count(&used) {
                used = steady;
            }
        }
        Problem { model, log, parameters, bounds, used, motion, velocity_step }
    }

    /// Returns the values of the used samples; `None` if one is not finite.
    fn picked(&self, mut values: Vec<f64>) -> Option<Vec<f64>> {
        if self.used.contains(&false) {
            let mut used = self.used.iter();
            values.retain(|_| used.next() == Some(&true));
        }
        values.iter().all(|value| value.is_finite()).then_some(values)
    }

    /// Returns model minus measurement at the used samples, N.
    fn less_measured(&self, mut force: Vec<f64>) -> Option<Vec<f64>> {
        force.iter_mut().zip(&self.log.force_n).for_each(|(error, measured)| *error -= measured);
        self.picked(force)
    }

    fn mean_square(&self, fitted: &[f64]) -> f64 {
        let errors = self.less_measured(self.model.response::<false>(fitted, &self.motion).0);
        errors.map_or(f64::INFINITY, |r| r.iter().map(|r| r * r).sum::<f64>() / r.len().max(1) as f64)
    }

    fn minimised(&self, start: &[f64], steps: usize) -> Option<Solution> {
        minimise_within(steps, &self.bounds, start, |fitted| {
            let (force, columns) = self.model.response::<true>(fitted, &self.motion);
            let columns = columns.into_iter().map(|column| self.picked(column)).collect::<Option<_>>()?;
            Some(Linear { residuals: self.less_measured(force)?, columns })
        })
    }

    /// Returns the place of the stiffness, and its relative deviation by the noise of the
    /// displacement. The stiffness is found in the travel before sliding, `Fc / K`; the start of
    /// this travel has the error of one displacement. The factor was found with noisy and with
    /// rounded displacements; a part of the error is a bias.
    fn stiffness_noise(&self, fitted: &[f64]) -> Option<(usize, f64)> {
        let place = |wanted: &str| self.parameters.iter().position(|(name, is_log)| *name == wanted && *is_log);
        let (stiffness, coulomb) = (place("stiffness_n_per_m")?, place("coulomb_n")?);
        let travel_m = libm::exp(fitted[coulomb] - fitted[stiffness]);
        Some((stiffness, STIFFNESS_PER_NOISE * self.log.noise_m / travel_m))
    }

    /// Refines the motion for the fitted Stribeck velocity, and returns the result.
    fn finished(&mut self, mut best: Solution, rivals: Vec<Vec<f64>>, steps: usize) -> Option<Searched> {
        if let Some(at) = self.parameters.iter().position(|(name, _)| *name == "stribeck_m_per_s") {
            let fine = (STRIBECK_STEP_REL * libm::exp(best.parameters[at])).max(MIN_VELOCITY_STEP_REL * fastest(self.log));
            if fine < MIN_STEP_REDUCTION * self.velocity_step {
                self.velocity_step = fine;
                self.motion = Motion::new(self.log, fine, self.motion.baseline);
                best = self.minimised(&best.parameters, steps)?;
            }
        }
        let (fitted, mut linear) = (best.parameters, best.linear);
        let at_bound: Vec<bool> = fitted.iter().zip(&self.bounds).map(|(p, (least, most))| p <= least || p >= most).collect();
        linear.columns.iter_mut().zip(&at_bound).filter(|(_, at_bound)| **at_bound).for_each(|(column, _)| column.fill(0.0));
        let places: Vec<usize> = (0..self.used.len()).filter(|at| self.used[*at]).collect();
        let mut covariance = covariance(&linear, &places)?;
        if let Some((at, deviation)) = self.stiffness_noise(&fitted) {
            covariance[(at, at)] += deviation * deviation;
        }
        Some(Searched {
            model: self.model,
            parameters: self.parameters.clone(),
            at_bound,
            covariance,
            rivals,
            held_out_n: held_out(&linear)?,
            residuals: linear.residuals,
            force_n: self.model.response::<false>(&fitted, &self.motion).0,
            velocity_step: self.velocity_step,
            fitted,
        })
    }
}

impl Searched {
    /// Adds the parameters of a longer baseline, which are not determined.
    fn extended(mut self, baseline: usize) -> Self {
        self.parameters = self.model.parameters(baseline);
        let (known, count) = (self.fitted.len(), self.parameters.len());
        self.rivals.iter_mut().chain([&mut self.fitted]).for_each(|fitted| fitted.resize(count, 0.0));
        self.at_bound.resize(count, false);
        self.covariance = self.covariance.resize(count, count, 0.0);
        (known..count).for_each(|at| self.covariance[(at, at)] = f64::INFINITY);
        self
    }

    /// Returns `true` if a parameter is at its bound, except for a viscous friction of zero.
    pub(super) fn is_bounded(&self) -> bool {
        self.parameters.iter().zip(&self.at_bound).any(|((name, _), at_bound)| *at_bound && *name != "sigma2")
    }
}

/// Returns the highest velocity of a log, m/s.
fn fastest(log: &Log) -> f64 {
    log.velocity_m_per_s.iter().fold(f64::MIN_POSITIVE, |most, v| most.max(v.abs()))
}

/// Returns the root mean square error at segments of the log that the fit has not seen. The fit to
/// the others follows from the derivatives, in one step:
///
/// ```text
/// r + X d,   d = (A - A')^-1 X'r   (A', X and r of the segments)
/// ```
fn held_out(linear: &Linear) -> Option<f64> {
    let n = linear.residuals.len();
    let (all, _, scales) = linear.normal();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut sum = 0.0;
    for group in 0..HELD_OUT_GROUPS {
        let segments = (group..HELD_OUT_SEGMENTS).step_by(HELD_OUT_GROUPS);
        let segments: Vec<_> = segments.map(|at| n * at / HELD_OUT_SEGMENTS..n * (at + 1) / HELD_OUT_SEGMENTS).collect();
        let product = |a: &[f64], b: &[f64]| segments.iter().map(|rows| dot(&a[rows.clone()], &b[rows.clone()])).sum::<f64>();
        let (columns, ridge) = (&linear.columns, |i: usize, j: usize| if i == j { HELD_OUT_RIDGE } else { 0.0 });
        let seen = |i: usize, j: usize| all[(i, j)] - scales[i] * scales[j] * product(&columns[i], &columns[j]) + ridge(i, j);
        let right = DVector::from_fn(scales.len(), |i, _| scales[i] * product(&columns[i], &linear.residuals));
        let step = Cholesky::new(DMatrix::from_fn(scales.len(), scales.len(), seen))?.solve(&right);
        for rows in segments {
            let mut errors = linear.residuals[rows.clone()].to_vec();
            for ((column, scale), step) in columns.iter().zip(&scales).zip(step.iter()) {
                errors.iter_mut().zip(&column[rows.clone()]).for_each(|(error, slope)| *error += slope * scale * step);
            }
            sum += dot(&errors, &errors);
        }
    }
    Some((sum / n as f64).sqrt())
}

/// Returns Bayes's information criterion of residuals of this root mean square, of `count`
/// independent samples.
pub(super) fn criterion(rms: f64, parameters: usize, count: f64) -> f64 {
    count * libm::log((rms * rms).max(f64::MIN_POSITIVE)) + parameters as f64 * libm::log(count.max(2.0))
}
