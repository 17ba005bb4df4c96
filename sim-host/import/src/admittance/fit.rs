//! Weighted least-squares fit in the coordinates of the instrument, with the number of resonances
//! that the data show.
//!
//! ```text
//! start (next resonance) -> least squares -> weights from residuals -> least squares -> significant? -> next resonance ...
//!                                                                                          |
//!                                             memory of the residuals -> least squares -> covariance
//! ```
//!
//! **Number of resonances.** One more is accepted if it lowers `n ln(sum of squares)` by more than
//! Bayes's information criterion requires for its three parameters, `3 ln n`, and
//! [`CRITERION_MARGIN`] beyond that; `n` is the number of real values divided by their memory.
//! **Memory.** Residuals of neighbouring points may be correlated: because the instrument averages
//! over time, because of a drift, or because the circuit does not fit. They are whitened by their
//! correlation, `e(t) - rho e(t - 1)`, and the remaining correlation multiplies the covariance by
//! `1 + 2 sum rho(k)`.
//!
//! **Long sweeps.** The fit is to means over bins of rows (see [`bins`]). The circuit at the mean
//! frequency of a bin is not its mean over the rows. The last fits therefore replace the mean `y`
//! of a bin by
//!
//! ```text
//! y' = f(mean frequency) - mean over rows (f - y),   f: circuit of the preceding fit
//! ```
//!
//! so that their errors vanish with the mean error of the rows. The statistics are those of all
//! rows, and the whole correlation multiplies the covariance, because neighbouring bins of unequal
//! lengths cannot be whitened.

use std::ops::Range;

use num_complex::Complex64;

use super::circuit::{BRANCH_PARAMETERS, Branch, CLAMPED_PARAMETERS, Equivalent, admittance};
use super::measured::Measured;
use super::memory::{complex, memory, roughness, whitened};
use super::passivity;
use super::start::{self, Points};
use super::weights::Weights;
use crate::error::ImportError;
use crate::least_squares::{Linear, Solution, minimise_within};
use crate::rows::{MAX_POINTS, bins, means};
use report::rounded;
use report::statistics::{ascending, quantile};

/// Maximum number of resonances of a circuit.
pub const MOST_MODES: usize = 8;
/// Minimum number of points beyond the number of parameters.
const SPARE_POINTS: usize = 4;
/// Maximum number of resonances that are added together, because one alone is not significant.
const MOST_TOGETHER: usize = 2;
/// Maximum number of the first resonances that are added together.
const MOST_FIRST: usize = 3;
/// Gain that a further resonance needs beyond Bayes's criterion.
const CRITERION_MARGIN: f64 = 12.0;
/// Variance of the residuals, relative to that of their third differences, above which they contain
/// further resonances; noise with a correlation of 0.9 has 16.
const MAX_ROUGHNESS: f64 = 25.0;
/// Mean square of the residuals, relative to the smallest noise, below which they are the rounding
/// errors of computed data.
const EXACT: f64 = 1e-6;
/// Smallest quality factor. Outside the range a sweep does not show a branch, and a fit that lacks
/// a resonance would go there.
const MIN_Q: f64 = 0.5;
/// Largest quality factor.
const MAX_Q: f64 = 1e5;
/// Largest distance of a resonance outside the sweep during the fit, as the logarithm of a ratio.
const MAX_OUTSIDE_LN: f64 = 0.1;
/// Number of steps after which the starts of a stage are compared.
const START_STEPS: usize = 25;
/// Number of rounds of weights and least squares.
const WEIGHT_ROUNDS: usize = 3;
/// Number of fits that compare the circuit with all rows of a long sweep.
const ROW_ROUNDS: usize = 2;
/// Largest correlation of neighbours that is whitened.
const MAX_CORRELATION: f64 = 0.97;
/// Largest standard deviation of the logarithm of conductance or quality factor for a resonance to
/// count as found.
const MAX_LN_SD: f64 = 0.35;

