//! Values of several keys at which a metric is least or largest, within limits of others.
//!
//! ```text
//! ranges --> Sobol' sample --> its local optima --> searches from each (COBYLA) --> restarts from the best
//! ```
//!
//! A point that is better than its nearest neighbours in the sample is a start. COBYLA (M. J. D.
//! Powell, 1994) interpolates objective and limits linearly on a simplex, without derivatives, and
//! treats each limit by itself, so that it ends at an active limit. The searches run in parallel
//! and are independent: the result does not depend on the number of threads. The answer is the best
//! of all runs that meet every limit.

mod evaluation;
mod search;

use std::collections::HashMap;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use self::evaluation::Evaluation;
use self::search::{Search, Steps};
use super::solve::SolveError;
use super::sweep::axis::Range;
use super::sweep::design::Design;
use super::sweep::{Sweep, SweepError};
use scene::load::Loaded;
use scene::schema::{Kind, Schema};
use scene::shown;
use serde_json::{Map, Value, json};

/// Default number of runs: of a contact study or a design, and of a scene that drives a controller,
/// whose run takes about a thousand times as long.
const RUNS: [u64; 2] = [2000, 200];

/// Share of the runs that sample the ranges.
const SAMPLE_SHARE: f64 = 0.25;
/// Limits of the size of the sample.
const SAMPLE_SIZE: (u64, u64) = (8, 512);
/// Largest number of searches from different starts.
const MOST_STARTS: usize = 8;
/// Share of the runs after the sample that these searches may take; restarts take the others.
const STARTS_SHARE: f64 = 0.7;
/// First steps of the restarts from the best run, as parts of each range.
const RESTARTS: [f64; 2] = [0.03, 0.003];
/// Smallest gain of a restart that is followed by another one, spreads of the objective.
const LEAST_GAIN: f64 = 1e-4;
/// Number of the scrambled sequence of samples, a different one from that of a sweep's sample.
const SCRAMBLE: u32 = 1;
/// Distance, as a part of each range, below which two optima are the same.
const SAME_OPTIMUM: f64 = 0.02;
/// Largest number of keys: the starts and the steps of a search grow with it.
const MOST_KEYS: usize = 16;
/// Metric that is not a quantity.
const FAULT_CODE: &str = "fault_code";

/// Direction of the objective.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// The least value.
    Minimise,
    /// The largest value.
    Maximise,
}

/// Limit of a metric, as written by a user: `METRIC<=VALUE` or `METRIC>=VALUE`.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Name of the metric.
    pub metric: String,
    /// `true` if the value is an upper limit.
    pub is_upper: bool,
    /// Value.
    pub value: f64,
}

impl Limit {
    /// Returns the distance of a metric beyond the limit; negative within it.
    fn excess(&self, value: f64) -> f64 {
        if self.is_upper { value - self.value } else { self.value - value }
    }
}

impl FromStr for Limit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("`{text}` is not a limit METRIC<=VALUE or METRIC>=VALUE, for example `friction_ratio<=0.4`");
        let at = text.find(['<', '>']).ok_or_else(wrong)?;
        let (metric, rest) = text.split_at(at);
        let number = rest[1..].strip_prefix('=').unwrap_or(&rest[1..]).trim();
        let value = number.parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(wrong)?;
        let metric = metric.trim().to_owned();
        if metric.is_empty() {
            return Err(wrong());
        }
        Ok(Limit { metric, is_upper: rest.starts_with('<'), value })
    }
}

/// Question: where is a metric best within limits?
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// The scene that is changed.
    pub loaded: &'a Loaded,
    /// Keys with their ranges.
    pub ranges: Vec<Range>,
    /// Metrics of a run: the objective, those of the limits, and further ones. A key of the ranges
    /// may stand for a metric: its value.
    pub metrics: Vec<String>,
    /// Direction of the objective.
    pub goal: Goal,
    /// Limits.
    pub limits: Vec<Limit>,
    /// Largest number of runs.
    pub runs: u64,
}

