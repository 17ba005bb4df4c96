//! Names and their meanings.

use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use scene::builtin;
use scene::metrics::METRICS;
use scene::nearest::listed;

/// Names of the built-in scenes.
#[pyfunction]
pub fn scenes() -> Vec<&'static str> {
    builtin::all().iter().map(|(name, _)| *name).collect()
}

/// All metrics: name, unit, meaning.
#[pyfunction]
pub fn metrics() -> Vec<(&'static str, &'static str, &'static str)> {
    METRICS.iter().map(|metric| (metric.name, metric.unit, metric.meaning)).collect()
}

/// What a metric, fault, limit, key of a scene or file means.
#[pyfunction]
pub fn explain(word: &str) -> PyResult<String> {
    sim::explain::explain(word).map(|said| said.join("\n")).map_err(|nearest| {
        let known = if nearest.is_empty() {
            String::new()
        } else {
            format!("; did you mean {}?", listed(nearest.iter().map(String::as_str), "or"))
        };
        PyKeyError::new_err(format!("`{word}` is no metric, fault, limit, key or file{known}"))
    })
}
