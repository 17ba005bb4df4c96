//! Metrics of a contact study at many points that differ in some of its numbers; the common parts
//! are built once.
//!
//! ```text
//! point --> numbers of the scene  --> a steady sine       --> closed form
//!                                     another problem     --> solved in a batch
//!           (special cases of the --> a scene of its text --> run separately
//!            scene's rules)
//! ```

use std::sync::atomic::{AtomicU64, Ordering};

use super::StudyError;
use super::answer::Answer;
use super::contact::{metrics, needs_figures, steady as steady_state};
use super::plan::{Cell, Plan};
use super::steady::{self, Mean, Steady};
use super::stopped::{interrupt_if, unless_stopped};
use crate::metrics::Metrics;
use contact::{self, Method, Numerics, Problem};
use scene::numbers::Numbers;
use scene::{Excited, problem};

/// Number of points solved in a batch, enough for points with equal settings to fill the lanes.
pub(super) const MAX_BATCH: usize = 512;

/// Metrics of a point, each if the point has it, or the reason that there are none.
pub(super) type PointMetrics = Result<Vec<Option<f64>>, StudyError>;

/// Metrics at points of a scene.
pub(super) struct Points<'p, 'a> {
    plan: &'p Plan<'a>,
    metrics: &'p [&'p str],
    /// The metrics as means, if all of them are means.
    means: Option<Vec<Mean>>,
    numbers: Option<Numbers>,
    /// Number of points whose steady state was wanted but not found.
    unsettled: &'p AtomicU64,
}

/// Intermediate result of a point.
enum PointWork {
    Metrics(PointMetrics),
    Problem(Box<Problem>),
}

impl<'p, 'a> Points<'p, 'a> {
    /// Prepares points that set these keys; the first of them is the cell `first`.
    pub(super) fn new(
        plan: &'p Plan<'a>,
        first: Cell,
        (keys, metrics): (&[&str], &'p [&'p str]),
        unsettled: &'p AtomicU64,
    ) -> Self {
        let made = plan.make(first).ok();
        // A comparison with a measurement needs the time series of a whole run.
        let whole = made.as_ref().and_then(|made| Some(needs_figures(&made.scene.excited()?, Some(metrics)))).unwrap_or(false);
        let numbers = made.filter(|_| !whole).and_then(|made| Numbers::of(made.scene, keys));
        Points { plan, metrics, means: metrics.iter().map(|metric| Mean::named(metric)).collect(), numbers, unsettled }
    }

    /// Returns the metrics of each point, equal to those of a run of its cell; `None` if stopped.
    /// `values` are those of the keys, in their order.
    pub(super) fn metrics<P, V: AsRef<[f64]>>(
        &self,
        points: &[P],
        values: impl Fn(&P) -> V,
        cell: impl Fn(&P) -> Cell,
    ) -> Option<Vec<PointMetrics>> {
        let mut numbers = self.numbers.clone();
        let mut numerics = None;
        let mut found = Vec::with_capacity(points.len());
        for point in points {
            if self.plan.is_stopped() {
                return None;
            }
            let set = numbers.as_mut().and_then(|numbers| numbers.set(values(point).as_ref())?.excited());
            let by_numbers = set.and_then(|scene| self.by_numbers(&scene, numerics.get_or_insert_with(|| self.numerics(&scene))));
            found.push(by_numbers.unwrap_or_else(|| PointWork::Metrics(self.by_text(cell(point)))));
        }
        let problems: Vec<Problem> = found.iter().filter_map(PointWork::problem).cloned().collect();
        let solutions = numerics
            .map(|numerics| unless_stopped(|| contact::solve_many(&problems, &numerics, &|| interrupt_if(self.plan.stop()))));
        let mut solutions = solutions.map_or(Some(Vec::new()), |solved| solved)?.into_iter();
        let mut measured = |(point, found): (&P, PointWork)| match found {
            PointWork::Metrics(measured) => measured,
            PointWork::Problem(problem) => {
                let empty = |error| StudyError::EmptyCell(cell(point).label, Box::new(error));
                let solution = solutions.next().ok_or(StudyError::Incomplete)?.map_err(|error| empty(error.into()))?;
                let wanted = Some(self.metrics);
                let pause = || interrupt_if(self.plan.stop());
                let steady =
                    numerics.and_then(|numerics| unless_stopped(|| steady_state(&problem, &numerics, &solution, wanted, &pause)));
                let steady = steady.flatten();
                // A closed form is that of the steady state.
                let is_open = solution.orbit.is_none() && solution.method != Method::Closed;
                if numerics.is_some_and(|numerics| numerics.steady) && is_open {
                    self.unsettled.fetch_add(1, Ordering::Relaxed);
                }
                let answer = Answer { problem: *problem, solution, steady, across: None, in_plane: None };
                let set = numbers.as_mut().and_then(|numbers| numbers.set(values(point).as_ref())?.excited());
                let scene = set.ok_or(StudyError::Incomplete)?;
                Ok(self.read(&metrics::measure(&scene, &answer)))
            }
        };
        Some(points.iter().zip(found).map(&mut measured).collect())
    }

    fn read(&self, metrics: &Metrics) -> Vec<Option<f64>> {
        self.metrics.iter().map(|name| metrics.find(name)).collect()
    }

    fn numerics(&self, scene: &Excited) -> Numerics {
        problem::numerics(scene, Some(self.metrics))
    }

    /// Returns the closed-form metrics, or the problem to be solved; `None` if the point needs its
    /// text.
    fn by_numbers(&self, scene: &Excited, numerics: &Numerics) -> Option<PointWork> {
        let problem = problem::problem(scene, problem::law(&scene.model)?).ok()?;
        let means = self.means.as_ref().and_then(|means| Some(of_steady(means, &steady::from_problem(&problem, numerics)?)));
        Some(means.map_or_else(|| PointWork::Problem(Box::new(problem)), PointWork::Metrics))
    }

    /// Computes the metrics of a cell from the text of its scene.
    fn by_text(&self, cell: Cell) -> PointMetrics {
        let made = self.plan.make(cell)?;
        match self.means.as_ref().and_then(|means| Some(of_steady(means, &steady::from_scene(&made.scene.excited()?)?))) {
            Some(measured) => measured,
            None => Ok(self.read(&made.metrics_for(Some(self.metrics))?)),
        }
    }
}

/// Returns the means of a steady sine.
fn of_steady(means: &[Mean], steady: &Steady) -> PointMetrics {
    Ok(means.iter().map(|mean| mean.value(steady)).collect())
}

impl PointWork {
    fn problem(&self) -> Option<&Problem> {
        match self {
            PointWork::Problem(problem) => Some(problem),
            _ => None,
        }
    }
}