/// One run: values of the keys, and its metrics or the reason that it has none.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Value of each key.
    pub values: Vec<f64>,
    /// Each metric, if the run has it.
    pub metrics: Vec<Option<f64>>,
    /// Reason that the run does not count: it has no result, ended in a fault, or lacks a metric.
    pub failure: Option<String>,
}

/// Runs by the bits of their values.
pub type Known = HashMap<Vec<u64>, Run>;

/// Returns the name of a run in [`Known`].
pub fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// Answer to a question.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// Best run of each region of the ranges in which a search ended, the best of all first.
    /// Without a run within all limits, the one nearest to them.
    pub optima: Vec<Run>,
    /// `true` if the first of them meets every limit.
    pub is_within_limits: bool,
    /// All runs: the sample, then each search.
    pub runs: Vec<Run>,
    /// Number of runs of the sample.
    pub samples: u64,
    /// Number of runs whose means are over a window, because no steady state was found.
    pub unsettled: u64,
}

impl Limit {
    /// Returns the limit as text.
    pub fn text(&self) -> String {
        format!("{} {} {}", self.metric, if self.is_upper { "<=" } else { ">=" }, shown(self.value))
    }
}

impl Answer {
    /// Returns the answer as JSON.
    pub fn json(&self, question: &Question) -> Value {
        let run = |run: &Run| {
            let keys = question.ranges.iter().zip(&run.values).map(|(range, value)| (range.key.clone(), json!(value)));
            let metrics = question.metrics.iter().zip(&run.metrics).map(|(name, value)| (name.clone(), json!(value)));
            let (keys, metrics): (Map<_, _>, Map<_, _>) = (keys.collect(), metrics.collect());
            json!({ "objective": run.metrics[0], "keys": keys, "metrics": metrics })
        };
        json!({
            "scene": question.loaded.name,
            "objective": question.metrics[0],
            "goal": if question.goal == Goal::Minimise { "minimise" } else { "maximise" },
            "limits": question.limits.iter().map(Limit::text).collect::<Vec<_>>(),
            "within_limits": self.is_within_limits,
            "best": self.optima.first().map(run),
            "others": self.optima.iter().skip(1).map(run).collect::<Vec<_>>(),
            "runs": self.runs.len(),
            "samples": self.samples,
            "failures": self.runs.iter().filter(|run| run.failure.is_some()).count(),
            "unsettled": self.unsettled,
            "assumed": question.loaded.assumed_with(&question.keys()),
        })
    }
}

impl<'a> Question<'a> {
    /// Returns the keys.
    pub fn keys(&self) -> Vec<&str> {
        self.ranges.iter().map(|range| range.key.as_str()).collect()
    }

    /// Creates a question for an objective, with further metrics to report and a number of runs.
    pub fn new(
        loaded: &'a Loaded,
        ranges: Vec<Range>,
        (goal, objective): (Goal, String),
        limits: Vec<Limit>,
        (further, runs): (Vec<String>, Option<u64>),
    ) -> Self {
        let mut metrics = vec![objective];
        for name in limits.iter().map(|limit| &limit.metric).chain(&further) {
            if !metrics.contains(name) {
                metrics.push(name.clone());
            }
        }
        let runs = runs.unwrap_or(RUNS[usize::from(loaded.scene.controller.is_some())]);
        Question { loaded, ranges, metrics, goal, limits, runs }
    }
}

