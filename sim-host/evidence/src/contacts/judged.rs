//! A contact's friction ratio and record by `auto` at a tolerance, compared with the Taylor series.

use contact::plane::{self, Direction, PlaneSolution};
use contact::tally::Ratios;
use contact::{Law, Numerics, Problem, Record, Solution, SolveError, ToleranceOf, solve, solve_unwatched, taylor};

/// The two settings of the series, steps a period and order; their difference is the uncertainty of
/// the reference.
const SETTINGS: [(u32, u32); 2] = [(6, 28), (4, 24)];
/// The two settings for the record. Their moments are those of all runs of the series in `auto`,
/// and half of those of the other methods.
const RECORD_SETTINGS: [(u32, u32); 2] = [(12, 28), (12, 24)];
/// Round-off of a record.
const RECORD_ROUND_OFF: f64 = 1e-13;
/// Largest uncertainty of a usable reference, relative to the tolerance.
const MAX_UNCERTAINTY_REL: f64 = 0.1;
/// Round-off of a mean, relative to the larger of Fc and the mean.
const ROUND_OFF: f64 = 2e-14;

/// Reference of the mean friction ratio of a contact.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    /// Mean friction over Fc.
    pub friction: f64,
    /// Uncertainty: difference between two settings of the series.
    pub unknown: f64,
}

impl Truth {
    /// Computes the reference of a problem.
    pub fn new(problem: &Problem) -> Result<Self, SolveError> {
        let by = |(steps, order)| {
            taylor::run_plain(problem, steps, order, &mut |_| ()).map(|tally| Ratios::of(problem, &tally).friction)
        };
        let (fine, other) = (by(SETTINGS[0])?, by(SETTINGS[1])?);
        Ok(Truth { friction: fine, unknown: (fine - other).abs().max(ROUND_OFF * fine.abs().max(1.0)) })
    }
}

/// Reference of the record of a contact.
pub struct RecordTruth<'a> {
    problem: &'a Problem,
    record: Record,
    /// Uncertainty: distance between two settings of the series.
    unknown: f64,
}

impl<'a> RecordTruth<'a> {
    /// Computes the reference of a problem.
    pub fn new(problem: &'a Problem) -> Result<Self, SolveError> {
        let by = |(steps, order)| {
            let mut record = Record::default();
            taylor::run_plain(problem, steps, order, &mut |state| record.add(state)).map(|_| record)
        };
        let (record, other) = (by(RECORD_SETTINGS[0])?, by(RECORD_SETTINGS[1])?);
        let unknown = record.distance(&other, problem).max(RECORD_ROUND_OFF);
        Ok(RecordTruth { problem, record, unknown })
    }
}

/// An answer of `auto`, or its refusal, compared with the reference.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Requested tolerance.
    pub tolerance: f64,
    /// Settings in words, or the refusal.
    pub how: String,
    /// Result of the comparison.
    pub verdict: Verdict,
}

/// Result of a comparison with the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// An answer.
    Answered {
        /// Error, less the uncertainty of the reference.
        error: f64,
        /// Error that the answer states.
        estimate: f64,
        /// `true` if the answer states that the tolerance is met.
        met: bool,
    },
    /// A refusal with advice.
    Refused,
    /// A refusal without advice: a bug.
    Failed,
    /// The reference is not accurate enough.
    Unknown,
}

impl Judged {
    /// Solves a problem by `auto`, and compares its mean.
    pub fn mean(problem: &Problem, truth: Option<&Truth>, tolerance: f64) -> Self {
        let numerics = Numerics { tolerance, energies: false, ..Numerics::default() };
        let solution = match solve_unwatched(problem, &numerics, &|| ()) {
            Ok(solution) => solution,
            Err(error) => return Self::refused(tolerance, &error),
        };
        let off = truth.map(|truth| ((solution.ratios.friction - truth.friction).abs(), truth.unknown));
        Self::answered(tolerance, &solution, off, solution.error_estimate)
    }

    /// Solves a problem with a vibration at an angle to the sliding by `auto`, and compares its
    /// mean.
    pub fn in_plane(problem: &Problem, direction: Direction, truth: Option<&Truth>, tolerance: f64) -> Self {
        let numerics = Numerics { tolerance, energies: false, ..Numerics::default() };
        match plane::solve(problem, direction, &numerics, (&|| (), None), false) {
            Ok(PlaneSolution { solution, .. }) => {
                let off = truth.map(|truth| ((solution.ratios.friction - truth.friction).abs(), truth.unknown));
                Self::answered(tolerance, &solution, off, solution.error_estimate)
            }
            Err(error) => Self::refused(tolerance, &error),
        }
    }

