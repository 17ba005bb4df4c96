//! The grid of a scene: `grid.csv`, a row a point, and what the summary has of it.

use std::path::Path;

use serde_json::{Map, Value, json};

use crate::study::grid::GridResult;
use crate::study::sweep::Rows;

/// Writes the points; a last column says why one has no result.
pub(super) fn write(result: &GridResult, path: &Path) -> Result<(), csv::Error> {
    let mut file = csv::Writer::from_path(path)?;
    file.write_record(Rows::head(&result.keys(), &result.metrics).chain(["failure"]))?;
    for (row, failure) in result.rows.failures.iter().enumerate() {
        file.write_record(result.rows.cells(row).chain([failure.clone().unwrap_or_default()]))?;
    }
    file.flush()?;
    Ok(())
}

/// The points by columns.
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

/// What is not a number is null.
fn numbers(values: Vec<f64>) -> Vec<Option<f64>> {
    values.into_iter().map(|value| Some(value).filter(|value| value.is_finite())).collect()
}
