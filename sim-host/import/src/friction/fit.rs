//! Fits of the contact models to the OFF part of a log, and the choice between them.
//!
//! A model is started from several stiffnesses and Stribeck velocities across what the log resolves, and the best end counts. The choice is Bayes's
//! information criterion, `n ln(sum of squares) + p ln n`, where `n` is the number of samples over the memory of the best model's residuals: samples of a slow
//! drift say the same again and again.

use nalgebra::DMatrix;

use super::log::Log;
use super::models::Model;
use crate::least_squares::{Linear, Solution, minimise};

/// A fitted model with its residuals.
pub(crate) struct Searched {
    /// The model.
    pub(super) model: Model,
    /// Parameters of the fit.
    pub(super) fitted: Vec<f64>,
    /// Standard deviations of these; nothing of those that the log does not determine.
    pub(super) deviations: Vec<Option<f64>>,
    /// Correlations of those that are determined, in the order of all.
    pub(super) correlations: Vec<Vec<f64>>,
    /// Residuals of the used samples, N.
    pub(super) residuals: Vec<f64>,
}

/// Starts that are followed to their end in any case, the best first.
const STARTS: usize = 3;
/// Stribeck velocities that are tried, as parts of the highest velocity.
const STRIBECK: [f64; 6] = [0.03, 0.06, 0.12, 0.25, 0.5, 0.9];
/// Relative standard deviation from which a parameter counts as not determined.
const UNDETERMINED: f64 = 0.5;

/// Fits a model; nothing if no start leads anywhere.
pub(super) fn search(model: Model, log: &Log, used: &[bool]) -> Option<Searched> {
    let evaluate = |fitted: &[f64]| residuals(model, fitted, log, used);
    let linear = |fitted: &[f64]| {
        let residuals = evaluate(fitted)?;
        Some(Linear { residuals, columns: slopes(model, fitted, evaluate)? })
    };
    let cost = |fitted: &Vec<f64>| evaluate(fitted).map_or(f64::INFINITY, |r| r.iter().map(|r| r * r).sum::<f64>());
    let mut starts = starts(model, log, used);
    starts.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let ends = followed(model, &starts).into_iter().filter_map(|start| minimise(start, linear));
    let best = ends.filter(|end| end.cost.is_finite()).min_by(|a, b| a.cost.total_cmp(&b.cost))?;
    let (deviations, correlations) = certainty(&best, model);
    Some(Searched { model, fitted: best.parameters, deviations, correlations, residuals: best.linear.residuals })
}

/// How each parameter of a model changes something, by differences.
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

/// Residuals and derivatives less a part of those of the sample before, which has the same variance.
pub(crate) fn white(linear: &Linear, rho: f64) -> Linear {
    let scale = 1.0 / (1.0 - rho * rho).sqrt();
    let of = |values: &Vec<f64>| {
        (0..values.len()).map(|at| if at == 0 { values[0] } else { (values[at] - rho * values[at - 1]) * scale }).collect()
    };
    Linear { residuals: of(&linear.residuals), columns: linear.columns.iter().map(of).collect() }
}

/// Model less measurement at the used samples, N.
fn residuals(model: Model, fitted: &[f64], log: &Log, used: &[bool]) -> Option<Vec<f64>> {
    let force = model.force(fitted, log);
    let error = force.iter().zip(&log.force_n).zip(used).filter(|(_, used)| **used).map(|((f, measured), _)| f - measured);
    let errors: Vec<f64> = error.collect();
    errors.iter().all(|error| error.is_finite()).then_some(errors)
}

/// The best starts, and the best of each Stribeck velocity: each has a valley of its own, and the deepest need not begin as such.
fn followed(model: Model, starts: &[Vec<f64>]) -> Vec<&Vec<f64>> {
    let velocity = model.parameters().iter().position(|(name, _)| *name == "stribeck_m_per_s");
    let is_new = |at: usize| velocity.is_some_and(|v| starts[..at].iter().all(|earlier| earlier[v] != starts[at][v]));
    starts.iter().enumerate().filter(|(at, _)| *at < STARTS || is_new(*at)).map(|(_, start)| start).collect()
}

/// Starts across what the log resolves.
fn starts(model: Model, log: &Log, used: &[bool]) -> Vec<Vec<f64>> {
    let of_used = |values: &[f64]| {
        let mut sizes: Vec<f64> =
            values.iter().zip(used).filter(|(_, used)| **used).map(|(v, _)| v.abs()).filter(|v| *v > 0.0).collect();
        sizes.sort_by(f64::total_cmp);
        sizes
    };
    let at = |sorted: &[f64], part: f64| sorted.get((part * sorted.len() as f64) as usize).copied().unwrap_or(1.0);
    let (force, speed, slip) = (of_used(&log.force_n), of_used(&log.velocity_m_per_s), of_used(&log.slip_m));
    let fc = at(&force, 0.5);
    let range: f64 = slip.iter().sum();
    let (finest, coarsest) = (at(&slip, 0.0), 0.1 * range);
    let stiffness = (0..12).map(|n| fc / (finest * libm::pow((coarsest / finest).max(2.0), f64::from(n) / 11.0)));
    let stiffness: Vec<f64> = if matches!(model, Model::Dahl | Model::Lugre) { stiffness.collect() } else { vec![1.0] };
    let fastest = speed.last().copied().unwrap_or(1.0);
    let falls = matches!(model, Model::Stribeck | Model::Lugre);
    let stribeck: Vec<[f64; 4]> = if falls {
        STRIBECK.map(|part| steady(log, used, part * fastest, fc, fastest)).into()
    } else {
        vec![[fc, 0.0, fastest, 0.0]]
    };
    let first = log.force_n.first().copied().unwrap_or(0.0);
    let one = |kt: f64, [coulomb, excess, vs, viscous]: [f64; 4]| -> Vec<f64> {
        let value = |name: &str| match name {
            "coulomb_n" => coulomb,
            "static_excess_n" => excess,
            "stribeck_m_per_s" => vs,
            "sigma2" => viscous,
            "stiffness_n_per_m" => kt,
            _ => first,
        };
        model.parameters().iter().map(|(name, log)| if *log { libm::log(value(name)) } else { value(name) }).collect()
    };
    stiffness.iter().flat_map(|kt| stribeck.iter().map(|values| one(*kt, *values)).collect::<Vec<_>>()).collect()
}

