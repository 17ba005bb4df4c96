//! The fit: weighted least squares in the coordinates of the instrument, with as many resonances as the data ask for.
//!
//! ```text
//! start (next resonance) -> least squares -> weights from residuals -> least squares -> is it worth it? -> next resonance ...
//!                                                                                          |
//!                                             memory of the residuals -> least squares -> covariance
//! ```
//!
//! **How many resonances.** One more is accepted if it lowers `n ln(sum of squares)` by more than Bayes's information criterion asks for its three
//! parameters, `3 ln n`, and [`MARGIN`] beyond that; `n` is the number of real values over their memory.
//! **Memory.** Residuals of neighbouring points may be alike: an instrument that averages over time, a drift, a circuit that does not fit. They are
//! whitened by their correlation, `e(t) - rho e(t - 1)`, and what is left of it multiplies the covariance by `1 + 2 sum rho(k)`.

use num_complex::Complex64;

use super::circuit::{BRANCH, Branch, CLAMPED, Equivalent, admittance};
use super::measured::Measured;
use super::memory::{complex, memory, roughness, whitened};
use super::start::{self, Points};
use super::weights::Weights;
use crate::error::ImportError;
use crate::least_squares::{Linear, Solution, minimise};
use crate::stated::rounded;
use report::statistics::{ascending, quantile};

/// Most resonances that a circuit has.
pub const MOST_MODES: usize = 3;
/// Points beyond the number of parameters that leave something to judge the fit by.
const SPARE_POINTS: usize = 4;
/// What a further resonance must gain beyond Bayes's criterion.
const MARGIN: f64 = 12.0;
/// Quality factors within which a fit stays, and how far outside the sweep a resonance may go on the way, as the logarithm of a ratio: beyond, a branch is
/// none that a sweep shows, and a fit that lacks a resonance would go there.
const QUALITIES: (f64, f64) = (0.5, 1e5);
const OUTSIDE: f64 = 0.1;
/// Rounds of weights and least squares.
const ROUNDS: usize = 3;
/// Largest correlation of neighbours that is whitened.
const MOST_CORRELATION: f64 = 0.97;
/// Largest standard deviation of the logarithm of a conductance or quality of a resonance that counts as found.
const LARGEST_LN_SD: f64 = 0.35;

/// A circuit with what the data say of its certainty.
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
    /// Standard deviation of residuals as parts, size and angle, or of the scattering parameter: root mean square.
    pub(super) noise: [f64; 2],
    /// Correlation of neighbouring residuals.
    pub(super) correlation: f64,
    /// Factor by which what is left of it has enlarged the standard deviations.
    pub(super) inflation: f64,
    /// Variance of the residuals over that of their third differences: how much of them is no noise.
    pub(super) misfit: f64,
}

/// What is fitted.
pub(super) struct Fitter<'a> {
    measured: &'a Measured,
    readings: Vec<Complex64>,
    pub(super) farad: f64,
}

/// A circuit on the way: its solution and its weights.
#[derive(Clone)]
struct Stage {
    solution: Solution,
    weights: Weights,
}

impl<'a> Fitter<'a> {
    pub(super) fn new(measured: &'a Measured) -> Self {
        let readings = measured.seen.iter().map(|y| measured.coordinate.of(*y)).collect();
        let farad = |(y, hz): (&Complex64, &f64)| y.norm_sqr().sqrt() / (std::f64::consts::TAU * hz);
        let sizes = ascending(measured.admittance.iter().zip(&measured.hz).map(farad));
        let farad = quantile(&sizes, 0.5).filter(|c| *c > 0.0).unwrap_or(1e-9);
        Fitter { measured, readings, farad }
    }

