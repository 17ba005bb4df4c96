//! Values of a key at which a metric reaches a target: the inverse of a sweep.
//!
//! ```text
//! range --> samples, in parallel --> neighbours with the target between them --> root of each (T. R. Chandrupatla 1997)
//! ```
//!
//! The metric need not be monotonic: each pair of neighbouring samples with the target between them
//! is searched, which finds every root that lies more than an interval from the next one. A metric
//! that jumps across the target has no root there, and is reported with the values on both sides.

use std::sync::atomic::{AtomicBool, Ordering};

use super::StudyError;
use super::sweep::axis::{Axis, Range};
use super::sweep::design::Design;
use super::sweep::{Rows, Sweep, SweepError};
use scene::load::Loaded;

/// Number of samples of the range.
const SAMPLES: u64 = 33;
/// Largest width of the interval of a root, relative to the root.
const ROOT_WIDTH_REL: f64 = 1e-9;
/// Largest number of runs for a root.
const MOST_RUNS: u32 = 60;
/// Difference of the metric across the last interval, relative to that of the samples around it,
/// above which the metric jumps.
const JUMP_REL: f64 = 0.1;

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

/// Value of the key at which the metric crosses the target.
#[derive(Clone, Debug, PartialEq)]
pub struct Root {
    /// Value of the key.
    pub value: f64,
    /// Ends of the interval that contains the root.
    pub within: (f64, f64),
    /// Metrics at the value.
    pub metrics: Vec<Option<f64>>,
    /// The metric at both ends of the interval, if it jumps across the target there.
    pub jump: Option<(f64, f64)>,
    /// Number of runs after the samples.
    pub runs: u32,
}

/// Answer to a question.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Roots, in ascending order.
    pub roots: Vec<Root>,
    /// Samples of the range: the value of the key and, if the run has it, the metric.
    pub samples: Vec<(f64, Option<f64>)>,
    /// Reasons that samples have no value, without repetitions.
    pub failures: Vec<String>,
}

impl Question<'_> {
    /// Answers the question; `None` if stopped. `done` is called after each run.
    ///
    /// # Errors
    /// If the key or a metric is not one of the scene, or a run cannot be made.
    pub fn answer(&self, stop: &AtomicBool, done: &(dyn Fn() + Sync)) -> Result<Option<Answer>, SolveError> {
        let sampled = Axis::of_range(&self.range, SAMPLES);
        let Some(rows) = self.run(sampled, stop, done)? else { return Ok(None) };
        let samples: Vec<_> = rows.keys[0].iter().enumerate().map(|(row, &at)| (at, value(&rows, row))).collect();
        let mut failures: Vec<String> = (0..samples.len()).filter_map(|row| reason(&rows, row)).collect();
        failures.sort();
        failures.dedup();
        let mut roots = Vec::new();
        for pair in samples.windows(2) {
            let [(low, Some(at_low)), (high, Some(at_high))] = *pair else { continue };
            let (below, above) = (at_low - self.target, at_high - self.target);
            // A sample on the target belongs to the interval below it.
            if above == 0.0 || below * above < 0.0 || (below == 0.0 && roots.is_empty()) {
                match self.refine((low, below), (high, above), stop, done)? {
                    Refined::Stopped => return Ok(None),
                    Refined::Root(root) => roots.push(root),
                    Refined::Failed(why) if failures.contains(&why) => {}
                    Refined::Failed(why) => failures.push(why),
                }
            }
        }
        Ok(Some(Answer { roots, samples, failures }))
    }

    /// Finds the root between two values of the key, with the metric's distance from the target.
    fn refine(
        &self,
        low: (f64, f64),
        high: (f64, f64),
        stop: &AtomicBool,
        done: &(dyn Fn() + Sync),
    ) -> Result<Refined, SolveError> {
        let mut search = Search::new(low, high);
        let mut runs = 0;
        while let Some(next) = search.next().filter(|_| runs < MOST_RUNS) {
            let Some(rows) = self.run(Axis::of_value(&self.range.key, next), stop, done)? else { return Ok(Refined::Stopped) };
            runs += 1;
            match value(&rows, 0) {
                Some(found) => search.take(next, found - self.target),
                None => return Ok(Refined::Failed(reason(&rows, 0).unwrap_or_default())),
            }
        }
        let Some(rows) = self.run(Axis::of_value(&self.range.key, search.best().0), stop, done)? else {
            return Ok(Refined::Stopped);
        };
        let (from, to) = search.interval();
        let jumps = (to.1 - from.1).abs() > JUMP_REL * (high.1 - low.1).abs() && search.best().1 != 0.0;
        Ok(Refined::Root(Root {
            value: search.best().0,
            within: (from.0, to.0),
            metrics: rows.metrics.iter().map(|metric| metric[0]).collect(),
            jump: jumps.then_some((from.1 + self.target, to.1 + self.target)),
            runs,
        }))
    }

    /// Runs the scene with these values of the key.
    fn run(&self, axis: Axis, stop: &AtomicBool, done: &(dyn Fn() + Sync)) -> Result<Option<Rows>, SolveError> {
        let sweep = Sweep::new(self.loaded, Design::product(vec![axis])?, &self.metrics)?;
        let rows = sweep.rows(0..sweep.design.count(), stop, done)?;
        Ok(rows.filter(|_| !stop.load(Ordering::Relaxed)))
    }
}

