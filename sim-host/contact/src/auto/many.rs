//! Many problems at once, each solved as it is alone: the runs that they ask for in the same setting are made side by side.
//!
//! ```text
//! problems --> asked, one by one: solved, or "I need this run" --> runs of one setting, side by side --> asked again ...
//! ```
//!
//! What a solution does next follows from the runs it has had, so asking is solving it anew with the runs that there are, until one is
//! missing. What lanes cannot do is run when it is asked for.

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

/// Solves problems as [`solve_unwatched`](super::solve_unwatched) solves each of them, bit for bit; `pause` is called every now and then.
///
/// Contacts with a mass and Dahl friction under a periodic forcing are run eight at a time: the more of them there are, and the more alike,
/// the less one costs. A few hundred of a map at once are as good as all.
///
/// # Errors
/// Of each problem those of [`solve`](super::solve).
pub fn solve_many(problems: &[Problem], numerics: &Numerics, pause: &dyn Fn()) -> Vec<Result<Solution, SolveError>> {
    let mut solutions: Vec<Option<Result<Solution, SolveError>>> = problems.iter().map(|_| None).collect();
    let mut asking: Vec<Asking> = (0..problems.len()).map(|index| Asking { index, had: Vec::new() }).collect();
    while !asking.is_empty() {
        let mut wanted = Vec::new();
        for asking in asking {
            let beside = Beside { had: &asking.had, missing: RefCell::new(None), pause };
            let solution = by_method(&problems[asking.index], numerics, &beside, None::<&mut fn(&State)>);
            match beside.missing.into_inner() {
                Some(missing) => wanted.push((missing, asking)),
                None => solutions[asking.index] = Some(solution),
            }
        }
        wanted.sort_by(|(one, _), (other, _)| one.order(other));
        asking = Vec::with_capacity(wanted.len());
        for alike in wanted.chunk_by_mut(|(one, _), (other, _)| one.is_like(other)) {
            let problems: Vec<&Problem> = alike.iter().map(|(missing, _)| &missing.problem).collect();
            let (steps, order) = alike[0].0.setting;
            let outcomes = linexp::run_abreast(&problems, steps, order.unwrap_or(0), pause);
            for ((missing, asking), outcome) in alike.iter_mut().zip(outcomes) {
                asking.had.push((missing.key(), outcome));
            }
        }
        asking.extend(wanted.into_iter().map(|(_, asking)| asking));
    }
    solutions.into_iter().flatten().collect()
}

/// A problem that is not solved yet, and its runs so far.
struct Asking {
    index: usize,
    had: Vec<(Key, Result<Tally, SolveError>)>,
}

/// Which run of a problem it is: its setting, and how much of the problem it is of.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    setting: Setting,
    window_s: (f64, f64),
    duration_s: f64,
}

/// A run that is needed.
struct Missing {
    problem: Problem,
    setting: Setting,
    periods: f64,
    /// By what contacts reverse at about the same time.
    likeness: [f64; 2],
}

impl Missing {
    fn of(problem: &Problem, setting: Setting) -> Self {
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

    /// Whether the runs can be side by side.
    fn is_like(&self, other: &Self) -> bool {
        let shape = |missing: &Self| discriminant(&missing.problem.waveform.shape());
        self.setting == other.setting && self.periods == other.periods && shape(self) == shape(other)
    }
}

/// The runs that there are; the first that is missing is noted.
struct Beside<'a> {
    had: &'a [(Key, Result<Tally, SolveError>)],
    missing: RefCell<Option<Missing>>,
    pause: &'a dyn Fn(),
}

impl Runs for Beside<'_> {
    fn run(&self, problem: &Problem, method: Method, setting: Setting, accounted: bool) -> Result<Tally, SolveError> {
        if method != Method::Linexp || accounted || !linexp::is_for_lanes(problem) {
            return self.pause.run(problem, method, setting, accounted);
        }
        let key = Key { setting, window_s: problem.window_s, duration_s: problem.duration_s };
        if let Some((_, outcome)) = self.had.iter().find(|(had, _)| *had == key) {
            return outcome.clone();
        }
        *self.missing.borrow_mut() = Some(Missing::of(problem, setting));
        // Of all errors this one ends a solution at once, whatever the method.
        Err(SolveError::Unsuited { method: method.name(), reason: String::new() })
    }

    /// Lanes have no record.
    fn recorded(&self, problem: &Problem, method: Method, setting: Setting) -> Result<(Tally, Record), SolveError> {
        self.pause.recorded(problem, method, setting)
    }
}

#[cfg(test)]
mod tests;
