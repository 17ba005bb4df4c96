//! A study: a scene, run; its metrics held against what was expected; and its grid, if it has one.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::metrics::{self, Metrics};
use crate::plant::circuit::Circuit;
use crate::processor::Processor;
use crate::record::{Record, Window};
use crate::run::{self, RunError, Watch};
use crate::scene::load::{LoadError, Loaded};
use crate::scene::{Expect, Grid, Scene};
use crate::schedule::first_window;

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

/// Where the controller of a study ran, and so what its result can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// On the host.
    Sil,
    /// As thumb code in an emulator.
    Pil,
}

impl std::fmt::Display for Level {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Level::Sil => "SIL (software in the loop: the controller on the host)",
            Level::Pil => "PIL (processor in the loop: the controller as thumb code in QEMU)",
        })
    }
}

/// The result of a study.
#[derive(Clone, Debug)]
pub struct Study {
    /// Name of the scene.
    pub name: String,
    /// What was changed by hand, as `key=value`.
    pub changes: Vec<String>,
    /// Where the controller ran.
    pub level: Level,
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
    (level, processor): (Level, &mut dyn Processor),
    stop: &'a AtomicBool,
    progress: Option<&'a mut dyn FnMut(f64)>,
) -> Result<Study, StudyError> {
    let scene = &loaded.scene;
    let watch = Watch { windows: edge_windows(scene), stop: Some(stop), progress };
    let mut record = run::run_on(processor, scene, watch)?;
    let metrics = metrics::of(scene, &record);
    let judged = scene.expect.iter().map(|expect| judge(expect, &metrics)).collect();
    let grid = match &scene.grid {
        Some(grid) if !record.interrupted => cells(loaded, grid, stop)?,
        _ => None,
    };
    // Stopped within the grid: the scene is whole, and the grid is missing.
    record.interrupted |= stop.load(Ordering::Relaxed);
    Ok(Study {
        name: loaded.name.clone(),
        changes: loaded.sets.clone(),
        level,
        scene: scene.clone(),
        record,
        metrics,
        judged,
        grid,
    })
}

/// Both edges of the first ON window, sample by sample: a little before, and five time constants after. Of a repeated burst the
/// last period, because the first ones find the stack not yet locked.
fn edge_windows(scene: &Scene) -> Vec<Window> {
    let after_s = 5.0 * Circuit::of(&scene.stack.bvd).time_constant_s();
    let Some(burst) = &scene.controller.burst else { return Vec::new() };
    let late = burst.period_s.map_or(0.0, |period_s| scene.duration_s - 2.0 * period_s);
    let window = first_window(burst, late).filter(|window| window.0 < scene.duration_s);
    let edge = |title: &str, at_s: f64| Window {
        title: title.into(),
        edge_s: at_s,
        from_s: at_s - 0.2 * after_s,
        to_s: at_s + after_s,
        ..Window::default()
    };
    window.map_or_else(Vec::new, |(on, off)| vec![edge("on", on), edge("off", off)])
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

/// Runs every cell of a grid, in parallel, with the controller on the host; nothing if it is stopped. Each is a scene of its own, seeded as the scene is, so that the result does not depend
/// on the number of threads.
fn cells(loaded: &Loaded, grid: &Grid, stop: &AtomicBool) -> Result<Option<GridResult>, StudyError> {
    let places: Vec<(f64, f64)> =
        grid.rows.iter().flat_map(|&row| grid.columns.iter().map(move |&column| (row, column))).collect();
    let run_cell = |&(row, column): &(f64, f64)| {
        let place = [format!("{}={row}", grid.row_key), format!("{}={column}", grid.column_key)];
        let sets = [grid.set.as_slice(), &place].concat();
        let scene = loaded.with(&sets).map_err(|error| StudyError::Cell(place.join(", "), error))?.scene;
        let record = run::run(&scene, Watch { stop: Some(stop), ..Watch::default() })?;
        Ok(metrics::of(&scene, &record).get(&grid.metric))
    };
    let values = places.par_iter().map(run_cell).collect::<Result<Vec<_>, StudyError>>()?;
    let cells = values.chunks(grid.columns.len()).map(<[_]>::to_vec).collect();
    Ok((!stop.load(Ordering::Relaxed)).then(|| GridResult { grid: grid.clone(), cells }))
}
