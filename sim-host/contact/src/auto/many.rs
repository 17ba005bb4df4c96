//! Solutions of many problems at once, each equal to its single solution: their runs with the same
//! setting are batched.
//!
//! ```text
//! problems --> tried one by one: solved, or "this run is missing" --> runs of one setting, batched --> tried again ...
//! ```
//!
//! The next run of a solution follows from its runs so far. So each try solves the problem anew
//! with the known runs, until one is missing. Runs that cannot be batched are computed at once.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::mem::discriminant;

use super::ladder::Setting;
use super::runs::Runs;
use super::{Numerics, Solution, by_method};
use crate::SolveError;
use crate::method::{Method, linexp};
use crate::problem::Problem;
use crate::record::Record;
use crate::tally::{State, Tally};

/// Solves problems as [`solve_unwatched`](super::solve_unwatched) solves each of them, bit for bit.
/// `pause` is called from time to time.
///
/// Contacts with a mass and Dahl friction under a periodic forcing are run in batches of eight. The
/// cost per contact falls with their number and similarity; a few hundred points of a map at once
/// suffice.
///
/// # Errors
/// Each problem fails with the errors of [`solve`](super::solve).
pub fn solve_many(problems: &[Problem], numerics: &Numerics, pause: &dyn Fn()) -> Vec<Result<Solution, SolveError>> {
    // The search of a steady state has its own runs, one after the other.
    if numerics.steady {
        return problems.iter().map(|problem| by_method(problem, numerics, &pause, None::<&mut fn(&State)>)).collect();
    }
    let mut solutions: Vec<Option<Result<Solution, SolveError>>> = problems.iter().map(|_| None).collect();
    let mut pending: Vec<Pending> = (0..problems.len()).map(|index| Pending { index, runs: Vec::new() }).collect();
    while !pending.is_empty() {
        let mut wanted = Vec::new();
        for pending in pending {
            let known = KnownRuns { runs: &pending.runs, missing: RefCell::new(None), pause };
            let solution = by_method(&problems[pending.index], numerics, &known, None::<&mut fn(&State)>);
            match known.missing.into_inner() {
                Some(missing) => wanted.push((missing, pending)),
                None => solutions[pending.index] = Some(solution),
            }
        }
        wanted.sort_by(|(one, _), (other, _)| one.order(other));
        pending = Vec::with_capacity(wanted.len());
        for group in wanted.chunk_by_mut(|(one, _), (other, _)| one.is_like(other)) {
            let problems: Vec<&Problem> = group.iter().map(|(missing, _)| &missing.problem).collect();
            let (steps, order) = group[0].0.setting;
            let outcomes = linexp::run_batched(&problems, steps, order.unwrap_or(0), pause);
            for ((missing, pending), outcome) in group.iter_mut().zip(outcomes) {
                pending.runs.push((missing.key(), outcome));
            }
        }
        pending.extend(wanted.into_iter().map(|(_, pending)| pending));
    }
    solutions.into_iter().flatten().collect()
}

/// Problem that is not solved yet, with its runs so far.
struct Pending {
    index: usize,
    runs: Vec<(Key, Result<Tally, SolveError>)>,
}

/// Identity of a run of a problem: its setting, and the section of the problem that it covers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    setting: Setting,
    window_s: (f64, f64),
    duration_s: f64,
}

/// Run that is needed.
struct Missing {
    problem: Problem,
    setting: Setting,
    periods: f64,
    /// Velocity ratio and kappa; contacts with similar values reverse at about the same time.
    likeness: [f64; 2],
}

impl Missing {
    fn new(problem: &Problem, setting: Setting) -> Self {
        let likeness = [problem.sliding_m_per_s / problem.vibration_m_per_s(), problem.kappa()];
        let periods = (problem.duration_s * problem.waveform.frequency_hz()).round();
        Missing { problem: problem.clone(), setting, periods, likeness }
    }

    fn key(&self) -> Key {
        Key { setting: self.setting, window_s: self.problem.window_s, duration_s: self.problem.duration_s }
    }

    fn order(&self, other: &Self) -> Ordering {
        let likeness = || self.likeness[0].total_cmp(&other.likeness[0]).then(self.likeness[1].total_cmp(&other.likeness[1]));
        self.setting.cmp(&other.setting).then(self.periods.total_cmp(&other.periods)).then_with(likeness)
    }

    /// Returns `true` if the runs can be batched.
    fn is_like(&self, other: &Self) -> bool {
        let shape = |missing: &Self| discriminant(&missing.problem.waveform.shape());
        self.setting == other.setting && self.periods == other.periods && shape(self) == shape(other)
    }
}

/// Source of the known runs, which notes the first one that is missing.
struct KnownRuns<'a> {
    runs: &'a [(Key, Result<Tally, SolveError>)],
    missing: RefCell<Option<Missing>>,
    pause: &'a dyn Fn(),
}

impl Runs for KnownRuns<'_> {
    fn run(&self, problem: &Problem, method: Method, setting: Setting, accounted: bool) -> Result<Tally, SolveError> {
        if method != Method::Linexp || accounted || !linexp::can_be_batched(problem) {
            return self.pause.run(problem, method, setting, accounted);
        }
        let key = Key { setting, window_s: problem.window_s, duration_s: problem.duration_s };
        if let Some((_, outcome)) = self.runs.iter().find(|(runs, _)| *runs == key) {
            return outcome.clone();
        }
        *self.missing.borrow_mut() = Some(Missing::new(problem, setting));
        // This error ends a solution at once, for every method.
        Err(SolveError::Unsuited { method: method.name(), reason: String::new() })
    }

    /// Computes the run at once, because batches have no record.
    fn recorded(&self, problem: &Problem, method: Method, setting: Setting) -> Result<(Tally, Record), SolveError> {
        self.pause.recorded(problem, method, setting)
    }
}

#[cfg(test)]
mod tests;
