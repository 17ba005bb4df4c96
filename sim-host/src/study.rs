//! A study: a scene, run; its metrics held against what was expected; and its grid, if it has one.

pub mod contact;
pub mod driven;
pub mod film;
mod stopped;

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use self::contact::Solved;
use self::driven::Run;
use crate::contact::Trouble;
use crate::metrics::Metrics;
use crate::processor::Processor;
use crate::run::RunError;
use crate::scene::load::{LoadError, Loaded};
use crate::scene::{Expect, Grid, Kind, Scene, shown};

/// Why a study has no result.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The scene was not loaded, and lacks what loading would have asked for.
    #[error("the scene is neither a driven one nor a contact study")]
    Incomplete,
    /// The scene of a grid's cell is invalid.
    #[error("the grid's cell {0} is not a valid scene")]
    Cell(String, #[source] LoadError),
    /// A grid's cell has no result.
    #[error("the grid's cell {0} has no result")]
    EmptyCell(String, #[source] Box<StudyError>),
    /// The run did not happen.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The contact study has no answer.
    #[error("the contact study has no answer")]
    Contact(#[from] Trouble),
}

/// The result of a study.
#[derive(Clone, Debug)]
pub struct Study<'a> {
    /// Name of the scene.
    pub name: String,
    /// What was changed by hand, as `key=value`.
    pub changes: Vec<String>,
    /// The scene as it was run.
    pub scene: &'a Scene,
    /// What came of it.
    pub outcome: Outcome<'a>,
    /// The numbers.
    pub metrics: Metrics,
    /// The expectations, judged.
    pub judged: Vec<Judged>,
    /// The grid, run.
    pub grid: Option<GridResult>,
    /// Whether it was stopped before its end.
    pub interrupted: bool,
}

/// What came of a scene, by its kind.
#[derive(Clone, Debug)]
pub enum Outcome<'a> {
    /// The firmware drove.
    Driven(Box<Run<'a>>),
    /// A contact was studied by itself.
    Contact(Box<Solved<'a>>),
}

/// An expectation and how it came out.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// The metric.
    pub metric: String,
    /// Its value, if the run has one.
    pub value: Option<f64>,
    /// The limit, as text.
    pub limit: String,
    /// How far from a value it may be, if that is the limit.
    pub tolerance: Option<f64>,
    /// Whether it holds. A metric that the run does not have holds nothing.
    pub pass: bool,
    /// Where the limit comes from.
    pub source: String,
}

/// A metric over two keys.
#[derive(Clone, Debug, PartialEq)]
pub struct GridResult {
    /// The grid asked for.
    pub grid: Grid,
    /// For each row, the metric in each column.
    pub cells: Vec<Vec<Option<f64>>>,
}

impl Study<'_> {
    /// Whether every expectation holds.
    pub fn passes(&self) -> bool {
        self.judged.iter().all(|judged| judged.pass)
    }

    /// The driven run, if it was one.
    pub fn run(&self) -> Option<&Run<'_>> {
        match &self.outcome {
            Outcome::Driven(run) => Some(run),
            Outcome::Contact(_) => None,
        }
    }
}

/// Runs a loaded scene and its grid. The controller of the scene itself runs on `emulator`, or without one in this process; those of
/// the grid, always in this process.
pub fn conduct<'a, 'w>(
    loaded: &'a Loaded,
    emulator: Option<&mut dyn Processor>,
    stop: &'w AtomicBool,
    progress: Option<&'w mut dyn FnMut(f64)>,
) -> Result<Study<'a>, StudyError> {
    let scene = &loaded.scene;
    let (outcome, metrics, cut) = match scene.kind().ok_or(StudyError::Incomplete)? {
        Kind::Driven(scene) => {
            let (run, metrics) = driven::conduct(scene, emulator, stop, progress)?;
            let cut = run.record.interrupted;
            (Outcome::Driven(Box::new(run)), metrics, cut)
        }
        Kind::Excited(scene) => {
            let (solved, metrics) = contact::conduct(scene, stop, progress)?;
            let cut = solved.answer.is_none();
            (Outcome::Contact(Box::new(solved)), metrics, cut)
        }
    };
    let judged = scene.expect.iter().map(|expect| judge(expect, &metrics)).collect();
    let grid = match &scene.grid {
        Some(grid) if !cut => cells(loaded, grid, stop)?,
        _ => None,
    };
    // Stopped within the grid: the scene is whole, and the grid is missing.
    let interrupted = cut || stop.load(Ordering::Relaxed);
    Ok(Study { name: loaded.name.clone(), changes: loaded.sets.clone(), scene, outcome, metrics, judged, grid, interrupted })
}

fn judge(expect: &Expect, metrics: &Metrics) -> Judged {
    let (mut min, mut max) = (expect.min, expect.max);
    let limit = match (expect.value, expect.tolerance) {
        (Some(value), Some(tolerance)) => {
            (min, max) = (Some(value - tolerance), Some(value + tolerance));
            format!("{} ± {}", shown(value), shown(tolerance))
        }
        _ => match (min, max) {
            (Some(min), Some(max)) => format!("{} to {}", shown(min), shown(max)),
            (Some(min), None) => format!("at least {}", shown(min)),
            (None, Some(max)) => format!("at most {}", shown(max)),
            (None, None) => "anything".into(),
        },
    };
    let value = metrics.get(&expect.metric);
    let holds = |value: f64| min.is_none_or(|min| value >= min) && max.is_none_or(|max| value <= max);
    Judged {
        metric: expect.metric.clone(),
        value,
        limit,
        tolerance: expect.tolerance,
        pass: value.is_some_and(holds),
        source: expect.source.clone(),
    }
}

/// Runs every cell of a grid, in parallel; nothing if it is stopped. Each is a scene of its own, seeded as the scene is, so that the
/// result does not depend on the number of threads.
fn cells(loaded: &Loaded, grid: &Grid, stop: &AtomicBool) -> Result<Option<GridResult>, StudyError> {
    let places: Vec<(f64, f64)> =
        grid.rows.iter().flat_map(|&row| grid.columns.iter().map(move |&column| (row, column))).collect();
    let run_cell = |&(row, column): &(f64, f64)| {
        let place = [format!("{}={row}", grid.row_key), format!("{}={column}", grid.column_key)];
        let sets = [grid.set.as_slice(), &place].concat();
        let cell = loaded.with(&sets).map_err(|error| StudyError::Cell(place.join(", "), error))?;
        let metrics = match cell.scene.kind().ok_or(StudyError::Incomplete)? {
            Kind::Driven(scene) => driven::cell(&scene, stop),
            Kind::Excited(scene) => contact::cell(&scene, stop),
        };
        let metrics = metrics.map_err(|error| StudyError::EmptyCell(place.join(", "), Box::new(error)))?;
        Ok(metrics.get(&grid.metric))
    };
    let values = places.par_iter().map(run_cell).collect::<Result<Vec<_>, StudyError>>()?;
    let cells = values.chunks(grid.columns.len()).map(<[_]>::to_vec).collect();
    Ok((!stop.load(Ordering::Relaxed)).then(|| GridResult { grid: grid.clone(), cells }))
}
