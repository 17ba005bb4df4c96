//! Runs of an optimisation: those that are known, and new ones.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::search::{Search, Steps};
use super::{Known, Question, Run, bits};
use crate::study::solve::SolveError;
use crate::study::sweep::SweepError;

/// Largest number of points of the sample that run before the next ones begin.
const MOST_AT_ONCE: usize = 64;

/// Common parts of all runs of a question.
pub(super) struct Evaluation<'q, 'a> {
    pub(super) question: &'q Question<'a>,
    pub(super) known: &'q Known,
    pub(super) stop: &'q AtomicBool,
    pub(super) done: &'q (dyn Fn(&Run) + Sync),
    pub(super) unsettled: AtomicU64,
}

impl Evaluation<'_, '_> {
    /// Runs the scene at these parts of the ranges; `None` if stopped.
    pub(super) fn runs(&self, parts: &[Vec<f64>]) -> Result<Option<Vec<Run>>, SolveError> {
        let mut runs: Vec<Option<Run>> = parts.iter().map(|parts| self.known.get(&bits(&self.values(parts))).cloned()).collect();
        let missing: Vec<usize> = (0..runs.len()).filter(|&point| runs[point].is_none()).collect();
        // Some points at a time, so that little is lost if the process ends.
        for some in missing.chunks(MOST_AT_ONCE) {
            let parts: Vec<Vec<f64>> = some.iter().map(|&point| parts[point].clone()).collect();
            let Some(found) = self.new_runs(&parts)? else { return Ok(None) };
            found.iter().for_each(self.done);
            some.iter().zip(found).for_each(|(&point, run)| runs[point] = Some(run));
        }
        Ok(Some(runs.into_iter().flatten().collect()))
    }

    /// Runs points that are not known.
    fn new_runs(&self, parts: &[Vec<f64>]) -> Result<Option<Vec<Run>>, SolveError> {
        let sweep = match self.question.sweep(parts) {
            // A point between the ends of the ranges need not be a valid scene.
            Err(SweepError::Scene(error)) if parts.len() == 1 => {
                let why = error.to_string().lines().next().unwrap_or_default().to_owned();
                let metrics = vec![None; self.question.metrics.len()];
                return Ok(Some(vec![Run { values: self.values(&parts[0]), metrics, failure: Some(why) }]));
            }
            Err(SweepError::Scene(_)) => {
                let each: Result<Option<Vec<Vec<Run>>>, SolveError> =
                    parts.iter().map(|parts| self.new_runs(std::slice::from_ref(parts))).collect();
                return Ok(each?.map(|runs| runs.concat()));
            }
            sweep => sweep?,
        };
        let rows = sweep.rows(0..parts.len() as u64, self.stop, &|| ()).map_err(SolveError::Run)?;
        self.unsettled.fetch_add(sweep.unsettled(), Ordering::Relaxed);
        let Some(rows) = rows.filter(|_| !self.stop.load(Ordering::Relaxed)) else { return Ok(None) };
        let run = |(row, parts): (usize, &Vec<f64>)| {
            let values = self.values(parts);
            let keys = self.question.ranges.iter().map(|range| &range.key).zip(&values);
            let value = |name: &String| match keys.clone().find(|(key, _)| *key == name) {
                Some((_, value)) => Some(*value),
                None => rows.metrics[sweep.metrics.iter().position(|of| of == name)?][row].filter(|of| of.is_finite()),
            };
            let metrics: Vec<Option<f64>> = self.question.metrics.iter().map(value).collect();
            let fault = rows.fault_codes[row].filter(|code| *code != 0 && self.question.loaded.scene.runs == 1);
            let needed = |name: &&String| {
                **name == self.question.metrics[0] || self.question.limits.iter().any(|limit| limit.metric == **name)
            };
            let absent = self.question.metrics.iter().filter(needed).find(|name| value(name).is_none());
            let failure = match (&rows.failures[row], fault, absent) {
                (Some(why), ..) => Some(why.lines().next().unwrap_or_default().to_owned()),
                (_, Some(code), _) => Some(format!("the run ends in fault {code}")),
                (.., Some(name)) => Some(format!("the run has no metric `{name}`")),
                _ => None,
            };
            Run { metrics, failure, values: values.clone() }
        };
        Ok(Some(parts.iter().enumerate().map(run).collect()))
    }

    /// Returns the values of the keys at parts of their ranges.
    fn values(&self, parts: &[f64]) -> Vec<f64> {
        parts.iter().zip(&self.question.ranges).map(|(&part, range)| range.value(part)).collect()
    }

    /// Searches from a point; returns the runs of the search.
    pub(super) fn search(&self, search: &Search, start: &[f64], steps: Steps) -> Result<Vec<Run>, SolveError> {
        let mut failed = None;
        let runs = search.descend(start, steps, &mut |parts| match self.runs(&[parts.to_vec()]) {
            Ok(runs) => runs?.pop(),
            Err(error) => {
                failed = Some(error);
                None
            }
        });
        failed.map_or(Ok(runs), Err)
    }
}
