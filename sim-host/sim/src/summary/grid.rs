//! Grid of a scene in the summary.

use serde_json::{Map, Value, json};

use crate::study::grid::GridResult;

/// Returns the points by columns, as JSON.
pub(super) fn json(result: &GridResult) -> Value {
    let column = |name: &String| (name.clone(), json!(result.column(name).map(numbers)));
    let columns = |names: &[String]| -> Map<String, Value> { names.iter().map(column).collect() };
    let failures = result.rows.points.iter().zip(&result.rows.failures);
    let failures: Vec<Value> =
        failures.filter_map(|(point, why)| Some(json!({ "point": point, "failure": why.as_ref()? }))).collect();
    json!({
        "title": result.grid.title, "keys": columns(&result.keys()), "metrics": columns(&result.metrics), "failures": failures,
    })
}

/// Replaces numbers that are not finite by null.
fn numbers(values: Vec<f64>) -> Vec<Option<f64>> {
    values.into_iter().map(|value| Some(value).filter(|value| value.is_finite())).collect()
}
