//! Built-in scenes of the thesis's experiments, run with the controller on the host: the friction
//! results from controller, converters, stack and contact together.

use rayon::prelude::*;

use contact::SolveError;
use scene::load::load;
use sim::instruments::measure;
use sim::metrics::Metrics;
use sim::record::Row;
use sim::run::{Watch, run};

/// Largest number of points of a curve.
const MAX_POINTS: usize = 1200;

/// Recorded curves of a run.
pub struct SceneRun {
    /// Metrics of the run.
    pub metrics: Metrics,
    /// Time of each point, s.
    pub time_s: Vec<f64>,
    /// Friction as read by the load cell, N.
    pub cell_n: Vec<f64>,
    /// True friction at each point, N.
    pub friction_n: Vec<f64>,
}

impl SceneRun {
    /// Returns a metric; fails if the run does not have it.
    pub fn metric(&self, name: &str) -> Result<f64, SolveError> {
        self.metrics.get(name).ok_or_else(|| trouble(format!("the run has no `{name}`")))
    }
}

fn trouble(reason: String) -> SolveError {
    SolveError::Unsuited { method: "a scene", reason }
}

/// Runs a built-in scene with changes.
pub fn run_scene(scene: &str, sets: &[String]) -> Result<SceneRun, SolveError> {
    let loaded = load(scene, sets).map_err(|error| trouble(error.to_string()))?;
    let driven = loaded.scene.driven().ok_or_else(|| trouble(format!("{scene} has no drive")))?;
    let record = run(&driven, Watch::default()).map_err(|error| trouble(error.to_string()))?;
    let rows: Vec<&[Row]> = record.rows.chunks(record.rows.len().div_ceil(MAX_POINTS).max(1)).collect();
    let mean = |value: fn(&Row) -> f64| -> Vec<f64> {
        rows.iter().map(|rows| rows.iter().map(value).sum::<f64>() / rows.len() as f64).collect()
    };
    Ok(SceneRun {
        metrics: measure(&driven, &record),
        time_s: mean(|row| row.time_s),
        cell_n: mean(|row| row.truth.load_cell_n),
        friction_n: mean(|row| row.truth.friction_mean_n),
    })
}

/// Runs a scene for each list of changes, in parallel.
pub fn each(scene: &str, changes: &[Vec<String>]) -> Result<Vec<SceneRun>, SolveError> {
    changes.par_iter().map(|sets| run_scene(scene, sets)).collect()
}