impl Question<'_> {
    /// Answers the question; `None` if stopped. Runs in `known` are not repeated; `done` is called
    /// after each other one.
    ///
    /// # Errors
    /// If a key or a metric is not one of the scene, or a run cannot be made.
    pub fn answer(&self, known: &Known, stop: &AtomicBool, done: &(dyn Fn(&Run) + Sync)) -> Result<Option<Answer>, SolveError> {
        self.check()?;
        let evaluation = Evaluation { question: self, known, stop, done, unsettled: AtomicU64::new(0) };
        let keys = self.ranges.len();
        let count = ((self.runs as f64 * SAMPLE_SHARE) as u64).clamp(SAMPLE_SIZE.0, SAMPLE_SIZE.1).min(self.runs);
        let draw = |number: u64| (0..keys).map(|key| sobol_burley::sample(number as u32, key as u32, SCRAMBLE).into()).collect();
        let sample: Vec<Vec<f64>> = (0..count).map(draw).collect();
        let Some(sampled) = evaluation.runs(&sample)? else { return Ok(None) };
        let search = Search::new(self, &sampled);
        let merits: Vec<f64> = sampled.iter().map(|run| search.merit(run)).collect();
        let starts = starts(&sample, &merits);
        let left = self.runs - count;
        // A simplex needs one run more than it has keys.
        let each = (left as f64 * STARTS_SHARE / starts.len() as f64) as usize;
        let used = left as usize / (2 * (keys + 2));
        let starts = &starts[..starts.len().min(used)];
        let spacing = 0.5 * (count as f64).powf(-1.0 / keys as f64);
        let best = |runs: &[Run]| runs.iter().min_by(|a, b| search.merit(a).total_cmp(&search.merit(b))).cloned();
        let from_start = |&start: &usize| {
            let mut runs = evaluation.search(&search, &sample[start], Steps { first: spacing.min(0.25), most: each })?;
            // Along a curved limit a search ends too early; the same from its end does not.
            while let Some(last) = best(&runs).filter(|_| runs.len() + keys + 2 <= each) {
                let steps = Steps { first: RESTARTS[0], most: each - runs.len() };
                runs.extend(evaluation.search(&search, &self.parts(&last.values), steps)?);
                if best(&runs).is_none_or(|next| search.merit(&next) > search.merit(&last) - LEAST_GAIN) {
                    break;
                }
            }
            Ok(runs)
        };
        let found: Result<Vec<Vec<Run>>, SolveError> = starts.par_iter().map(from_start).collect();
        let mut found = found?;
        for first in RESTARTS {
            let used: usize = found.iter().map(Vec::len).sum();
            let left = left as usize - used;
            if starts.is_empty() || left < keys + 2 || stop.load(Ordering::Relaxed) {
                break;
            }
            let Some(last) = best(&[&sampled[..], &found.concat()].concat()) else { break };
            found.push(evaluation.search(&search, &self.parts(&last.values), Steps { first, most: left })?);
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let ends: Vec<Run> = found.iter().filter_map(|runs| best(runs)).collect();
        let optima = self.distinct(best(&sampled), ends, &search);
        let is_within_limits = optima.first().is_some_and(|run| self.is_within_limits(run));
        let runs = sampled.into_iter().chain(found.into_iter().flatten()).collect();
        let unsettled = evaluation.unsettled.into_inner();
        Ok(Some(Answer { optima, is_within_limits, runs, samples: count, unsettled }))
    }

    /// Returns the distinct ends of the searches, the best first, and before them the best run of
    /// the sample if no search has found a better one. Without a run within all limits, only the
    /// nearest one.
    fn distinct(&self, sampled: Option<Run>, ends: Vec<Run>, search: &Search) -> Vec<Run> {
        let is_better = |sampled: &Run| ends.iter().all(|run| search.merit(sampled) < search.merit(run));
        let mut all: Vec<Run> = sampled.filter(is_better).into_iter().chain(ends.iter().cloned()).collect();
        all.retain(|run| run.failure.is_none());
        all.sort_by(|a, b| search.merit(a).total_cmp(&search.merit(b)));
        let mut optima: Vec<Run> = Vec::new();
        for run in all {
            let near = |other: &Run| distance(&self.parts(&run.values), &self.parts(&other.values)) < SAME_OPTIMUM;
            if !optima.iter().any(near) {
                optima.push(run);
            }
        }
        match optima.first().is_some_and(|run| self.is_within_limits(run)) {
            true => optima.retain(|run| self.is_within_limits(run)),
            false => optima.truncate(1),
        }
        optima
    }

    /// Checks keys and metrics, at both ends of all ranges, before any work.
    ///
    /// # Errors
    /// If a key or a metric is not one of the scene.
    pub fn check(&self) -> Result<(), SweepError> {
        for range in &self.ranges {
            if Schema::root().at(&range.key).is_some_and(|schema| schema.kind() == Kind::Integer) {
                let why = "is a whole number: `sim-host sweep --over` runs all of its values".to_owned();
                return Err(SweepError::Key { key: range.key.clone(), why });
            }
        }
        if let Some(range) = self.ranges.get(MOST_KEYS) {
            let why = format!("is one key too many: a search has at most {MOST_KEYS}");
            return Err(SweepError::Key { key: range.key.clone(), why });
        }
        if self.metrics.iter().any(|metric| metric == FAULT_CODE) {
            return Err(SweepError::Metric(format!("`{FAULT_CODE}` is not a quantity: a run that ends in a fault never counts")));
        }
        let [low, high] = [0.0, 1.0].map(|part| vec![part; self.ranges.len()]);
        self.sweep(&[low, high]).map(drop)
    }

    /// Returns `true` if a run meets every limit.
    pub fn is_within_limits(&self, run: &Run) -> bool {
        run.failure.is_none() && self.limits.iter().all(|limit| self.excess(limit, run).is_some_and(|excess| excess <= 0.0))
    }

    /// Returns the distance of a run beyond a limit.
    pub fn excess(&self, limit: &Limit, run: &Run) -> Option<f64> {
        let place = self.metrics.iter().position(|metric| *metric == limit.metric)?;
        run.metrics[place].map(|value| limit.excess(value))
    }

    /// Returns the sweep over these parts of the ranges, from 0 to 1.
    fn sweep(&self, parts: &[Vec<f64>]) -> Result<Sweep<'_>, SweepError> {
        let values = |parts: &Vec<f64>| parts.iter().zip(&self.ranges).map(|(&part, range)| range.value(part)).collect();
        let keys = self.ranges.iter().map(|range| range.key.clone()).collect();
        let design = Design::listed(keys, parts.iter().map(values).collect())?;
        let is_key = |name: &String| self.ranges.iter().any(|range| range.key == *name);
        let metrics: Vec<String> = self.metrics.iter().filter(|name| !is_key(name)).cloned().collect();
        if metrics.is_empty() {
            return Err(SweepError::Metric("objective and limits are keys: at least one of them must be a metric".to_owned()));
        }
        Sweep::new(self.loaded, design, &metrics)
    }

    /// Returns values as parts of their ranges.
    fn parts(&self, values: &[f64]) -> Vec<f64> {
        values.iter().zip(&self.ranges).map(|(&value, range)| range.part(value).clamp(0.0, 1.0)).collect()
    }
}

