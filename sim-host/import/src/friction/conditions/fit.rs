//! Weighted least squares of all measurements, for each stiffness of a grid, and the scatter.
//!
//! ```text
//! var = sd^2 + (tau mu_fit)^2,   sum over a group e^2 / var = sum over the group (1 - h)
//! ```
//!
//! `sd` is the noise within a measurement, `tau` the relative scatter between measurements (a
//! random effect), and `h` the leverage. ON and OFF have their own scatter if both have enough
//! measurements to determine it (R. C. Paule, J. Mandel, J. Res. NBS 87 (1982) 377, here with
//! leverages).
//!
//! The other parameters are fitted for each stiffness between the soft and the rigid limit. The sum
//! of squares over the stiffness can have a narrow valley next to a long flat part: in both, the
//! grid is refined until it resolves the stiffnesses that the data admit ([`super::interval`]).
//! Data that do not determine the stiffness thus widen the intervals of all that depends on it.

use nalgebra::{Cholesky, DMatrix};

use super::interval::{MAX_FREEDOM, student};
use super::measurement::Measurement;
use super::model::{Model, Parameters, Point};
use crate::error::ImportError;
use crate::friction::fit::criterion;
use crate::least_squares::{Linear, Solution, minimise_within};

/// Range of kappa at the typical measurement. At its ends, the ratio is that of a soft and of a
/// rigid contact within 0.001.
const KAPPA: (f64, f64) = (0.02, 1000.0);
/// Number of stiffnesses of the first grid.
const GRID: usize = 31;
/// Maximum number of refinements of the grid.
const MAX_REFINEMENTS: usize = 12;
/// Maximum number of stiffnesses of the refined grid.
const MAX_SLICES: usize = 150;
/// Difference of the sums of squares of neighbouring stiffnesses that needs no refinement, relative
/// to the largest rise.
const RESOLVED_REL: f64 = 0.25;
/// Maximum number of steps of a fit.
const MAX_STEPS: usize = 60;
/// Number of refinements of the scatter.
const SCATTER_STEPS: usize = 6;
/// Smallest relative scatter of a weight.
const MIN_SCATTER_REL: f64 = 1e-4;
/// Smallest number of degrees of freedom for a scatter.
pub(super) const MIN_FREEDOM: f64 = 1.5;
/// Decrease of the information criterion that demands a trend over the speed.
const MIN_TREND_DECREASE: f64 = 6.0;
/// Bounds of the tip velocity, relative to the slowest and the fastest measurement.
const TIP_REL: (f64, f64) = (0.1, 1e4);
/// Number of tip velocities from which a fit starts.
const STARTS: usize = 16;

/// Fit for one stiffness.
pub(super) struct Slice {
    pub(super) ln_compliance: f64,
    pub(super) fitted: Vec<f64>,
    /// Normal matrix of each group of measurements.
    pub(super) matrices: [DMatrix<f64>; 2],
    /// Weighted sum of squares above the least one, with that of a known stiffness.
    pub(super) rise: f64,
    /// Weighted sum of squares.
    cost: f64,
}

/// Knowledge of the stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stiffness {
    /// The data determine it.
    Identified,
    /// The data exclude a rigid contact, but not a very soft one.
    Soft,
    /// The data are compatible with a rigid contact.
    Rigid,
}

/// Result of the fit.
pub(super) struct Fit {
    pub(super) model: Model,
    /// Fits in the order of their stiffness.
    pub(super) slices: Vec<Slice>,
    /// Index of the slice with the least sum of squares.
    pub(super) best: usize,
    /// Index of the slice whose parameters are the result.
    pub(super) chosen: usize,
    /// Rise of the sum of squares that excludes a stiffness.
    pub(super) max_rise: f64,
    pub(super) stiffness: Stiffness,
    /// Relative scatter of OFF and ON measurements.
    pub(super) scatter: [f64; 2],
    /// Degrees of freedom of the scatter of OFF and ON; infinite if it is unknown.
    pub(super) freedom: [f64; 2],
    /// Variance of each measurement.
    pub(super) variances: Vec<f64>,
}