/// Fitted circuit with its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fit {
    /// Parameters of the fit.
    pub(super) parameters: Vec<f64>,
    /// Covariance of the parameters.
    pub(super) covariance: nalgebra::DMatrix<f64>,
    /// Unit of the capacitances among the parameters, F.
    pub(super) farad: f64,
    /// Residuals in units of the noise.
    pub(super) residuals: Vec<Complex64>,
    /// Rms standard deviation of the residuals: of the relative magnitude and the angle, or of the
    /// real and imaginary part of the scattering parameter.
    pub(super) noise: [f64; 2],
    /// Correlation of neighbouring residuals.
    pub(super) correlation: f64,
    /// Factor by which the remaining correlation or the misfit has increased the standard
    /// deviations.
    pub(super) inflation: f64,
    /// Variance of the residuals relative to that of their third differences, a measure of the part
    /// that is not noise.
    pub(super) misfit: f64,
}

/// Fit of a circuit to a sweep.
pub(super) struct Fitter<'a> {
    rows: &'a Measured,
    /// Rows of each point.
    bins: Vec<Range<usize>>,
    /// Number of rows of each point.
    counts: Vec<f64>,
    measured: Measured,
    readings: Vec<Complex64>,
    pub(super) farad: f64,
}

/// Intermediate circuit: its solution and its weights.
#[derive(Clone)]
struct Stage {
    solution: Solution,
    weights: Weights,
}

/// Returns `true` if the circuit explains the data to rounding errors.
fn is_exact(solution: &Solution) -> bool {
    solution.cost < EXACT * solution.linear.residuals.len() as f64
}

impl<'a> Fitter<'a> {
    pub(super) fn new(rows: &'a Measured) -> Self {
        let bins = bins(&rows.readings(), MAX_POINTS);
        let measured = rows.averaged(&bins);
        let readings = measured.readings();
        let counts = bins.iter().map(|bin| bin.len() as f64).collect();
        let farad = |(y, hz): (&Complex64, &f64)| y.norm_sqr().sqrt() / (std::f64::consts::TAU * hz);
        let sizes = ascending(measured.admittance.iter().zip(&measured.hz).map(farad));
        let farad = quantile(&sizes, 0.5).filter(|c| *c > 0.0).unwrap_or(1e-9);
        Fitter { rows, bins, counts, measured, readings, farad }
    }

    /// Fits a given number of resonances, or the number that the data show.
    pub(super) fn fit(self, modes: Option<usize>) -> Result<Fit, ImportError> {
        let first = modes.unwrap_or(1);
        self.check_points(first)?;
        passivity::check_sense(&self.measured, start::gain)?;
        let mut last = self.stage(&[], None).ok_or_else(|| no_fit("not even a clamped capacitance can be fitted"))?;
        let most = modes.unwrap_or(MOST_MODES);
        // Best circuit so far with its number of resonances; none while the clamped branch is best.
        let mut best: Option<(usize, Stage)> = None;
        let mut clamped = Some(last.clone());
        for number in 1..=most {
            let is_last = best.as_ref().map_or(MOST_FIRST, |(have, _)| (have + MOST_TOGETHER).max(MOST_FIRST)) < number;
            let is_white = is_exact(&last.solution) || roughness(&complex(&last.solution.linear.residuals)) < MAX_ROUGHNESS;
            if modes.is_none() && (is_last && is_white || self.check_points(number).is_err()) {
                break;
            }
            let known = Equivalent::from_parameters(&last.solution.parameters, self.farad).branches;
            let Some(more) = self.stage(&known, Some(&last.weights)) else { break };
            let (fewer, have) = match (&best, &clamped) {
                (Some((have, stage)), _) => (stage, *have),
                (None, Some(clamped)) => (clamped, 0),
                (None, None) => break,
            };
            let is_worth = modes.is_some() || self.is_worth(fewer, &more, number - have);
            // The next stage starts with the weights of this one, even if it was not accepted.
            last = self.weighted(more);
            if is_worth {
                best = Some((number, last.clone()));
                clamped = None;
            }
        }
        match best {
            Some((number, stage)) if modes.is_none_or(|modes| modes == number) => self.finish(stage),
            _ => Err(self.no_resonance(modes)),
        }
    }

    fn check_points(&self, modes: usize) -> Result<(), ImportError> {
        let parameters = CLAMPED_PARAMETERS + BRANCH_PARAMETERS * modes;
        let (points, needed) = (self.measured.hz.len(), parameters + SPARE_POINTS);
        if points < needed { Err(ImportError::TooFewPoints { points, modes, parameters, needed }) } else { Ok(()) }
    }

