//! Built-in scenes of the thesis's experiments, run with the controller on the host: friction as it comes out of controller,
//! converters, stack and contact together.

use rayon::prelude::*;

use contact::SolveError;
use scene::load::load;
use sim::instruments::measure;
use sim::metrics::Metrics;
use sim::record::Row;
use sim::run::{Watch, run};

/// Most points of a curve.
const POINTS: usize = 1200;

/// The recorded curves of a run.
pub struct Ran {
    /// Metrics of the run.
    pub metrics: Metrics,
    /// Time of each point, s.
    pub time_s: Vec<f64>,
    /// Friction: the load cell's reading, N.
    pub cell_n: Vec<f64>,
    /// True friction at each point, N.
    pub friction_n: Vec<f64>,
}

impl Ran {
    /// A metric that the run must have.
    pub fn metric(&self, name: &str) -> Result<f64, SolveError> {
        self.metrics.get(name).ok_or_else(|| trouble(format!("the run has no `{name}`")))
    }
}

fn trouble(reason: String) -> SolveError {
    SolveError::Unsuited { method: "a scene", reason }
}

/// Runs a built-in scene with changes.
pub fn ran(scene: &str, sets: &[String]) -> Result<Ran, SolveError> {
    let loaded = load(scene, sets).map_err(|error| trouble(error.to_string()))?;
    let driven = loaded.scene.driven().ok_or_else(|| trouble(format!("{scene} drives nothing")))?;
    let record = run(&driven, Watch::default()).map_err(|error| trouble(error.to_string()))?;
    let rows: Vec<&[Row]> = record.rows.chunks(record.rows.len().div_ceil(POINTS).max(1)).collect();
    let mean = |value: fn(&Row) -> f64| -> Vec<f64> {
        rows.iter().map(|rows| rows.iter().map(value).sum::<f64>() / rows.len() as f64).collect()
    };
    Ok(Ran {
        metrics: measure(&driven, &record),
        time_s: mean(|row| row.time_s),
        cell_n: mean(|row| row.truth.load_cell_n),
        friction_n: mean(|row| row.truth.friction_mean_n),
    })
}

/// Runs a scene for each list of changes, in parallel.
pub fn each(scene: &str, changes: &[Vec<String>]) -> Result<Vec<Ran>, SolveError> {
    changes.par_iter().map(|sets| ran(scene, sets)).collect()
}
