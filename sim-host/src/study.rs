//! A study: a scene, run; its metrics held against what was expected; and its grid, if it has one.

use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use crate::metrics::{self, Metrics};
use crate::plant::circuit::Circuit;
use crate::processor::Processor;
use crate::record::{Record, Window};
use crate::run::{self, RunError, Watch};
use crate::scene::load::{LoadError, Loaded};
use crate::scene::{Expect, Grid, Scene};

/// Why a study has no result.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The scene of a grid's cell is invalid.
    #[error("the grid's cell {0} is not a valid scene")]
    Cell(String, #[source] LoadError),
    /// The run did not happen.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// The result of a study.
#[derive(Clone, Debug)]
pub struct Study {
    /// Name of the scene.
    pub name: String,
    /// The scene as it was run.
    pub scene: Scene,
    /// What was recorded.
    pub record: Record,
    /// The numbers.
    pub metrics: Metrics,
    /// The expectations, judged.
    pub judged: Vec<Judged>,
    /// The grid, run.
    pub grid: Option<GridResult>,
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

impl Study {
    /// Whether every expectation holds.
    pub fn passes(&self) -> bool {
        self.judged.iter().all(|judged| judged.pass)
    }
}

/// Runs a loaded scene with the controller on `processor`, and its grid with the controller in this process.
pub fn conduct<'a>(
    loaded: &Loaded,
    processor: &mut dyn Processor,
    stop: &'a AtomicBool,
    progress: Option<&'a mut dyn FnMut(f64)>,
) -> Result<Study, StudyError> {
    let scene = &loaded.scene;
    let watch = Watch { windows: edge_windows(scene), stop: Some(stop), progress };
    let record = run::run_on(processor, scene, watch)?;
    let metrics = metrics::of(scene, &record);
    let judged = scene.expect.iter().map(|expect| judge(expect, &metrics)).collect();
    let grid = scene.grid.as_ref().filter(|_| !record.interrupted).map(|grid| cells(loaded, grid)).transpose()?;
    Ok(Study { name: loaded.name.clone(), scene: scene.clone(), record, metrics, judged, grid })
}

/// The first ON edge and the first OFF edge, sample by sample: a little before, and five time constants after.
fn edge_windows(scene: &Scene) -> Vec<Window> {
    let after_s = 5.0 * Circuit::of(&scene.stack.bvd).time_constant_s();
    let Some(burst) = &scene.controller.burst else { return Vec::new() };
    let first = |title: &str, at_s: Option<f64>| {
        let at_s = at_s.filter(|&at_s| at_s < scene.duration_s)?;
        Some(Window {
            title: title.into(),
            edge_s: at_s,
            from_s: at_s - 0.2 * after_s,
            to_s: at_s + after_s,
            ..Window::default()
        })
    };
    let periodic = || Some((burst.period_s?, burst.period_s? * burst.duty?));
    let (on, off) = (burst.on_s.first().copied(), burst.off_s.first().copied());
    // A periodic burst begins before there is a lock; its last period is as good as any.
    let last_period = || periodic().map(|(period, on)| ((scene.duration_s / period - 1.0).floor() * period, on));
    let on = on.or_else(|| last_period().map(|(start, _)| start));
    let off = off.or_else(|| last_period().map(|(start, length)| start + length));
    [first("on", on), first("off", off)].into_iter().flatten().collect()
}

fn judge(expect: &Expect, metrics: &Metrics) -> Judged {
    let (mut min, mut max) = (expect.min, expect.max);
    let limit = match (expect.value, expect.tolerance) {
        (Some(value), Some(tolerance)) => {
            (min, max) = (Some(value - tolerance), Some(value + tolerance));
            format!("{value} ± {tolerance}")
        }
        _ => match (min, max) {
            (Some(min), Some(max)) => format!("{min} to {max}"),
            (Some(min), None) => format!("at least {min}"),
            (None, Some(max)) => format!("at most {max}"),
            (None, None) => "anything".into(),
        },
    };
    let value = metrics.get(&expect.metric);
    let holds = |value: f64| min.is_none_or(|min| value >= min) && max.is_none_or(|max| value <= max);
    Judged { metric: expect.metric.clone(), value, limit, pass: value.is_some_and(holds), source: expect.source.clone() }
}

/// Runs every cell of a grid, in parallel. Each is a scene of its own, seeded as the scene is, so that the result does not depend
/// on the number of threads.
fn cells(loaded: &Loaded, grid: &Grid) -> Result<GridResult, StudyError> {
    let places: Vec<(f64, f64)> =
        grid.rows.iter().flat_map(|&row| grid.columns.iter().map(move |&column| (row, column))).collect();
    let run_cell = |&(row, column): &(f64, f64)| {
        let place = [format!("{}={row}", grid.row_key), format!("{}={column}", grid.column_key)];
        let sets = [grid.set.as_slice(), &place].concat();
        let scene = loaded.with(&sets).map_err(|error| StudyError::Cell(place.join(", "), error))?.scene;
        let record = run::run(&scene, Watch::default())?;
        Ok(metrics::of(&scene, &record).get(&grid.metric))
    };
    let values = places.par_iter().map(run_cell).collect::<Result<Vec<_>, StudyError>>()?;
    let cells = values.chunks(grid.columns.len()).map(<[_]>::to_vec).collect();
    Ok(GridResult { grid: grid.clone(), cells })
}