    fn no_resonance(&self, modes: Option<usize>) -> ImportError {
        let hz = &self.rows.hz;
        let why = match modes {
            _ if passivity::is_inductive(&self.measured) => passivity::INDUCTIVE.to_owned(),
            Some(modes) if modes > 1 => format!("fewer than {modes} of them can be distinguished"),
            _ => "a capacitance with its loss explains the data as well as a circuit with a resonance. Sweep around the \
                  resonance of the transducer, with several points in its bandwidth"
                .to_owned(),
        };
        let [from_hz, to_hz] = [hz[0], hz[hz.len() - 1]].map(|hz| rounded(hz, 9));
        ImportError::NoResonance { from_hz, to_hz, why }
    }

    /// Returns the circuit with one more resonance than the known ones; with the known ones alone
    /// if there are no weights yet.
    fn stage(&self, known: &[Branch], before: Option<&Weights>) -> Option<Stage> {
        let measured = &self.measured;
        let weights = before.cloned().unwrap_or_else(|| Weights::equal(&self.counts));
        let weight: Vec<Complex64> = measured
            .admittance
            .iter()
            .zip(&weights.0)
            .enumerate()
            .map(|(at, (y, sd))| measured.reading(at, *y).1 / (0.5 * (sd[0] + sd[1])))
            .collect();
        let points = Points { hz: &measured.hz, admittance: &measured.admittance, weight: &weight };
        let starts = if before.is_some() { start::next(&points, known) } else { start::clamped(&points).into_iter().collect() };
        let few = |start: &Equivalent| self.solve_within(START_STEPS, &start.parameters(self.farad), &weights, 0.0);
        let solutions = starts.iter().filter_map(few).filter(|found| found.cost.is_finite());
        let best = solutions.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        let solution = if best.converged { Some(best) } else { self.solve(&best.parameters, &weights, 0.0) };
        solution.map(|solution| Stage { solution, weights })
    }

    /// Solves least squares with these weights, whitened by a correlation of neighbours.
    fn solve(&self, start: &[f64], weights: &Weights, correlation: f64) -> Option<Solution> {
        self.solve_within(usize::MAX, start, weights, correlation)
    }

    /// Solves as [`Fitter::solve`], within a number of steps.
    fn solve_within(&self, steps: usize, start: &[f64], weights: &Weights, correlation: f64) -> Option<Solution> {
        let (from, to) = (libm::log(self.measured.hz[0]), libm::log(self.measured.hz[self.measured.hz.len() - 1]));
        let is_resonance = |own: &[f64]| {
            (from - MAX_OUTSIDE_LN..=to + MAX_OUTSIDE_LN).contains(&own[0])
                && (libm::log(MIN_Q)..=libm::log(MAX_Q)).contains(&own[1])
        };
        minimise_within(steps, &[], start, |parameters| {
            if !parameters[CLAMPED_PARAMETERS..].chunks_exact(BRANCH_PARAMETERS).all(is_resonance) {
                return None;
            }
            let linear = self.linear(parameters, weights)?;
            Some(if correlation == 0.0 { linear } else { whitened(&linear, correlation) })
        })
    }

    /// Computes residuals and derivatives in units of the noise: first the real parts of all
    /// points, then the imaginary parts.
    pub(super) fn linear(&self, parameters: &[f64], weights: &Weights) -> Option<Linear> {
        let (points, n) = (self.readings.len(), parameters.len());
        let mut residuals = vec![0.0; 2 * points];
        let mut columns = vec![vec![0.0; 2 * points]; n];
        let mut slopes = Vec::with_capacity(n);
        for at in 0..points {
            let y = admittance(parameters, self.farad, self.measured.hz[at], Some(&mut slopes));
            let [re, im] = weights.0[at];
            let (reading, slope) = self.measured.reading(at, y);
            let error = self.measured.coordinate.difference(reading, self.readings[at]);
            (residuals[at], residuals[points + at]) = (error.re / re, error.im / im);
            for (column, by) in columns.iter_mut().zip(&slopes) {
                let change = slope * by;
                (column[at], column[points + at]) = (change.re / re, change.im / im);
            }
        }
        let finite = residuals.iter().all(|r| r.is_finite()) && columns.iter().flatten().all(|c| c.is_finite());
        finite.then_some(Linear { residuals, columns })
    }

