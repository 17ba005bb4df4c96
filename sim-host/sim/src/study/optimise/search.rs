//! Objective and limits as functions of order one, and a search from one point.

use std::cell::RefCell;

use cobyla::{Func, RhoBeg, StopTols};

use super::{Goal, Limit, Question, Run};
use report::statistics::{ascending, percentile};

/// Ratio of the largest to the smallest value of a positive objective above which its logarithm is
/// searched: an optimum far below the sample then is not lost in its scale.
const LOG_RATIO: f64 = 100.0;
/// Part of each range below which a step ends a search.
const LAST_STEP: f64 = 1e-6;
/// Merit of a run that meets its limits only after this is subtracted.
const BEYOND_LIMITS: f64 = 1e9;
/// Loss of a run without a result, above the largest of the sample.
const FAILED: f64 = 1.0;

/// First step of a search, as a part of each range, and its largest number of runs.
#[derive(Clone, Copy)]
pub(super) struct Steps {
    pub(super) first: f64,
    pub(super) most: usize,
}

/// Scales of objective and limits, from a sample.
pub(super) struct Search<'q, 'a> {
    question: &'q Question<'a>,
    /// `true` if the logarithm of the objective is searched.
    is_log: bool,
    /// Spread of the objective and of the metric of each limit.
    spreads: Vec<f64>,
    largest_loss: f64,
}

impl<'q, 'a> Search<'q, 'a> {
    pub(super) fn new(question: &'q Question<'a>, sample: &[Run]) -> Self {
        let of = |run: &Run, limit: &Limit| question.excess(limit, run);
        let objective: Vec<f64> = sample.iter().filter(|run| run.failure.is_none()).filter_map(|run| run.metrics[0]).collect();
        let (least, most) =
            objective.iter().fold((f64::INFINITY, 0.0), |(least, most), &value| (value.min(least), value.max(most)));
        let is_log = least > 0.0 && most > LOG_RATIO * least;
        let spread = |values: Vec<f64>| {
            let rising = ascending(values);
            let wide = rising.last().zip(rising.first()).map_or(0.0, |(most, least)| most - least);
            let inner = if rising.is_empty() { 0.0 } else { percentile(&rising, 0.9) - percentile(&rising, 0.1) };
            [inner, wide, 1.0].into_iter().find(|spread| *spread > 0.0).unwrap_or(1.0)
        };
        let objective = objective.into_iter().map(|value| if is_log { value.ln() } else { value }).collect();
        let limits = question.limits.iter().map(|limit| spread(sample.iter().filter_map(|run| of(run, limit)).collect()));
        let spreads = std::iter::once(spread(objective)).chain(limits).collect();
        let mut search = Search { question, is_log, spreads, largest_loss: 0.0 };
        let losses = sample.iter().filter(|run| run.failure.is_none()).map(|run| search.loss(run));
        search.largest_loss = losses.fold(f64::NEG_INFINITY, f64::max).max(-BEYOND_LIMITS);
        search
    }

    /// Returns the objective as a loss over its spread.
    fn loss(&self, run: &Run) -> f64 {
        let Some(value) = run.metrics[0].filter(|_| run.failure.is_none()) else { return self.largest_loss + FAILED };
        let value = if self.is_log { value.max(f64::MIN_POSITIVE).ln() } else { value };
        (if self.question.goal == Goal::Maximise { -value } else { value }) / self.spreads[0]
    }

    /// Returns the distance beyond each limit over its spread; negative within the limit.
    fn excesses(&self, run: &Run) -> Vec<f64> {
        let of = |(limit, spread): (&Limit, &f64)| {
            let excess = self.question.excess(limit, run).filter(|_| run.failure.is_none());
            excess.map_or(FAILED, |excess| excess / spread)
        };
        self.question.limits.iter().zip(&self.spreads[1..]).map(of).collect()
    }

    /// Returns a number by which runs are ordered: those within all limits by their loss, then the
    /// others by their distance beyond the limits, then those without a result.
    pub(super) fn merit(&self, run: &Run) -> f64 {
        let beyond: f64 = self.excesses(run).into_iter().map(|excess| excess.max(0.0)).sum();
        match run.failure {
            Some(_) => f64::INFINITY,
            None if beyond > 0.0 => BEYOND_LIMITS + beyond,
            None => self.loss(run),
        }
    }

    /// Searches from a point, in parts of the ranges; returns its runs. `run` returns `None` to
    /// stop.
    pub(super) fn descend(&self, start: &[f64], steps: Steps, run: &mut dyn FnMut(&[f64]) -> Option<Run>) -> Vec<Run> {
        struct State<'r> {
            run: &'r mut dyn FnMut(&[f64]) -> Option<Run>,
            runs: Vec<Run>,
            /// Last point, its loss and its excesses: objective and limits are called in turn.
            last: Option<(Vec<f64>, f64, Vec<f64>)>,
            is_stopped: bool,
        }
        let state = RefCell::new(State { run, runs: Vec::new(), last: None, is_stopped: false });
        // The loss, or the distance to a limit, which COBYLA keeps from becoming negative.
        let value = |at: &[f64], which: Option<usize>| {
            let mut state = state.borrow_mut();
            if state.last.as_ref().is_none_or(|(last, ..)| last != at) && !state.is_stopped {
                let parts: Vec<f64> = at.iter().map(|part| part.clamp(0.0, 1.0)).collect();
                match (state.run)(&parts) {
                    Some(found) => {
                        state.last = Some((at.to_vec(), self.loss(&found), self.excesses(&found)));
                        state.runs.push(found);
                    }
                    None => state.is_stopped = true,
                }
            }
            let last = state.last.as_ref().filter(|_| !state.is_stopped);
            last.map_or(self.largest_loss + FAILED, |(_, loss, excesses)| which.map_or(*loss, |limit| -excesses[limit]))
        };
        let loss = |at: &[f64], (): &mut ()| value(at, None);
        let limits: Vec<_> =
            (0..self.question.limits.len()).map(|limit| move |at: &[f64], (): &mut ()| value(at, Some(limit))).collect();
        let limits: Vec<&dyn Func<()>> = limits.iter().map(|limit| limit as &dyn Func<()>).collect();
        let bounds = vec![(0.0, 1.0); start.len()];
        let tolerances = StopTols { xtol_abs: vec![LAST_STEP; start.len()], ..StopTols::default() };
        // The answer is taken from the runs, also if the search ends with an error.
        let _ = cobyla::minimize(loss, start, &bounds, &limits, (), steps.most, RhoBeg::All(steps.first), Some(tolerances));
        state.into_inner().runs
    }
}