/// Fits the model to measurements with at least one of each state.
pub(super) fn fit(measurements: &[Measurement], fits_tip: bool, known: Option<(f64, f64)>) -> Result<Fit, ImportError> {
    let points: Vec<Point> = measurements.iter().map(Point::new).collect();
    let off = || measurements.iter().filter(|m| !m.on);
    let range = |speeds: &mut dyn Iterator<Item = f64>| speeds.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)));
    let mut model = Model { fits_tip, has_trend: false, off_speeds: range(&mut off().map(|m| m.speed_m_per_s)) };
    model.has_trend = demands_trend(&off().map(|m| (libm::log(m.speed_m_per_s), m.mu)).collect::<Vec<_>>());
    let speeds = range(&mut points.iter().map(|point| point.speed_m_per_s));
    let drives = range(&mut points.iter().filter_map(|point| point.drive));
    let problem =
        Problem { measurements, points, model, tip: (TIP_REL.0 * speeds.0 / drives.1, TIP_REL.1 * speeds.1 / drives.0) };
    problem.solved(known)
}

/// Returns `true` if OFF data demand a coefficient of friction that depends on the speed, by the
/// information criterion.
fn demands_trend(off: &[(f64, f64)]) -> bool {
    let count = off.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| off.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let sxx: f64 = off.iter().map(|p| (p.0 - x).powi(2)).sum();
    if off.len() < 4 || sxx < 1e-3 {
        return false;
    }
    let slope = off.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / sxx;
    let rms = |slope: f64| mean(&|p| (p.1 - y - slope * (p.0 - x)).powi(2)).sqrt();
    criterion(rms(0.0), 1, count) - criterion(rms(slope), 2, count) > MIN_TREND_DECREASE
}

/// Returns the least sum of squares.
fn least(slices: &[Slice]) -> f64 {
    slices.iter().map(|slice| slice.cost).fold(f64::INFINITY, f64::min)
}

/// Returns the indices of slices whose sum of squares is not above that of a neighbour.
fn valleys(slices: &[Slice]) -> Vec<usize> {
    let cost = |at: Option<usize>| at.and_then(|at| slices.get(at)).map_or(f64::INFINITY, |slice| slice.cost);
    (0..slices.len()).filter(|at| slices[*at].cost <= cost(at.checked_sub(1)).min(cost(Some(at + 1)))).collect()
}

/// Scatter about a fit.
#[derive(Default)]
struct Scattered {
    /// Relative scatter of OFF and ON.
    scatter: [f64; 2],
    /// Degrees of freedom of the scatter of OFF and ON.
    freedom: [f64; 2],
    /// Variance of each measurement.
    variances: Vec<f64>,
    /// Twice the negative logarithm of the likelihood.
    deviance: f64,
}

struct Problem<'a> {
    measurements: &'a [Measurement],
    points: Vec<Point>,
    model: Model,
    /// Bounds of the tip velocity per strength of the vibration.
    tip: (f64, f64),
}

