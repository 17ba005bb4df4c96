//! Names and their meanings, for `explain`.

use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use scene::builtin;
use scene::metrics::METRICS;
use scene::nearest::listed;

/// Returns the names of the built-in scenes.
#[pyfunction]
pub fn scenes() -> Vec<&'static str> {
    builtin::all().iter().map(|(name, _)| *name).collect()
}

/// Returns all metrics: name, unit, meaning.
#[pyfunction]
pub fn metrics() -> Vec<(&'static str, &'static str, &'static str)> {
    METRICS.iter().map(|metric| (metric.name, metric.unit, metric.meaning)).collect()
}

/// Returns the meaning of a metric, fault, limit, key of a scene or file.
#[pyfunction]
pub fn explain(word: &str) -> PyResult<String> {
    sim::explain::explain(word).map(|said| said.join("\n")).map_err(|nearest| {
        let known = if nearest.is_empty() {
            String::new()
        } else {
            format!("; did you mean {}?", listed(nearest.iter().map(String::as_str), "or"))
        };
        PyKeyError::new_err(format!("`{word}` is not a metric, fault, limit, key or file{known}"))
    })
}