    /// Determines weights from the residuals of a stage, and solves it again.
    fn weighted(&self, stage: Stage) -> Stage {
        let mut stage = stage;
        for _ in 0..WEIGHT_ROUNDS {
            let fitted = self.seen(&stage.solution.parameters);
            let coordinate = self.measured.coordinate;
            let freedom = (1.0 - 0.5 * stage.solution.parameters.len() as f64 / self.readings.len() as f64).sqrt();
            let errors: Vec<Complex64> = fitted
                .iter()
                .zip(&self.readings)
                .map(|(y, reading)| coordinate.difference(coordinate.of(*y), *reading) / freedom)
                .collect();
            let weights = Weights::from_residuals(coordinate, &fitted, &errors, &self.counts);
            match self.solve(&stage.solution.parameters, &weights, 0.0) {
                Some(solution) => stage = Stage { solution, weights },
                None => break,
            }
        }
        stage
    }

    /// Returns the admittances that the instrument would measure for a circuit.
    fn seen(&self, parameters: &[f64]) -> Vec<Complex64> {
        let measured = &self.measured;
        let of = |(at, hz): (usize, &f64)| {
            let y = admittance(parameters, self.farad, *hz, None);
            measured.fixture.get(at).map_or(y, |fixture| fixture.seen(y).0)
        };
        measured.hz.iter().enumerate().map(of).collect()
    }

    /// Returns `true` if further resonances are significant. Several are tested together, because
    /// one alone may not be: the residue of a second one looks like a long memory.
    fn is_worth(&self, fewer: &Stage, more: &Stage, further: usize) -> bool {
        let Some(fewer) = self.solve(&fewer.solution.parameters, &more.weights, 0.0) else { return false };
        if is_exact(&fewer) {
            return false;
        }
        let memory = memory(&complex(&more.solution.linear.residuals));
        let n = (2 * self.readings.len()) as f64 / memory.1;
        let gain = n * libm::log(fewer.cost / more.solution.cost.max(f64::MIN_POSITIVE));
        let needed = (BRANCH_PARAMETERS * further) as f64 * libm::log(n) + CRITERION_MARGIN;
        // A gain that is not a number is not a gain.
        if gain.is_nan() || gain <= needed {
            return false;
        }
        let (from, to) = (self.measured.hz[0], self.measured.hz[self.measured.hz.len() - 1]);
        let freedom = (2 * self.readings.len() - more.solution.parameters.len()) as f64;
        let variance = more.solution.cost / freedom * memory.1;
        let Some(covariance) = more.solution.covariance() else { return false };
        let own = &more.solution.parameters;
        (CLAMPED_PARAMETERS..own.len()).step_by(BRANCH_PARAMETERS).all(|at| {
            let sd = |at: usize| (variance * covariance[(at, at)]).sqrt();
            let inside = (libm::log(from)..=libm::log(to)).contains(&own[at]);
            inside && sd(at + 1) < MAX_LN_SD && sd(at + 2) < MAX_LN_SD
        })
    }

    /// Returns the errors of a circuit at all rows.
    fn row_errors(&self, parameters: &[f64]) -> Vec<Complex64> {
        let circuit = Equivalent::from_parameters(parameters, self.farad);
        let clamped = std::f64::consts::TAU * circuit.c0_f * Complex64::new(circuit.loss_tangent, 1.0);
        let error = |(at, (hz, reading)): (usize, (&f64, &Complex64))| {
            let y = hz * clamped + circuit.branches.iter().map(|branch| branch.admittance(*hz)).sum::<Complex64>();
            self.rows.coordinate.difference(self.rows.reading(at, y).0, *reading)
        };
        self.rows.hz.iter().zip(&self.rows.readings()).enumerate().map(error).collect()
    }