    /// Solves a problem by `auto` at a tolerance of the record, and compares the record.
    pub fn record(problem: &Problem, truth: Option<&RecordTruth>, tolerance: f64) -> Self {
        let numerics = Numerics { tolerance, tolerance_of: ToleranceOf::Record, energies: false, ..Numerics::default() };
        let mut record = Record::default();
        let solution = match solve(problem, &numerics, &mut |state| record.add(state)) {
            Ok(solution) => solution,
            Err(error) => return Self::refused(tolerance, &error),
        };
        let off = truth.map(|truth| (truth.record.distance(&record, truth.problem), truth.unknown));
        Self::answered(tolerance, &solution, off, solution.record_error_estimate)
    }

    fn refused(tolerance: f64, error: &SolveError) -> Self {
        let verdict = if matches!(error, SolveError::Refused { .. }) { Verdict::Refused } else { Verdict::Failed };
        Judged { tolerance, how: error.to_string(), verdict }
    }

    /// Judges an answer. `off` is its difference from the reference, and the uncertainty of the
    /// latter.
    fn answered(tolerance: f64, solution: &Solution, off: Option<(f64, f64)>, estimate: Option<f64>) -> Self {
        let order = solution.order.map(|order| format!(" order {order}")).unwrap_or_default();
        let steps = solution.steps_per_period.map(|steps| format!(" {steps} steps")).unwrap_or_default();
        let how = format!("{}{order}{steps}", solution.method.name());
        let Some((off, unknown)) = off.filter(|(_, unknown)| *unknown <= MAX_UNCERTAINTY_REL * tolerance) else {
            return Judged { tolerance, how, verdict: Verdict::Unknown };
        };
        let error = if off.is_nan() { f64::INFINITY } else { (off - unknown).max(0.0) };
        let estimate = estimate.unwrap_or(0.0);
        Judged { tolerance, how, verdict: Verdict::Answered { error, estimate, met: solution.tolerance_met } }
    }

    /// Returns `true` if the error exceeds the tolerance but is reported as met.
    pub fn is_silently_wrong(&self) -> bool {
        matches!(self.verdict, Verdict::Answered { error, met, .. } if met && error > self.tolerance)
    }

    /// Returns `true` if the stated error is low by more than a factor.
    pub fn is_low_by(&self, factor: f64) -> bool {
        matches!(self.verdict, Verdict::Answered { error, estimate, .. } if error > factor * estimate)
    }

    /// Returns `true` if the tolerance is reported as not met.
    pub fn is_flagged(&self) -> bool {
        matches!(self.verdict, Verdict::Answered { met: false, .. } | Verdict::Refused)
    }
}

/// Describes the dimensionless groups of a contact.
pub fn groups(problem: &Problem, direction: Option<Direction>) -> String {
    let angle = direction.map(|direction| format!(", {:.3e} degrees", direction.across.atan2(direction.along).to_degrees()));
    let omega = std::f64::consts::TAU * problem.waveform.frequency_hz();
    let (kt, lugre) = match problem.law {
        Law::Coulomb => (0.0, String::new()),
        Law::Dahl { stiffness_n_per_m } => (stiffness_n_per_m, String::new()),
        Law::Lugre { stiffness_n_per_m, static_ratio, stribeck_m_per_s, sigma1, .. } => {
            let stribeck = stribeck_m_per_s / problem.vibration_m_per_s();
            (stiffness_n_per_m, format!(", Fs/Fc {static_ratio:.2}, Stribeck {stribeck:.1e}, sigma1 {sigma1:.1e}"))
        }
    };
    let motion = match problem.motion {
        contact::Motion::Kinematic => "kinematic".to_owned(),
        contact::Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => {
            let natural = problem.motion.natural_hz().unwrap_or(0.0) / problem.waveform.frequency_hz();
            let zeta = 0.5 * damping_n_s_per_m / (mass_kg * stiffness_n_per_m).sqrt();
            format!("spring {:.1e}, natural {natural:.3}, zeta {zeta:.1e}", kt / (mass_kg * omega * omega))
        }
    };
    format!(
        "{motion}, kappa {:.2e}, Fc/F0 {:.1e}, xi {:.1e}, {:?}, {:?}, {:.0} periods, window from {:.0} %{lugre}{}",
        problem.kappa(),
        problem.coulomb_n / problem.waveform.amplitude(),
        problem.sliding_m_per_s / problem.vibration_m_per_s(),
        problem.waveform.shape(),
        problem.sign,
        problem.duration_s * problem.waveform.frequency_hz(),
        100.0 * problem.window_s.0 / problem.duration_s,
        angle.unwrap_or_default(),
    )
}