/// Coulomb force, static excess, Stribeck velocity and viscous friction of a given Stribeck velocity: without springs the rest is linear,
/// `F sgn V = Fc + dF exp(-(V / Vs)^2) + s2 |V|`. What comes out too small to be a logarithm is a small part of the friction.
fn steady(log: &Log, used: &[bool], vs: f64, fc: f64, fastest: f64) -> [f64; 4] {
    let samples = log.force_n.iter().zip(&log.velocity_m_per_s).zip(used);
    let (mut matrix, mut right) = (nalgebra::Matrix3::zeros(), nalgebra::Vector3::zeros());
    for ((force, v), _) in samples.filter(|((_, v), used)| **used && **v != 0.0) {
        // In parts of the highest velocity, so that the columns are of one size.
        let row = nalgebra::Vector3::new(1.0, libm::exp(-(v / vs) * (v / vs)), v.abs() / fastest);
        matrix += row * row.transpose();
        right += row * (force * v.signum());
    }
    let found = matrix.lu().solve(&right).unwrap_or_else(|| nalgebra::Vector3::new(fc, 0.2 * fc, 0.01 * fc));
    let least = |value: f64, least: f64| if value.is_finite() { value.max(least * fc) } else { least * fc };
    [least(found[0], 0.05), least(found[1], 0.02), vs, least(found[2], 1e-3) / fastest]
}

/// Standard deviations and correlations of what the log determines. What makes the matrix singular is left out, the weakest first.
fn certainty(solution: &Solution, model: Model) -> (Vec<Option<f64>>, Vec<Vec<f64>>) {
    let n = solution.parameters.len();
    let length = |at: usize| solution.linear.columns[at].iter().map(|c| c * c).sum::<f64>();
    let free = solution.linear.residuals.len().saturating_sub(n).max(1) as f64;
    let variance = solution.cost / free * memory(&solution.linear.residuals);
    let mut kept: Vec<usize> = (0..n).collect();
    let mut deviations = vec![None; n];
    let mut correlations = vec![vec![0.0; n]; n];
    while !kept.is_empty() {
        let columns = kept.iter().map(|at| solution.linear.columns[*at].clone()).collect();
        let linear = Linear { residuals: solution.linear.residuals.clone(), columns };
        let parameters = kept.iter().map(|at| solution.parameters[*at]).collect();
        let part = Solution { parameters, linear, cost: solution.cost, converged: true };
        let covariance: Option<DMatrix<f64>> = part.covariance();
        let sd = |covariance: &DMatrix<f64>, i: usize| (variance * covariance[(i, i)]).sqrt();
        let is_weak = |i: usize, covariance: &DMatrix<f64>| match model.parameters()[kept[i]] {
            ("sigma2", _) => sd(covariance, i) > UNDETERMINED * solution.parameters[kept[i]].abs(),
            (_, by_log) => by_log && sd(covariance, i) > UNDETERMINED,
        };
        let relative = |covariance: &DMatrix<f64>, i: usize| match model.parameters()[kept[i]] {
            (_, true) => sd(covariance, i),
            (_, false) => sd(covariance, i) / solution.parameters[kept[i]].abs(),
        };
        let weakest = match &covariance {
            Some(covariance) => (0..kept.len())
                .filter(|i| is_weak(*i, covariance))
                .max_by(|a, b| relative(covariance, *a).total_cmp(&relative(covariance, *b))),
            None => (0..kept.len()).min_by(|a, b| length(kept[*a]).total_cmp(&length(kept[*b]))),
        };
        match (weakest, covariance) {
            (Some(weakest), _) => drop(kept.remove(weakest)),
            (None, Some(covariance)) => {
                for (i, one) in kept.iter().enumerate() {
                    deviations[*one] = Some(sd(&covariance, i));
                    for (j, other) in kept.iter().enumerate() {
                        correlations[*one][*other] = covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt();
                    }
                }
                break;
            }
            (None, None) => break,
        }
    }
    (deviations, correlations)
}

/// Factor of the variance that comes of the correlation of residuals.
pub(super) fn memory(residuals: &[f64]) -> f64 {
    let n = residuals.len();
    let square: f64 = residuals.iter().map(|r| r * r).sum();
    let chance = 2.0 / (n as f64).sqrt();
    let mut factor = 1.0;
    for lag in 1..n / 4 {
        let rho = residuals.iter().zip(&residuals[lag..]).map(|(a, b)| a * b).sum::<f64>() / square.max(f64::MIN_POSITIVE);
        if rho < chance {
            break;
        }
        factor += 2.0 * rho;
    }
    factor
}

/// Bayes's information criterion of residuals, for so many independent samples.
pub(super) fn criterion(residuals: &[f64], parameters: usize, memory: f64) -> f64 {
    let n = residuals.len() as f64 / memory;
    let mean = residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len().max(1) as f64;
    n * libm::log(mean.max(f64::MIN_POSITIVE)) + parameters as f64 * libm::log(n.max(2.0))
}