    /// Fits the circuit to all rows of a long sweep. Returns their residuals and the noise.
    fn compare_rows(&mut self, solution: &mut Solution, weights: &Weights) -> (Vec<Complex64>, [f64; 2]) {
        for _ in 0..ROW_ROUNDS {
            let errors = means(&self.row_errors(&solution.parameters), &self.bins);
            for (at, error) in errors.into_iter().enumerate() {
                let y = admittance(&solution.parameters, self.farad, self.measured.hz[at], None);
                self.readings[at] = self.measured.reading(at, y).0 - error;
            }
            if let Some(better) = self.solve(&solution.parameters, weights, 0.0) {
                *solution = better;
            }
        }
        let mut errors = self.row_errors(&solution.parameters);
        let rms = |of: fn(&Complex64) -> f64| (errors.iter().map(of).map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        let noise = [rms(|e| e.re), rms(|e| e.im)];
        for (bin, sd) in self.bins.iter().zip(&weights.0) {
            let [re, im] = sd.map(|sd| sd * (bin.len() as f64).sqrt());
            errors[bin.clone()].iter_mut().for_each(|e| *e = Complex64::new(e.re / re, e.im / im));
        }
        (errors, noise)
    }

    /// Whitens the residuals, and computes the covariance.
    fn finish(mut self, stage: Stage) -> Result<Fit, ImportError> {
        let is_exact = is_exact(&stage.solution);
        let Stage { mut solution, weights } = stage;
        let long = self.bins.len() < self.rows.hz.len();
        let (mut residuals, noise) = if long {
            self.compare_rows(&mut solution, &weights)
        } else {
            let mean = |part: usize| weights.0.iter().map(|sd| sd[part] * sd[part]).sum::<f64>() / weights.0.len() as f64;
            (complex(&solution.linear.residuals), [mean(0).sqrt(), mean(1).sqrt()])
        };
        let (mut correlation, mut inflation) = if is_exact { (0.0, 1.0) } else { memory(&residuals) };
        let misfit = if is_exact { 1.0 } else { roughness(&residuals) };
        if long {
            solution.cost = residuals.iter().map(Complex64::norm_sqr).sum();
            let sd = (solution.cost / (2 * residuals.len()) as f64).sqrt().max(f64::MIN_POSITIVE);
            residuals.iter_mut().for_each(|e| *e /= sd);
        }
        if inflation > 1.0 && !long {
            let rho = correlation.min(MAX_CORRELATION);
            if let Some(white) = self.solve(&solution.parameters, &weights, rho).filter(|white| white.converged) {
                inflation = memory(&complex(&white.linear.residuals)).1;
                solution = white;
            }
        } else if inflation <= 1.0 {
            correlation = 0.0;
        }
        // The errors of a circuit that lacks a resonance are not those of noise with a memory.
        if misfit > MAX_ROUGHNESS {
            inflation = inflation.max(misfit);
        }
        let free = 2 * residuals.len() - solution.parameters.len();
        let least = if is_exact { 1.0 } else { 0.0 };
        let variance = (solution.cost / free as f64).max(least) * inflation;
        let covariance =
            solution.covariance().ok_or_else(|| no_fit("the data do not determine all parameters of the circuit"))?;
        if !(solution.converged || is_exact) {
            return Err(no_fit("the search does not converge"));
        }
        if let Some(at) = (CLAMPED_PARAMETERS..solution.parameters.len())
            .step_by(BRANCH_PARAMETERS)
            .find(|at| !self.is_inside(solution.parameters[*at]))
        {
            let hz = libm::exp(solution.parameters[at]);
            let [from_hz, to_hz] = [self.rows.hz[0], self.rows.hz[self.rows.hz.len() - 1]].map(|hz| rounded(hz, 9));
            return Err(ImportError::NoResonance {
                from_hz,
                to_hz,
                why: format!("the nearest one that explains the data is outside, at {hz:.1} Hz"),
            });
        }
        Ok(Fit {
            parameters: solution.parameters.clone(),
            covariance: covariance * variance,
            farad: self.farad,
            residuals,
            noise,
            correlation,
            inflation: inflation.sqrt(),
            misfit,
        })
    }

    fn is_inside(&self, ln_hz: f64) -> bool {
        let hz = &self.rows.hz;
        (libm::log(hz[0])..=libm::log(hz[hz.len() - 1])).contains(&ln_hz)
    }
}

fn no_fit(what: &str) -> ImportError {
    ImportError::NoFit(what.to_owned())
}
