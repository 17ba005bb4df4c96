//! Some metrics of a contact study at many points, which differ in some of its numbers: what the points have in common is made once.
//!
//! ```text
//! point --> numbers of the scene --> a steady sine       --> closed form
//!                                    another problem     --> solved beside the others
//!           (judged by the rules) --> a scene of its text --> run by itself
//! ```

use super::StudyError;
use super::answer::Answer;
use super::contact::{metrics, needs_figures};
use super::plan::{Cell, Plan};
use super::steady::{self, Mean, Steady};
use super::stopped::{leave_if, unless_stopped};
use crate::metrics::Metrics;
use contact::{self, Numerics, Problem};
use scene::numbers::Numbers;
use scene::{Excited, problem};

/// Points that are solved beside each other; so many that those of one setting fill the lanes.
pub(super) const BESIDE: usize = 512;

/// Some metrics of a point, each where it has it; or why there are none.
pub(super) type Measured = Result<Vec<Option<f64>>, StudyError>;

/// Metrics at points of a scene.
pub(super) struct Points<'p, 'a> {
    plan: &'p Plan<'a>,
    metrics: &'p [&'p str],
    /// The same, if all of them are means.
    means: Option<Vec<Mean>>,
    numbers: Option<Numbers>,
}

/// What a point's metrics come of.
enum Found {
    Metrics(Measured),
    Problem(Box<Problem>),
}

impl<'p, 'a> Points<'p, 'a> {
    /// Points that set these keys, the first of which is this cell.
    pub(super) fn new(plan: &'p Plan<'a>, first: Cell, keys: &[&str], metrics: &'p [&'p str]) -> Self {
        let made = plan.make(first).ok();
        // What is held against a measurement needs the moments of a whole run.
        let whole = made.as_ref().and_then(|made| Some(needs_figures(&made.scene.excited()?, Some(metrics)))).unwrap_or(false);
        let numbers = made.filter(|_| !whole).and_then(|made| Numbers::of(made.scene, keys));
        Points { plan, metrics, means: metrics.iter().map(|metric| Mean::named(metric)).collect(), numbers }
    }

    /// The metrics of each of some points, as a run of its cell has them; nothing if they are stopped. `values` are those of the keys, in their
    /// order.
    pub(super) fn metrics<P, V: AsRef<[f64]>>(
        &self,
        points: &[P],
        values: impl Fn(&P) -> V,
        cell: impl Fn(&P) -> Cell,
    ) -> Option<Vec<Measured>> {
        let mut numbers = self.numbers.clone();
        let mut numerics = None;
        let mut found = Vec::with_capacity(points.len());
        for point in points {
            if self.plan.is_stopped() {
                return None;
            }
            let set = numbers.as_mut().and_then(|numbers| numbers.set(values(point).as_ref())?.excited());
            let by_numbers = set.and_then(|scene| self.by_numbers(&scene, numerics.get_or_insert_with(|| self.numerics(&scene))));
            found.push(by_numbers.unwrap_or_else(|| Found::Metrics(self.by_text(cell(point)))));
        }
        let problems: Vec<Problem> = found.iter().filter_map(Found::problem).cloned().collect();
        let solutions =
            numerics.map(|numerics| unless_stopped(|| contact::solve_many(&problems, &numerics, &|| leave_if(self.plan.stop()))));
        let mut solutions = solutions.map_or(Some(Vec::new()), |solved| solved)?.into_iter();
        let mut measured = |(point, found): (&P, Found)| match found {
            Found::Metrics(measured) => measured,
            Found::Problem(problem) => {
                let empty = |error| StudyError::EmptyCell(cell(point).label, Box::new(error));
                let solution = solutions.next().ok_or(StudyError::Incomplete)?.map_err(|error| empty(error.into()))?;
                let answer = Answer { problem: *problem, solution, across: None, in_plane: None };
                let set = numbers.as_mut().and_then(|numbers| numbers.set(values(point).as_ref())?.excited());
                let scene = set.ok_or(StudyError::Incomplete)?;
                Ok(self.read(&metrics::of(&scene, &answer)))
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

    /// What is to be solved; none where that takes the slow way.
    fn by_numbers(&self, scene: &Excited, numerics: &Numerics) -> Option<Found> {
        let problem = problem::problem(scene, problem::law(&scene.model)?).ok()?;
        let means = self.means.as_ref().and_then(|means| Some(of_steady(means, &steady::of_problem(&problem, numerics)?)));
        Some(means.map_or_else(|| Found::Problem(Box::new(problem)), Found::Metrics))
    }

    /// The metrics of a cell that is a scene of its own.
    fn by_text(&self, cell: Cell) -> Measured {
        let made = self.plan.make(cell)?;
        match self.means.as_ref().and_then(|means| Some(of_steady(means, &steady::of(&made.scene.excited()?)?))) {
            Some(measured) => measured,
            None => Ok(self.read(&made.metrics_for(Some(self.metrics))?)),
        }
    }
}

/// Means of a steady sine.
fn of_steady(means: &[Mean], steady: &Steady) -> Measured {
    Ok(means.iter().map(|mean| mean.of(steady)).collect())
}

impl Found {
    fn problem(&self) -> Option<&Problem> {
        match self {
            Found::Problem(problem) => Some(problem),
            _ => None,
        }
    }
}