    /// The fit with a given number of resonances, or with as many as the data ask for.
    pub(super) fn fit(&self, modes: Option<usize>) -> Result<Fit, ImportError> {
        let first = modes.unwrap_or(1);
        self.check_points(first)?;
        let mut last = self.stage(&[], None).ok_or_else(|| no_fit("the clamped capacitance alone does not explain anything"))?;
        let most = modes.unwrap_or(MOST_MODES);
        // The best so far with its number of resonances: none yet, which is the clamped branch alone.
        let mut best: Option<(usize, Stage)> = None;
        let mut clamped = Some(last.clone());
        for number in 1..=most {
            if modes.is_none() && self.check_points(number).is_err() {
                break;
            }
            let known = Equivalent::of(&last.solution.parameters, self.farad).branches;
            let Some(more) = self.stage(&known, Some(&last.weights)) else { break };
            let (fewer, have) = match (&best, &clamped) {
                (Some((have, stage)), _) => (stage, *have),
                (None, Some(clamped)) => (clamped, 0),
                (None, None) => break,
            };
            let is_worth = modes.is_some() || self.is_worth(fewer, &more, number - have);
            // Weights of the fit with this many, and the fit with them.
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
        let parameters = CLAMPED + BRANCH * modes;
        let (points, needed) = (self.measured.hz.len(), parameters + SPARE_POINTS);
        if points < needed { Err(ImportError::TooFewPoints { points, modes, parameters, needed }) } else { Ok(()) }
    }

    fn no_resonance(&self, modes: Option<usize>) -> ImportError {
        let hz = &self.measured.hz;
        let why = match modes {
            Some(modes) if modes > 1 => format!("there are not {modes} of them that can be told apart"),
            _ => "a capacitance with its loss explains the data as well as a circuit with a resonance. Sweep where the transducer resonates, with several \
                  points in its bandwidth"
                .to_owned(),
        };
        let [from_hz, to_hz] = [hz[0], hz[hz.len() - 1]].map(|hz| rounded(hz, 9));
        ImportError::NoResonance { from_hz, to_hz, why }
    }

    /// The circuit with one resonance more than the known ones; with those alone where there are no weights yet.
    fn stage(&self, known: &[Branch], before: Option<&Weights>) -> Option<Stage> {
        let measured = self.measured;
        let weights = before.cloned().unwrap_or_else(|| Weights::equal(measured.seen.len()));
        let weight: Vec<Complex64> = measured
            .admittance
            .iter()
            .zip(&weights.0)
            .enumerate()
            .map(|(at, (y, sd))| measured.reading(at, *y).1 / (0.5 * (sd[0] + sd[1])))
            .collect();
        let points = Points { hz: &measured.hz, admittance: &measured.admittance, weight: &weight };
        let starts = if before.is_some() { start::next(&points, known) } else { start::clamped(&points).into_iter().collect() };
        let solutions = starts.iter().filter_map(|start| self.solve(&start.parameters(self.farad), &weights, 0.0));
        let best = solutions.filter(|found| found.cost.is_finite()).min_by(|a, b| a.cost.total_cmp(&b.cost));
        best.map(|solution| Stage { solution, weights })
    }

    /// Least squares with these weights, whitened by a correlation of neighbours.
    fn solve(&self, start: &[f64], weights: &Weights, correlation: f64) -> Option<Solution> {
        let (from, to) = (libm::log(self.measured.hz[0]), libm::log(self.measured.hz[self.measured.hz.len() - 1]));
        let is_resonance = |own: &[f64]| {
            (from - OUTSIDE..=to + OUTSIDE).contains(&own[0])
                && (libm::log(QUALITIES.0)..=libm::log(QUALITIES.1)).contains(&own[1])
        };
        minimise(start, |parameters| {
            if !parameters[CLAMPED..].chunks_exact(BRANCH).all(is_resonance) {
                return None;
            }
            let linear = self.linear(parameters, weights)?;
            Some(if correlation == 0.0 { linear } else { whitened(&linear, correlation) })
        })
    }

    /// Residuals and derivatives in units of the noise: real parts of all points, then imaginary parts.
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

    /// The stage with weights from its own residuals, and solved again.
    fn weighted(&self, stage: Stage) -> Stage {
        let mut stage = stage;
        for _ in 0..ROUNDS {
            let fitted = self.seen(&stage.solution.parameters);
            let coordinate = self.measured.coordinate;
            let freedom = (1.0 - 0.5 * stage.solution.parameters.len() as f64 / self.readings.len() as f64).sqrt();
            let errors: Vec<Complex64> = fitted
                .iter()
                .zip(&self.readings)
                .map(|(y, reading)| coordinate.difference(coordinate.of(*y), *reading) / freedom)
                .collect();
            let weights = Weights::of(coordinate, &fitted, &errors);
            match self.solve(&stage.solution.parameters, &weights, 0.0) {
                Some(solution) => stage = Stage { solution, weights },
                None => break,
            }
        }
        stage
    }

    /// Admittances that the instrument would see of a circuit.
    fn seen(&self, parameters: &[f64]) -> Vec<Complex64> {
        let measured = self.measured;
        let of = |(at, hz): (usize, &f64)| {
            let y = admittance(parameters, self.farad, *hz, None);
            measured.fixture.get(at).map_or(y, |fixture| fixture.seen(y).0)
        };
        measured.hz.iter().enumerate().map(of).collect()
    }

    /// Whether so many resonances more are worth their parameters. One alone may not be where two are: what the second leaves looks like a long memory.
    fn is_worth(&self, fewer: &Stage, more: &Stage, further: usize) -> bool {
        let Some(fewer) = self.solve(&fewer.solution.parameters, &more.weights, 0.0) else { return false };
        let memory = memory(&complex(&more.solution.linear.residuals));
        let n = (2 * self.readings.len()) as f64 / memory.1;
        let gain = n * libm::log(fewer.cost / more.solution.cost.max(f64::MIN_POSITIVE));
        let needed = (BRANCH * further) as f64 * libm::log(n) + MARGIN;
        // A gain that is no number is none.
        if gain.is_nan() || gain <= needed {
            return false;
        }
        let (from, to) = (self.measured.hz[0], self.measured.hz[self.measured.hz.len() - 1]);
        let freedom = (2 * self.readings.len() - more.solution.parameters.len()) as f64;
        let variance = more.solution.cost / freedom * memory.1;
        let Some(covariance) = more.solution.covariance() else { return false };
        let own = &more.solution.parameters;
        (CLAMPED..own.len()).step_by(BRANCH).all(|at| {
            let sd = |at: usize| (variance * covariance[(at, at)]).sqrt();
            let inside = (libm::log(from)..=libm::log(to)).contains(&own[at]);
            inside && sd(at + 1) < LARGEST_LN_SD && sd(at + 2) < LARGEST_LN_SD
        })
    }

    /// Whitens, and states the covariance.
    fn finish(&self, stage: Stage) -> Result<Fit, ImportError> {
        let Stage { mut solution, weights } = stage;
        let (mut correlation, mut inflation) = memory(&complex(&solution.linear.residuals));
        let misfit = roughness(&complex(&solution.linear.residuals));
        let residuals = complex(&solution.linear.residuals);
        if inflation > 1.0 {
            let rho = correlation.min(MOST_CORRELATION);
            if let Some(white) = self.solve(&solution.parameters, &weights, rho).filter(|white| white.converged) {
                inflation = memory(&complex(&white.linear.residuals)).1;
                solution = white;
            }
        } else {
            correlation = 0.0;
        }
        let free = 2 * self.readings.len() - solution.parameters.len();
        let variance = solution.cost / free as f64 * inflation;
        let covariance =
            solution.covariance().ok_or_else(|| no_fit("the data do not determine all parameters of the circuit"))?;
        if !solution.converged {
            return Err(no_fit("the search does not come to an end"));
        }
        if let Some(at) =
            (CLAMPED..solution.parameters.len()).step_by(BRANCH).find(|at| !self.is_inside(solution.parameters[*at]))
        {
            let hz = libm::exp(solution.parameters[at]);
            let [from_hz, to_hz] = [self.measured.hz[0], self.measured.hz[self.measured.hz.len() - 1]].map(|hz| rounded(hz, 9));
            return Err(ImportError::NoResonance {
                from_hz,
                to_hz,
                why: format!("the nearest that explains the data lies outside, at {hz:.1} Hz"),
            });
        }
        let mean = |part: usize| {
            let squares = weights.0.iter().map(|sd| sd[part] * sd[part]).sum::<f64>();
            (squares / weights.0.len() as f64).sqrt()
        };
        Ok(Fit {
            parameters: solution.parameters.clone(),
            covariance: covariance * variance,
            farad: self.farad,
            residuals,
            noise: [mean(0), mean(1)],
            correlation,
            inflation: inflation.sqrt(),
            misfit,
        })
    }

    fn is_inside(&self, ln_hz: f64) -> bool {
        let hz = &self.measured.hz;
        (libm::log(hz[0])..=libm::log(hz[hz.len() - 1])).contains(&ln_hz)
    }
}

fn no_fit(what: &str) -> ImportError {
    ImportError::NoFit(what.to_owned())
}