/// Result of a search.
enum Refined {
    Root(Root),
    /// A run of the search has no value, for this reason.
    Failed(String),
    Stopped,
}

/// Returns the first metric of a row; `None` if the run has none, or ended in a fault.
fn value(rows: &Rows, row: usize) -> Option<f64> {
    rows.metrics[0][row].filter(|value| value.is_finite() && rows.fault_codes[row].unwrap_or(0) == 0)
}

/// Returns the reason that a row has no value.
fn reason(rows: &Rows, row: usize) -> Option<String> {
    if value(rows, row).is_some() {
        return None;
    }
    let fault = rows.fault_codes[row].filter(|code| *code != 0).map(|code| format!("ends in fault {code}"));
    Some(fault.or_else(|| rows.failures[row].clone()).unwrap_or_else(|| "does not have the metric".to_owned()))
}

/// Search for a root between two points of different signs: inverse quadratic interpolation where
/// three points allow it, else bisection (T. R. Chandrupatla, Adv. Eng. Software 28 (1997) 145).
struct Search {
    last: (f64, f64),
    /// End on the other side of the root.
    other: (f64, f64),
    /// Place of the next point between `last` (0) and `other` (1).
    part: f64,
    least_width: f64,
}

impl Search {
    fn new(low: (f64, f64), high: (f64, f64)) -> Self {
        Search { last: high, other: low, part: 0.5, least_width: ROOT_WIDTH_REL * low.0.abs().max(high.0.abs()) }
    }

    /// Returns the next point; `None` at the end.
    fn next(&self) -> Option<f64> {
        let width = self.other.0 - self.last.0;
        let least = 0.5 * self.least_width / width.abs();
        (self.best().1 != 0.0 && least < 0.5).then(|| self.last.0 + self.part.clamp(least, 1.0 - least) * width)
    }

    /// Takes the value at the next point.
    fn take(&mut self, at: f64, value: f64) {
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
    fn best(&self) -> (f64, f64) {
        if self.last.1.abs() < self.other.1.abs() { self.last } else { self.other }
    }

    /// Returns both ends in ascending order.
    fn interval(&self) -> ((f64, f64), (f64, f64)) {
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
        assert!((root.value - 0.5).abs() < 1e-5 && root.jump.is_none() && root.runs <= 20, "{root:?}");
    }

    #[test]
    fn no_root_and_a_root_at_an_end_are_told_apart() {
        let none = answer("contact-kinematic", "excitation.velocity_ratio=0.1:0.9", "friction_ratio", 2.0);
        assert!(none.roots.is_empty() && none.samples.len() == SAMPLES as usize && none.failures.is_empty());
        let at = none.samples[0].1.unwrap();
        let first = answer("contact-kinematic", "excitation.velocity_ratio=0.1:0.9", "friction_ratio", at);
        assert!(first.roots.len() == 1 && first.roots[0].value == 0.1, "{:?}", first.roots);
    }
}
