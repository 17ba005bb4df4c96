//! Values of a key at which a metric reaches a target: the inverse of a sweep.
//!
//! ```text
//! range --> samples, in parallel --> neighbours with the target between them --> root of each (T. R. Chandrupatla 1997)
//! ```
//!
//! The metric need not be monotonic: each pair of neighbouring samples with the target between them
//! is searched, which finds every crossing that lies more than an interval from the next one. A
//! metric with steps, or with the scatter of a noisy run, may cross the target without reaching it:
//! the last values on both sides are then reported instead of a root.

use std::sync::atomic::{AtomicBool, Ordering};

use super::StudyError;
use super::sweep::axis::{Axis, Range};
use super::sweep::design::Design;
use super::sweep::{Rows, Sweep, SweepError};
use scene::load::Loaded;
use scene::schema::{Kind, Schema};
use serde_json::{Map, Value, json};

/// Number of samples of the range.
pub const SAMPLES: u64 = 33;
/// Largest width of the interval of a root, relative to the root.
const ROOT_WIDTH_REL: f64 = 1e-9;
/// Largest number of runs for a root.
const MOST_RUNS: u32 = 60;
/// Largest distance of the metric from the target at a root, relative to the larger of the samples
/// around it.
pub const REACHED_REL: f64 = 1e-4;
/// Metric that is not a quantity.
const FAULT_CODE: &str = "fault_code";

/// Reason that there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum SolveError {
    /// The key, its range or a metric is not one of the scene.
    #[error(transparent)]
    Question(#[from] SweepError),
    /// A run cannot be made.
    #[error(transparent)]
    Run(#[from] StudyError),
}

/// Question: where does a metric have a value?
#[derive(Clone, Debug)]
pub struct Question<'a> {
    /// The scene that is changed.
    pub loaded: &'a Loaded,
    /// Key and its range.
    pub range: Range,
    /// Metric, and further ones that are reported at each root.
    pub metrics: Vec<String>,
    /// Wanted value of the first metric.
    pub target: f64,
}

/// Value of the key at which the metric has the target.
#[derive(Clone, Debug, PartialEq)]
pub struct Root {
    /// Value of the key; for a metric that keeps the target over several samples, the first of
    /// them.
    pub value: f64,
    /// Ends of the interval that contains the root, or over which the metric keeps the target.
    pub within: (f64, f64),
    /// Metrics at the value.
    pub metrics: Vec<Option<f64>>,
    /// Number of runs after the samples.
    pub runs: u32,
}

/// Crossing of the target that the metric does not reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// Ends of the last interval.
    pub within: (f64, f64),
    /// Metric at both ends.
    pub metric: (f64, f64),
}

/// Answer to a question.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// Roots, in ascending order.
    pub roots: Vec<Root>,
    /// Crossings by a step or by scatter, in ascending order.
    pub crossings: Vec<Crossing>,
    /// Samples of the range: the value of the key and, if the run has it, the metric.
    pub samples: Vec<(f64, Option<f64>)>,
    /// Values of the key at which a run has no metric, with the reason.
    pub failures: Vec<(f64, String)>,
    /// Number of runs whose means are over a window, because no steady state was found.
    pub unsettled: u64,
}

impl Answer {
    /// Returns the answer as JSON.
    pub fn json(&self, question: &Question) -> Value {
        let of = |root: &Root| {
            let metrics = question.metrics.iter().zip(&root.metrics).map(|(name, value)| (name.clone(), json!(value)));
            let metrics: Map<_, _> = metrics.collect();
            json!({ "value": root.value, "within": [root.within.0, root.within.1], "metrics": metrics, "runs": root.runs })
        };
        let crossing = |of: &Crossing| json!({ "within": [of.within.0, of.within.1], "metric": [of.metric.0, of.metric.1] });
        json!({
            "scene": question.loaded.name,
            "key": question.range.key,
            "metric": question.metrics[0],
            "target": question.target,
            "roots": self.roots.iter().map(of).collect::<Vec<_>>(),
            "crossings": self.crossings.iter().map(crossing).collect::<Vec<_>>(),
            "samples": self.samples,
            "failures": self.failures,
            "unsettled": self.unsettled,
            "assumed": question.loaded.assumed_with(&[&question.range.key]),
        })
    }
}

