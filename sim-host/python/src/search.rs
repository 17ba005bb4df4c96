//! Searches: `solve` and `optimise`.

use std::sync::atomic::AtomicBool;

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use sim::study::optimise::{Goal, Known, Limit, Question as Optimum};
use sim::study::solve::{Question as Root, SolveError};

use crate::errors::{SceneError, run_error};
use crate::interruptible;
use crate::scene::Scene;

/// Converts the error of a search.
fn search_error(error: SolveError) -> PyErr {
    match error {
        SolveError::Question(error) => SceneError::new_err(error.to_string()),
        SolveError::Run(error) => run_error(&error),
    }
}

/// Creates the error of a search that was stopped.
fn stopped() -> PyErr {
    PyKeyboardInterrupt::new_err("the search was stopped")
}

/// Returns the values of a key at which a metric has a value, as JSON: as `sim-host solve`.
#[pyfunction]
pub fn solve(py: Python<'_>, scene: &Scene, metric: String, target: f64, by: &str, further: Vec<String>) -> PyResult<String> {
    let range = by.parse().map_err(|error| search_error(SolveError::Question(error)))?;
    let metrics = std::iter::once(metric).chain(further).collect();
    let question = Root { loaded: scene.loaded(), range, metrics, target };
    let stop = AtomicBool::new(false);
    interruptible::run(py, &stop, || {
        let answer = question.answer(&stop, &|| ()).map_err(search_error)?.ok_or_else(stopped)?;
        Ok(answer.json(&question).to_string())
    })?
}

/// Returns the values of keys at which a metric is best, as JSON: as `sim-host optimise`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of the Python part")]
pub fn optimise(
    py: Python<'_>,
    scene: &Scene,
    objective: String,
    minimise: bool,
    limits: Vec<String>,
    over: Vec<String>,
    runs: Option<u64>,
    further: Vec<String>,
) -> PyResult<String> {
    let limits = limits.iter().map(|text| text.parse()).collect::<Result<Vec<Limit>, String>>();
    let limits = limits.map_err(SceneError::new_err)?;
    let ranges = over.iter().map(|text| text.parse()).collect::<Result<Vec<_>, _>>();
    let ranges = ranges.map_err(|error| search_error(SolveError::Question(error)))?;
    let goal = if minimise { Goal::Minimise } else { Goal::Maximise };
    let question = Optimum::new(scene.loaded(), ranges, (goal, objective), limits, (further, runs));
    let stop = AtomicBool::new(false);
    interruptible::run(py, &stop, || {
        let answer = question.answer(&Known::new(), &stop, &|_| ()).map_err(search_error)?.ok_or_else(stopped)?;
        Ok(answer.json(&question).to_string())
    })?
}
