//! Tables of a grid. With two keys, each metric has a table with one key down and the other across;
//! with any other number of keys there is one table of all points.

use crate::numbers::{distinct, number};
use crate::study::Study;
use crate::study::grid::GridResult;
use report::TableBlock;
use scene::schema::tail;

/// Maximum number of metrics shown.
const MAX_METRICS: usize = 8;
/// Maximum number of values of a key shown across.
const MAX_ACROSS: u64 = 12;
/// Maximum number of points, or values of a key, shown down.
const MAX_DOWN: u64 = 64;

/// Returns the tables of a grid; for a large one, a part with a reference to the file.
pub(super) fn tables(study: &Study) -> Vec<TableBlock> {
    let Some(result) = &study.grid else { return Vec::new() };
    let host = if study.scene.controller.is_some() { " and the controller on the host (SIL)" } else { "" };
    let shown = result.metrics.len().min(MAX_METRICS);
    match result.design.shape().counts.as_deref() {
        Some(&[down, across]) if down <= MAX_DOWN && across <= MAX_ACROSS => {
            (0..shown).map(|metric| across_and_down(result, metric, across as usize, host)).collect()
        }
        _ => vec![points(result, shown, host)],
    }
}

/// Returns the table of a metric over two keys.
fn across_and_down(result: &GridResult, metric: usize, across: usize, host: &str) -> TableBlock {
    let keys = result.keys();
    let columns = tail(&keys[1], &keys);
    let values = &result.rows.keys[1][..across];
    let header = values.iter().map(|value| format!("{columns} = {value}"));
    let row = |(row, cells): (usize, &[Option<f64>])| {
        [result.rows.keys[0][row * across].to_string()].into_iter().chain(cells.iter().copied().map(cell)).collect()
    };
    TableBlock {
        header: [keys[0].clone()].into_iter().chain(header).collect(),
        rows: result.rows.metrics[metric].chunks(across).enumerate().map(row).collect(),
        ..table(result, metric, &result.metrics[metric], ("these two keys", host))
    }
}

/// Returns a table with a row for each point.
fn points(result: &GridResult, shown: usize, host: &str) -> TableBlock {
    let (count, drawn) = (result.rows.points.len(), result.rows.points.len().min(MAX_DOWN as usize));
    let keys: Vec<Vec<String>> = result.rows.keys.iter().map(|key| distinct(&key[..drawn])).collect();
    let row = |row: usize| {
        keys.iter()
            .map(|key| key[row].clone())
            .chain(result.rows.metrics[..shown].iter().map(|metric| metric[row].map_or_else(none, number)))
            .collect()
    };
    let what = match (shown < result.metrics.len(), drawn < count) {
        (false, false) => result.metrics.join(", "),
        (true, false) => format!("{shown} of {} metrics; all are in grid.csv", result.metrics.len()),
        (false, true) => format!("the first {drawn} of {count} points; all are in grid.csv"),
        (true, true) => {
            format!("{shown} of {} metrics at the first {drawn} of {count} points; all are in grid.csv", result.metrics.len())
        }
    };
    let keys = if result.grid.over.len() == 1 { "this key" } else { "these keys" };
    TableBlock {
        header: [result.keys(), result.metrics[..shown].to_vec()].concat(),
        rows: (0..drawn).map(row).collect(),
        ..table(result, 0, &what, (keys, host))
    }
}

/// Returns a table of the grid without rows.
fn table(result: &GridResult, place: usize, what: &str, (keys, host): (&str, &str)) -> TableBlock {
    let besides =
        if result.grid.set.is_empty() { String::new() } else { format!(", in addition to {}", result.grid.set.join(", ")) };
    let mut failures = result.rows.failures.iter().flatten();
    let failed = match (failures.next(), failures.count()) {
        (None, _) => String::new(),
        (Some(why), 0) => format!(". One point has no result: {why}"),
        (Some(why), more) => format!(". {} points have no result; reason of the first: {why}", more + 1),
    };
    TableBlock {
        id: if place == 0 { "grid".to_owned() } else { format!("grid-{}", place + 1) },
        title: result.grid.title.clone(),
        caption: format!("{what}; each point is a separate run with {keys} set{besides}{host}{failed}"),
        header: Vec::new(),
        rows: Vec::new(),
    }
}

/// Formats a number for a column: a ratio with four decimals, other numbers with two, and small
/// ones by their magnitude.
fn cell(value: Option<f64>) -> String {
    match value {
        None => none(),
        Some(value) if value != 0.0 && value.abs() < 1e-3 => number(value),
        Some(value) if value.abs() < 2.0 => format!("{value:.4}"),
        Some(value) => format!("{value:.2}"),
    }
}

/// Returns the text of a missing value.
fn none() -> String {
    "–".to_owned()
}