impl Question<'_> {
    /// Answers the question; `None` if stopped. `done` is called after each run.
    ///
    /// # Errors
    /// If the key or a metric is not one of the scene, or a run cannot be made.
    pub fn answer(&self, stop: &AtomicBool, done: &(dyn Fn() + Sync)) -> Result<Option<Answer>, SolveError> {
        let key = &self.range.key;
        if Schema::root().at(key).is_some_and(|schema| schema.kind() == Kind::Integer) {
            let why = "is a whole number: `sim-host sweep --over` runs all of its values".to_owned();
            return Err(SweepError::Key { key: key.clone(), why }.into());
        }
        if self.metrics.iter().any(|metric| metric == FAULT_CODE) {
            return Err(SweepError::Metric(format!("`{FAULT_CODE}` is not a quantity: `sim-host sweep` shows it")).into());
        }
        let mut answer = Answer::default();
        let Some(rows) = self.run(Axis::of_range(&self.range, SAMPLES), &mut answer, stop, done)? else { return Ok(None) };
        let value = |row: usize| self.value(&rows, row).ok();
        answer.samples = rows.keys[0].iter().enumerate().map(|(row, &at)| (at, value(row))).collect();
        let failed = |row: usize| Some((rows.keys[0][row], self.value(&rows, row).err()?));
        answer.failures = (0..answer.samples.len()).filter_map(failed).collect();
        let samples = answer.samples.clone();
        let off = |row: usize| samples.get(row).and_then(|(_, value)| Some((*value)? - self.target));
        let mut row = 0;
        while row < samples.len() {
            let next = (row + 1..samples.len()).find(|next| off(*next) != Some(0.0)).unwrap_or(samples.len());
            if off(row) == Some(0.0) {
                let metrics = rows.metrics.iter().map(|metric| metric[row]).collect();
                answer.roots.push(Root {
                    value: samples[row].0,
                    within: (samples[row].0, samples[next - 1].0),
                    metrics,
                    runs: 0,
                });
                row = next;
                continue;
            }
            if let (Some(low), Some(high)) = (off(row), off(row + 1))
                && low * high < 0.0
                && !self.refine((samples[row].0, low), (samples[row + 1].0, high), &mut answer, stop, done)?
            {
                return Ok(None);
            }
            row += 1;
        }
        Ok(Some(answer))
    }

    /// Adds the root between two values of the key, with the metric's distance from the target, to
    /// the answer. Returns `false` if stopped.
    fn refine(
        &self,
        low: (f64, f64),
        high: (f64, f64),
        answer: &mut Answer,
        stop: &AtomicBool,
        done: &(dyn Fn() + Sync),
    ) -> Result<bool, SolveError> {
        let mut search = Search::new(low, high);
        let mut runs = 0;
        while let Some(next) = search.next().filter(|_| runs < MOST_RUNS) {
            let found = match self.run(Axis::of_value(&self.range.key, next), answer, stop, done) {
                Ok(Some(rows)) => self.value(&rows, 0),
                Ok(None) => return Ok(false),
                Err(SolveError::Question(error)) => Err(error.to_string()),
                Err(error) => return Err(error),
            };
            runs += 1;
            match found {
                Ok(found) => search.take(next, found - self.target),
                Err(why) => {
                    answer.failures.push((next, why));
                    return Ok(true);
                }
            }
        }
        let (best, (from, to)) = (search.best(), search.interval());
        if best.1.abs() > REACHED_REL * (low.1 + self.target).abs().max((high.1 + self.target).abs()) {
            answer.crossings.push(Crossing { within: (from.0, to.0), metric: (from.1 + self.target, to.1 + self.target) });
            return Ok(true);
        }
        let Some(rows) = self.run(Axis::of_value(&self.range.key, best.0), answer, stop, done)? else { return Ok(false) };
        let metrics = rows.metrics.iter().map(|metric| metric[0]).collect();
        answer.roots.push(Root { value: best.0, within: (from.0, to.0), metrics, runs });
        Ok(true)
    }

    /// Runs the scene with these values of the key; `None` if stopped.
    fn run(
        &self,
        axis: Axis,
        answer: &mut Answer,
        stop: &AtomicBool,
        done: &(dyn Fn() + Sync),
    ) -> Result<Option<Rows>, SolveError> {
        let sweep = Sweep::new(self.loaded, Design::product(vec![axis])?, &self.metrics)?;
        let rows = sweep.rows(0..sweep.design.count(), stop, done)?;
        answer.unsettled += sweep.unsettled();
        Ok(rows.filter(|_| !stop.load(Ordering::Relaxed)))
    }

    /// Returns the first metric of a row, or the reason that it has none. A run that ended in a
    /// fault has none.
    fn value(&self, rows: &Rows, row: usize) -> Result<f64, String> {
        match rows.fault_codes[row].filter(|code| *code != 0 && self.loaded.scene.runs == 1) {
            Some(code) => Err(format!("the run ends in fault {code}")),
            None => rows.metrics[0][row].filter(|value| value.is_finite()).ok_or_else(|| {
                rows.failures[row].clone().unwrap_or_else(|| format!("the run has no metric `{}`", self.metrics[0]))
            }),
        }
    }
}