impl Problem<'_> {
    fn solved(self, known: Option<(f64, f64)>) -> Result<Fit, ImportError> {
        let none = || ImportError::NoFit("no friction under vibration leads to these measurements".into());
        let variances: Vec<f64> = self.measurements.iter().map(|m| m.sd * m.sd + (0.05 * m.mu).powi(2)).collect();
        let from = self.minimised(libm::log(KAPPA.1), &variances, None).ok_or_else(none)?;
        // The stiffness at which kappa is one at the typical measurement.
        let one = self.model.parameters(&from.parameters, 0.0);
        let on: Vec<f64> = self.points.iter().filter_map(|p| Some(libm::log(p.drive? / p.normal_n))).collect();
        let unit = one.ln_mu - one.ln_tip - on.iter().sum::<f64>() / on.len() as f64;
        let ends = (unit + libm::log(KAPPA.0), unit + libm::log(KAPPA.1));
        // The scatter about the wrong valley contains its misfit.
        let coarse = self.grid(ends, &variances);
        let start = |at: usize| [&coarse[at].fitted[..], &[coarse[at].ln_compliance]].concat();
        let found = valleys(&coarse).into_iter().filter_map(|at| self.scattered(start(at), ends, &variances));
        let likely = found.min_by(|a, b| a.deviance.total_cmp(&b.deviance));
        let Scattered { scatter, freedom, variances, .. } = likely.ok_or_else(none)?;
        let max_rise = student(freedom[1]).powi(2);
        let mut slices = self.grid(ends, &variances);
        self.refine(&mut slices, max_rise, &variances);
        let data_least = least(&slices);
        let [soft, rigid] = [slices.first(), slices.last()].map(|slice| slice.map_or(f64::INFINITY, |slice| slice.cost));
        let stiffness = match (soft - data_least > max_rise, rigid - data_least > max_rise) {
            (_, false) => Stiffness::Rigid,
            (true, true) => Stiffness::Identified,
            (false, true) => Stiffness::Soft,
        };
        let with_known = |slice: &Slice| slice.cost + known.map_or(0.0, |(ln, sd)| ((slice.ln_compliance - ln) / sd).powi(2));
        let costs: Vec<f64> = slices.iter().map(with_known).collect();
        let best = (0..costs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).ok_or_else(none)?;
        slices.iter_mut().zip(&costs).for_each(|(slice, cost)| slice.rise = cost - costs[best]);
        let chosen = if stiffness == Stiffness::Rigid && known.is_none() { slices.len() - 1 } else { best };
        Ok(Fit { model: self.model, slices, best, chosen, max_rise, stiffness, scatter, freedom, variances })
    }

    /// Fits all parameters from a start, and the scatter about this fit.
    fn scattered(&self, start: Vec<f64>, ends: (f64, f64), variances: &[f64]) -> Option<Scattered> {
        let mut all = start;
        let mut found = Scattered { variances: variances.to_vec(), ..Scattered::default() };
        for _ in 0..SCATTER_STEPS {
            all = self.minimised_within(&all, ends, &found.variances)?.parameters;
            (found.scatter, found.freedom) = self.scatter(&all, ends, &found.variances);
            let of = self.model.parameters(&all, all[self.model.count()]);
            let variance = |(m, p): (&Measurement, &Point)| {
                let scatter = found.scatter[usize::from(m.on)].max(MIN_SCATTER_REL);
                m.sd * m.sd + (scatter * self.model.mu(&of, p)).powi(2)
            };
            found.variances = self.measurements.iter().zip(&self.points).map(variance).collect();
            let squares = self.residuals(&of, &found.variances).into_iter().map(|r| r * r);
            found.deviance = squares.zip(&found.variances).map(|(square, variance)| square + libm::log(*variance)).sum();
        }
        Some(found)
    }

    /// Fits the other parameters for each stiffness of a grid.
    fn grid(&self, (from, to): (f64, f64), variances: &[f64]) -> Vec<Slice> {
        let mut slices: Vec<Slice> = Vec::new();
        for n in 0..GRID {
            let ln_compliance = from + (to - from) * n as f64 / (GRID - 1) as f64;
            let last = slices.last().map(|slice| slice.fitted.clone());
            slices.extend(self.slice(ln_compliance, variances, last));
        }
        slices
    }

    /// Fits the other parameters for one stiffness.
    fn slice(&self, ln_compliance: f64, variances: &[f64], start: Option<Vec<f64>>) -> Option<Slice> {
        let found = self.minimised(ln_compliance, variances, start)?;
        let mut matrices = [false, true].map(|on| self.matrix(&found.linear, on));
        if self.model.fits_tip {
            // Without a reduction of friction, only the bounds limit the tip velocity.
            let last = self.model.count() - 1;
            matrices[1][(last, last)] += 12.0 / libm::log(self.tip.1 / self.tip.0).powi(2);
        }
        Some(Slice { ln_compliance, fitted: found.parameters, matrices, rise: 0.0, cost: found.cost })
    }

    /// Adds the minimum of each valley between stiffnesses of a grid, and then stiffnesses until
    /// neighbours that the data admit differ little.
    fn refine(&self, slices: &mut Vec<Slice>, max_rise: f64, variances: &[f64]) {
        let add = |slices: &mut Vec<Slice>, added: Vec<Slice>| {
            slices.extend(added);
            slices.sort_by(|a, b| a.ln_compliance.total_cmp(&b.ln_compliance));
        };
        let bottom = |near: &[Slice]| {
            let start = [&near[1].fitted[..], &[near[1].ln_compliance]].concat();
            let all = self.minimised_within(&start, (near[0].ln_compliance, near[2].ln_compliance), variances)?.parameters;
            self.slice(all[self.model.count()], variances, Some(near[1].fitted.clone()))
        };
        let inner = valleys(slices).into_iter().filter(|at| (1..slices.len().saturating_sub(1)).contains(at));
        let bottoms = inner.filter_map(|at| bottom(&slices[at - 1..=at + 1])).collect();
        add(slices, bottoms);
        for _ in 0..MAX_REFINEMENTS {
            let limit = least(slices) + max_rise;
            let is_coarse = |pair: &&[Slice]| {
                pair[0].cost.min(pair[1].cost) < limit && (pair[0].cost - pair[1].cost).abs() > RESOLVED_REL * max_rise
            };
            let middle = |pair: &[Slice]| {
                let start = if pair[0].cost < pair[1].cost { &pair[0] } else { &pair[1] };
                let ln_compliance = 0.5 * (pair[0].ln_compliance + pair[1].ln_compliance);
                self.slice(ln_compliance, variances, Some(start.fitted.clone()))
            };
            let middles: Vec<Slice> = slices.windows(2).filter(is_coarse).filter_map(middle).collect();
            if middles.is_empty() || slices.len() + middles.len() > MAX_SLICES {
                break;
            }
            add(slices, middles);
        }
    }

    /// Returns the normal matrix of the measurements of a state.
    fn matrix(&self, linear: &Linear, on: bool) -> DMatrix<f64> {
        let p = linear.columns.len();
        let rows = || (0..self.measurements.len()).filter(|at| self.measurements[*at].on == on);
        DMatrix::from_fn(p, p, |i, j| rows().map(|at| linear.columns[i][at] * linear.columns[j][at]).sum())
    }

    /// Returns the weighted residuals of parameters.
    fn residuals(&self, of: &Parameters, variances: &[f64]) -> Vec<f64> {
        let one = |((m, p), variance): ((&Measurement, &Point), &f64)| (self.model.mu(of, p) - m.mu) / variance.sqrt();
        self.measurements.iter().zip(&self.points).zip(variances).map(one).collect()
    }

    /// Returns the weighted residuals and their derivatives. The stiffness may be the last of the
    /// fitted parameters.
    fn linear(&self, fitted: &[f64], ln_compliance: f64, variances: &[f64]) -> Option<Linear> {
        const STEP: f64 = 1e-6;
        let at = |fitted: &[f64]| {
            let ln_compliance = fitted.get(self.model.count()).copied().unwrap_or(ln_compliance);
            self.residuals(&self.model.parameters(fitted, ln_compliance), variances)
        };
        let residuals = at(fitted);
        let column = |n: usize| {
            let moved: Vec<f64> = fitted.iter().enumerate().map(|(m, p)| p + if m == n { STEP } else { 0.0 }).collect();
            at(&moved).iter().zip(&residuals).map(|(after, before)| (after - before) / STEP).collect()
        };
        let columns: Vec<Vec<f64>> = (0..fitted.len()).map(column).collect();
        residuals.iter().all(|r| r.is_finite()).then_some(Linear { residuals, columns })
    }

    fn minimised(&self, ln_compliance: f64, variances: &[f64], start: Option<Vec<f64>>) -> Option<Solution> {
        let off: Vec<f64> = self.measurements.iter().filter(|m| !m.on).map(|m| m.mu).collect();
        let mu = libm::log((off.iter().sum::<f64>() / off.len() as f64).max(f64::MIN_POSITIVE));
        let (low, high) = (libm::log(self.tip.0), libm::log(self.tip.1));
        let of_tip = |n: usize| {
            let mut fitted = vec![0.0; self.model.count()];
            fitted[0] = mu;
            if self.model.fits_tip {
                fitted[self.model.count() - 1] = low + (high - low) * n as f64 / (STARTS - 1) as f64;
            }
            fitted
        };
        let cost = |fitted: &Vec<f64>| {
            let residuals = self.residuals(&self.model.parameters(fitted, ln_compliance), variances);
            residuals.iter().map(|r| r * r).sum::<f64>()
        };
        // No vibration lowers friction far from the best tip velocity: there are no slopes.
        let start = start.or_else(|| (0..STARTS).map(of_tip).min_by(|a, b| cost(a).total_cmp(&cost(b))))?;
        self.minimised_within(&[&start[..], &[ln_compliance]].concat(), (ln_compliance, ln_compliance), variances)
    }

    /// Fits all parameters, with the stiffness within bounds.
    fn minimised_within(&self, start: &[f64], stiffness: (f64, f64), variances: &[f64]) -> Option<Solution> {
        let p = self.model.count();
        let mut bounds = vec![(f64::NEG_INFINITY, f64::INFINITY); p];
        if self.model.fits_tip {
            bounds[p - 1] = (libm::log(self.tip.0), libm::log(self.tip.1));
        }
        // A fixed stiffness is not a parameter.
        if stiffness.0 == stiffness.1 {
            return minimise_within(MAX_STEPS, &bounds, &start[..p], |fitted| self.linear(fitted, stiffness.0, variances));
        }
        bounds.push(stiffness);
        minimise_within(MAX_STEPS, &bounds, start, |all| self.linear(all, all[p], variances))
    }

    /// Returns the relative scatter of OFF and ON, and its degrees of freedom.
    fn scatter(&self, all: &[f64], ends: (f64, f64), variances: &[f64]) -> ([f64; 2], [f64; 2]) {
        const UNKNOWN: ([f64; 2], [f64; 2]) = ([0.0; 2], [f64::INFINITY; 2]);
        let p = self.model.count() + 1;
        let of = self.model.parameters(all, all[p - 1]);
        let Some(linear) = self.linear(all, all[p - 1], variances) else { return UNKNOWN };
        // The stiffness is a parameter with a prior.
        let mut matrix = self.matrix(&linear, false) + self.matrix(&linear, true);
        matrix[(p - 1, p - 1)] += 12.0 / (ends.1 - ends.0).powi(2);
        let Some(inverse) = Cholesky::new(matrix).map(|factor| factor.inverse()) else { return UNKNOWN };
        let leverage = |at: usize| -> f64 {
            let x = |i: usize| linear.columns[i][at];
            (0..p).flat_map(|i| (0..p).map(move |j| (i, j))).map(|(i, j)| x(i) * inverse[(i, j)] * x(j)).sum()
        };
        let fitted: Vec<f64> = self.points.iter().map(|point| self.model.mu(&of, point)).collect();
        let solve = |rows: &[usize]| -> (f64, f64) {
            let free: f64 = rows.iter().map(|at| 1.0 - leverage(*at)).sum();
            let sum = |scatter: f64| -> f64 {
                let one = |at: &usize| {
                    let (m, fit) = (&self.measurements[*at], fitted[*at]);
                    (fit - m.mu).powi(2) / (m.sd * m.sd + (scatter.max(MIN_SCATTER_REL) * fit).powi(2))
                };
                rows.iter().map(one).sum()
            };
            let (mut low, mut high) = (0.0, 10.0);
            if free < MIN_FREEDOM {
                return (0.0, free);
            }
            // Noise alone explains the residuals. Smaller residuals can hide less scatter.
            if sum(low) <= free {
                return (0.0, (free * (free / sum(low)).powi(2)).min(MAX_FREEDOM));
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if sum(middle) > free { low = middle } else { high = middle }
            }
            (high, free)
        };
        let rows = |on: bool| (0..fitted.len()).filter(|at| self.measurements[*at].on == on).collect::<Vec<_>>();
        let (off, on) = (solve(&rows(false)), solve(&rows(true)));
        if off.1 >= MIN_FREEDOM && on.1 >= MIN_FREEDOM {
            return ([off.0, on.0], [off.1, on.1]);
        }
        match solve(&(0..fitted.len()).collect::<Vec<_>>()) {
            (_, free) if free < MIN_FREEDOM => UNKNOWN,
            (scatter, free) => ([scatter; 2], [free; 2]),
        }
    }
}