/// Returns the points of a sample that are better than all of their nearest neighbours, the best
/// first.
fn starts(sample: &[Vec<f64>], merits: &[f64]) -> Vec<usize> {
    let neighbours = 2 * sample.first().map_or(0, Vec::len) + 1;
    let is_start = |&point: &usize| {
        let mut others: Vec<usize> = (0..sample.len()).filter(|&other| other != point).collect();
        others.sort_by(|&a, &b| distance(&sample[a], &sample[point]).total_cmp(&distance(&sample[b], &sample[point])));
        merits[point] < f64::INFINITY && others.iter().take(neighbours).all(|&other| merits[point] <= merits[other])
    };
    let mut starts: Vec<usize> = (0..sample.len()).filter(is_start).collect();
    starts.sort_by(|&a, &b| merits[a].total_cmp(&merits[b]));
    starts.truncate(MOST_STARTS);
    starts
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(sets: &[&str], over: &[&str], goal: Goal, metrics: &[&str], limits: &[&str]) -> Answer {
        let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
        let loaded = scene::load::load("contact-kinematic", &sets).unwrap_or_else(|error| panic!("{error}"));
        let question = Question {
            loaded: &loaded,
            ranges: over.iter().map(|over| over.parse().unwrap()).collect(),
            metrics: metrics.iter().map(|&metric| metric.to_owned()).collect(),
            goal,
            limits: limits.iter().map(|limit| limit.parse().unwrap()).collect(),
            runs: 1000,
        };
        let answer = |jobs: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build().unwrap();
            pool.install(|| question.answer(&Known::new(), &AtomicBool::new(false), &|_| ())).unwrap().unwrap()
        };
        let found = answer(1);
        assert!(found.runs.len() <= 1000 && found == answer(3));
        // Known runs are not repeated.
        let known: Known = found.runs.iter().map(|run| (bits(&run.values), run.clone())).collect();
        let again = question.answer(&known, &AtomicBool::new(false), &|run| panic!("{run:?} again")).unwrap().unwrap();
        assert_eq!(again, found);
        found
    }

    /// Coulomb friction under a sine along the sliding is `2 / pi asin(r)` of Coulomb's at the
    /// velocity ratio r. The largest ratio with at most a third of the friction is one half, at any
    /// coefficient of friction.
    #[test]
    fn an_optimum_at_a_limit_is_that_of_the_closed_form() {
        let over = ["excitation.velocity_ratio=0.05:0.95", "contact.dahl.mu=0.1:0.3"];
        let metrics = ["excitation.velocity_ratio", "friction_ratio"];
        let limits = ["friction_ratio<=0.3333333333333333"];
        let found = answer(&["contact.dahl.stiffness_n_per_m=1e12"], &over, Goal::Maximise, &metrics, &limits);
        assert!(found.is_within_limits && (found.optima[0].values[0] - 0.5).abs() < 1e-4, "{:?}", found.optima);
    }

    /// The input of a Dahl contact has an inner maximum over the velocity ratio, and falls with the
    /// stiffness: a fine grid finds the same.
    #[test]
    fn an_inner_optimum_is_that_of_a_fine_grid() {
        let over = ["excitation.velocity_ratio=0.05:3", "contact.dahl.stiffness_n_per_m=1e5:1e7:log"];
        let found = answer(&[], &over, Goal::Maximise, &["input_ratio"], &[]);
        let loaded = scene::load::load("contact-kinematic", &[]).unwrap();
        let axes = ["excitation.velocity_ratio=0.05:3:400", "contact.dahl.stiffness_n_per_m=1e5:1e7:50:log"];
        let design = Design::product(axes.iter().map(|axis| axis.parse().unwrap()).collect()).unwrap();
        let sweep = Sweep::new(&loaded, design, &["input_ratio".to_owned()]).unwrap();
        let rows = sweep.rows(0..sweep.design.count(), &AtomicBool::new(false), &|| ()).unwrap().unwrap();
        let most = rows.metrics[0].iter().flatten().fold(f64::NEG_INFINITY, |most, &value| most.max(value));
        let best = found.optima[0].metrics[0].unwrap();
        assert!(best > most * (1.0 - 1e-3) && best < most * 1.01, "{:?} {most}", found.optima[0]);
    }

    #[test]
    fn limits_that_no_run_meets_give_the_nearest_run() {
        let found =
            answer(&[], &["excitation.velocity_ratio=0.5:0.95"], Goal::Minimise, &["friction_ratio"], &["friction_ratio<=0.1"]);
        assert!(
            !found.is_within_limits && found.optima.len() == 1 && (found.optima[0].values[0] - 0.5).abs() < 1e-3,
            "{found:?}"
        );
    }

    #[test]
    fn wrong_questions_are_refused() {
        for (text, limit) in
            [("a<=1", Some(true)), ("a >= 2", Some(false)), ("a<1", Some(true)), ("a=1", None), ("<=1", None), ("a<=x", None)]
        {
            assert_eq!(text.parse::<Limit>().ok().map(|limit| limit.is_upper), limit, "{text}");
        }
        let loaded = scene::load::load("lock", &[]).unwrap();
        let refused = |over: &str, metric: &str| {
            let (ranges, metrics) = (vec![over.parse().unwrap()], vec![metric.to_owned()]);
            Question { loaded: &loaded, ranges, metrics, goal: Goal::Minimise, limits: Vec::new(), runs: 100 }
                .check()
                .unwrap_err()
                .to_string()
        };
        assert!(refused("controller.block_samples=16:80", "acquire_time_ms").contains("whole number"));
        assert!(refused("controller.drive.amplitude_v=1:2", "fault_code").contains("not a quantity"));
        assert!(refused("controller.drive.amplitude_v=1:2", "controller.drive.amplitude_v").contains("must be a metric"));
    }
}
