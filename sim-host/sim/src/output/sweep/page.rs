//! The page of a sweep and its tables.

use std::path::Path;

use super::{FolderError, Layout, PlanFile, ROWS, RowsFile};
use crate::numbers::number;
use crate::output::Presentation;
use crate::study::sweep::sensitivity::{Estimate, Sensitivity};
use crate::study::sweep::{figures, unit};
use report::statistics::{ascending, quantile};
use report::{Report, TableBlock};

/// Most points that are drawn: a figure holds all of its columns.
const DRAWN: u64 = 4_000_000;

/// Writes the page and the figures; the tables that answer what was asked.
pub(super) fn write(
    plan: &PlanFile,
    layout: &Layout,
    file: &RowsFile,
    failures: u64,
    indices: &[(String, Sensitivity)],
    (target, shown): (&Path, &Presentation),
) -> Result<Vec<TableBlock>, FolderError> {
    let (title, source) = plan.title();
    let tables = [vec![metrics(layout, file)?], self::indices(layout, indices)].concat();
    let changes = plan.changes().join(", ");
    let mut paragraphs = vec![points(plan)];
    if !changes.is_empty() {
        paragraphs.push(format!("Changed by hand at all points: {changes}."));
    }
    let drawn = plan.count() <= DRAWN;
    if !drawn {
        paragraphs.push(format!("No figures: they are of at most {DRAWN} points. The rows are in {ROWS}."));
    }
    let column = |name: &str| -> Result<Vec<f64>, FolderError> {
        Ok(file.column(name)?.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect())
    };
    let report = Report {
        title: format!("Sweep: {title}"),
        subtitle: if source.is_empty() { String::new() } else { format!("Source: {source}") },
        summary: vec![("points".to_owned(), plan.count().to_string()), ("without result".to_owned(), failures.to_string())],
        paragraphs,
        tables: [vec![keys(layout, file)?], tables.clone()].concat(),
        figures: if drawn { figures::of(&plan.shape(), &layout.keys, &layout.metrics, column)? } else { Vec::new() },
        footer: [("scene", plan.scene()), ("plan", plan.hash())]
            .map(|(label, value)| (label.to_owned(), value.to_owned()))
            .into_iter()
            .chain(shown.provenance.footer())
            .collect(),
        ..Report::default()
    };
    report::write_drawn(&report, target, &shown.drawing)?;
    Ok(tables)
}

/// What a point is, in words.
fn points(plan: &PlanFile) -> String {
    let each = match plan.runs() {
        1 => "a run of its own, with the scene's seed".to_owned(),
        runs => format!("{runs} runs of the scene, of which it has the statistics"),
    };
    let shape = plan.shape();
    let which = match (shape.counts, shape.sample) {
        (Some(counts), _) => {
            let counts: Vec<String> = counts.iter().map(u64::to_string).collect();
            format!("every combination of {} values of the keys", counts.join(" times "))
        }
        (None, true) => "a sample of the keys by a scrambled Sobol sequence, laid out for Sobol indices".to_owned(),
        (None, false) => "a list of points".to_owned(),
    };
    format!("{} points: {which}. Each is {each}.", plan.count())
}

/// Least, median and greatest value of a column, and how many it has.
fn spread(file: &RowsFile, name: &str) -> Result<(Vec<String>, u64), FolderError> {
    let values = ascending(file.column(name)?.into_iter().flatten());
    let three = [values.first().copied(), quantile(&values, 0.5), values.last().copied()];
    Ok((three.map(|value| value.map_or_else(|| "–".to_owned(), number)).to_vec(), values.len() as u64))
}

fn keys(layout: &Layout, file: &RowsFile) -> Result<TableBlock, FolderError> {
    let row = |key: &String| Ok([vec![key.clone(), unit(key)], spread(file, key)?.0].concat());
    let rows = layout.keys.iter().map(row).collect::<Result<Vec<_>, FolderError>>()?;
    Ok(TableBlock::new("keys", "Keys", "", &["key", "unit", "least", "median", "most"], rows))
}

fn metrics(layout: &Layout, file: &RowsFile) -> Result<TableBlock, FolderError> {
    let row = |metric: &String| {
        let (spread, present) = spread(file, metric)?;
        Ok([vec![metric.clone(), unit(metric)], spread, vec![(file.count() - present).to_string()]].concat())
    };
    let rows = layout.metrics.iter().map(row).collect::<Result<Vec<_>, FolderError>>()?;
    Ok(TableBlock::new(
        "metrics",
        "Metrics",
        "Over all points.",
        &["metric", "unit", "least", "median", "most", "without value"],
        rows,
    ))
}

/// The Sobol indices, a table for all metrics.
fn indices(layout: &Layout, indices: &[(String, Sensitivity)]) -> Vec<TableBlock> {
    let shown = |of: Estimate| format!("{:.3} ({:.3} to {:.3})", of.value, of.interval.0, of.interval.1);
    let rows: Vec<Vec<String>> = indices
        .iter()
        .flat_map(|(metric, found)| {
            let row = move |(key, of): (&String, _)| -> Vec<String> {
                let of: &crate::study::sweep::sensitivity::Indices = of;
                vec![metric.clone(), key.clone(), shown(of.first), shown(of.total), found.used.to_string()]
            };
            layout.keys.iter().zip(&found.keys).map(row)
        })
        .collect();
    if rows.is_empty() {
        return Vec::new();
    }
    vec![TableBlock::new(
        "indices",
        "Sobol indices",
        "First order: the part of the metric's variance that the key makes alone. Total: the part in which it has a share. In brackets 95 % \
         confidence, by a bootstrap.",
        &["metric", "key", "first order", "total", "draws"],
        rows,
    )]
}