/// Search for a root between two points of different signs: inverse quadratic interpolation where
/// three points allow it, else bisection (T. R. Chandrupatla, Adv. Eng. Software 28 (1997) 145).
pub struct Search {
    last: (f64, f64),
    /// End on the other side of the root.
    other: (f64, f64),
    /// Place of the next point between `last` (0) and `other` (1).
    part: f64,
    least_width: f64,
}

impl Search {
    /// Creates a search between two points of different signs.
    pub fn new(low: (f64, f64), high: (f64, f64)) -> Self {
        Search { last: high, other: low, part: 0.5, least_width: ROOT_WIDTH_REL * low.0.abs().max(high.0.abs()) }
    }

    /// Returns the next point; `None` at the end.
    pub fn next(&self) -> Option<f64> {
        let width = self.other.0 - self.last.0;
        let least = 0.5 * self.least_width / width.abs();
        (self.best().1 != 0.0 && least < 0.5).then(|| self.last.0 + self.part.clamp(least, 1.0 - least) * width)
    }

    /// Takes the value at the next point.
    pub fn take(&mut self, at: f64, value: f64) {
        let third = if (value < 0.0) == (self.last.1 < 0.0) { self.last } else { core::mem::replace(&mut self.other, self.last) };
        self.last = (at, value);
        let ((x1, f1), (x2, f2), (x3, f3)) = (self.last, self.other, third);
        let (xi, phi) = ((x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2));
        self.part = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        } else {
            0.5
        };
    }

    /// Returns the end that is nearer to the target.
    pub fn best(&self) -> (f64, f64) {
        if self.last.1.abs() < self.other.1.abs() { self.last } else { self.other }
    }

    /// Returns both ends in ascending order.
    pub fn interval(&self) -> ((f64, f64), (f64, f64)) {
        if self.last.0 < self.other.0 { (self.last, self.other) } else { (self.other, self.last) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root(low: f64, high: f64, of: impl Fn(f64) -> f64) -> (f64, u32) {
        let mut search = Search::new((low, of(low)), (high, of(high)));
        let mut runs = 0;
        while let Some(next) = search.next() {
            search.take(next, of(next));
            runs += 1;
        }
        (search.best().0, runs)
    }

    /// Roots that are known in closed form, from easy ones to one of high order.
    #[test]
    fn roots_are_found_in_few_runs() {
        for (found, expected, most) in [
            (root(0.0, 1.0, |x| x * x - 0.3), 0.3f64.sqrt(), 9),
            (root(1.0, 2.0, |x| (x - 1.0).exp() - 2.0), 1.0 + 2f64.ln(), 9),
            (root(1e-7, 1e-5, |x| (x / 3e-6).ln()), 3e-6, 12),
            (root(0.0, 2.0, |x| (x - 1.2).powi(9)), 1.2, 60),
            (root(-1.0, 3.0, |x| if x < 0.123 { -1.0 } else { 2.0 }), 0.123, 40),
        ] {
            let (value, runs) = found;
            let tolerance = if most == 60 { 1e-2 } else { 1e-8 };
            assert!((value / expected - 1.0).abs() < tolerance && runs <= most, "{value} for {expected}, {runs} runs");
        }
    }

    fn answer(scene: &str, by: &str, metric: &str, target: f64) -> Answer {
        let loaded = scene::load::load(scene, &[]).unwrap();
        let question = Question { loaded: &loaded, range: by.parse().unwrap(), metrics: vec![metric.to_owned()], target };
        question.answer(&AtomicBool::new(false), &|| ()).unwrap().unwrap()
    }

    /// The closed form of Coulomb friction with a sine along the sliding: the mean force is
    /// `2 / pi asin(V / Vv)` of Coulomb's, so that a third is left at a velocity ratio of one half.
    #[test]
    fn the_velocity_ratio_for_a_third_is_one_half() {
        let stiff = ["contact.dahl.stiffness_n_per_m=1e12".to_owned()];
        let loaded = scene::load::load("contact-kinematic", &stiff).unwrap();
        let range = "excitation.velocity_ratio=0.05:0.95".parse().unwrap();
        let question = Question { loaded: &loaded, range, metrics: vec!["friction_ratio".to_owned()], target: 1.0 / 3.0 };
        let found = question.answer(&AtomicBool::new(false), &|| ()).unwrap().unwrap();
        let [root] = &found.roots[..] else { panic!("{found:?}") };
        assert!((root.value - 0.5).abs() < 1e-5 && root.runs <= 20 && found.crossings.is_empty(), "{root:?}");
    }

    #[test]
    fn no_root_and_a_root_at_an_end_are_told_apart() {
        let none = answer("contact-kinematic", "excitation.velocity_ratio=0.1:0.9", "friction_ratio", 2.0);
        assert!(none.roots.is_empty() && none.samples.len() == SAMPLES as usize && none.failures.is_empty());
        let at = none.samples[0].1.unwrap();
        let first = answer("contact-kinematic", "excitation.velocity_ratio=0.1:0.9", "friction_ratio", at);
        assert!(first.roots.len() == 1 && first.roots[0].within == (0.1, 0.1), "{:?}", first.roots);
    }

    /// Faster sliding than the vibration leaves all of the friction.
    #[test]
    fn a_value_that_is_kept_is_one_root() {
        let found = answer("contact-kinematic", "excitation.velocity_ratio=0.5:2", "friction_ratio", 1.0);
        let [root] = &found.roots[..] else { panic!("{found:?}") };
        assert!((root.within.0 - 1.0).abs() < 0.05 && root.within.1 == 2.0 && found.crossings.is_empty(), "{root:?}");
    }

    /// The slip reverses twice a period, or not at all.
    #[test]
    fn a_step_is_no_root() {
        let found = answer("contact", "excitation.velocity_ratio=0.5:2", "reversals", 1.0);
        assert!(found.roots.is_empty() && found.crossings.len() == 1, "{:?} {:?}", found.roots, found.crossings);
        let Crossing { within, metric } = found.crossings[0];
        assert!(within.1 - within.0 < 1e-8 && metric == (2.0, 0.0), "{within:?} {metric:?}");
    }

    #[test]
    fn whole_numbers_and_faults_are_refused() {
        let loaded = scene::load::load("lock", &[]).unwrap();
        let asked = |by: &str, metric: &str| {
            let question =
                Question { loaded: &loaded, range: by.parse().unwrap(), metrics: vec![metric.to_owned()], target: 1.0 };
            question.answer(&AtomicBool::new(false), &|| ()).unwrap_err().to_string()
        };
        assert!(asked("controller.block_samples=16:80", "acquire_time_ms").contains("whole number"));
        assert!(asked("controller.drive.amplitude_v=1:2", "fault_code").contains("not a quantity"));
    }
}
