//! Page of a sweep, and its tables.

use std::path::Path;

use super::{FolderError, Layout, PlanFile, ROWS, RowsFile};
use crate::numbers::number;
use crate::output::Presentation;
use crate::study::sweep::sensitivity::{Estimate, Sensitivity};
use crate::study::sweep::{Rows, figures, unit};
use crate::tables::misfit::misfits;
use report::statistics::{ascending, quantile};
use report::{Report, TableBlock};
use scene::load::Assumed;
use scene::shown;

/// Maximum number of points that are drawn, because a figure stores all of its columns.
const MAX_DRAWN_POINTS: u64 = 4_000_000;
/// Maximum number of points whose values are printed, instead of the range of each metric.
const MAX_PRINTED_POINTS: u64 = 20;
/// Maximum number of printed metrics of a point, and of results at the top of the page.
const MAX_PRINTED_METRICS: usize = 6;
const MAX_TILES: usize = 3;

/// Writes the page and the figures; returns the tables of metrics and indices.
pub(super) fn write(
    plan: &PlanFile,
    layout: &Layout,
    (file, rows): (&RowsFile, Option<&Rows>),
    failures: u64,
    indices: &[(String, Sensitivity)],
    (target, shown): (&Path, &Presentation),
) -> Result<Vec<TableBlock>, FolderError> {
    let (title, source) = plan.title();
    let few = rows.filter(|_| file.count() <= MAX_PRINTED_POINTS);
    let first = few.map_or_else(|| metrics(plan, layout, file), |rows| Ok(values(plan, layout, rows)))?;
    let tables = [vec![first], self::indices(layout, indices)].concat();
    let changes = plan.changes().join(", ");
    let mut paragraphs = vec![points(plan)];
    if !changes.is_empty() {
        paragraphs.push(format!("Changed at all points: {changes}."));
    }
    paragraphs.extend(Assumed::remark(&plan.assumed()));
    paragraphs.extend(misfits(plan.resolved_scene(), layout.keys.iter().map(String::as_str)));
    let drawn = plan.count() <= MAX_DRAWN_POINTS;
    if !drawn {
        paragraphs.push(format!("Figures are drawn for at most {MAX_DRAWN_POINTS} points. The rows are in {ROWS}."));
    }
    let column = |name: &str| -> Result<Vec<f64>, FolderError> {
        Ok(file.column(name)?.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect())
    };
    let figures = || figures::all(&plan.shape(), &layout.keys, &layout.metrics, &shown.contours, column);
    let mut summary = Vec::new();
    for metric in layout.metrics.iter().take(MAX_TILES) {
        let ([low, _, high], _) = spread(file, metric)?;
        let unit = Some(unit(metric)).filter(|unit| unit != "1").map_or_else(String::new, |unit| format!(" {unit}"));
        summary.push((figures::words(metric), format!("{low} to {high}{unit}{}", plan.mark(metric))));
    }
    let counts = [("points", plan.count()), ("without result", failures)].into_iter().filter(|(_, count)| *count > 0);
    summary.extend(counts.map(|(label, count)| (label.to_owned(), count.to_string())));
    let report = Report {
        title: format!("Sweep: {title}"),
        subtitle: if source.is_empty() { String::new() } else { format!("Source: {source}") },
        summary,
        paragraphs,
        tables: [vec![keys(layout, file)?], tables.clone()].concat(),
        figures: if drawn { figures()? } else { Vec::new() },
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

/// Describes the points in words.
fn points(plan: &PlanFile) -> String {
    let each = match plan.runs() {
        1 => "one run, with the scene's seed".to_owned(),
        runs => format!("the statistics of {runs} runs of the scene"),
    };
    let shape = plan.shape();
    let which = match (shape.counts, shape.sample) {
        (Some(counts), _) => {
            let counts: Vec<String> = counts.iter().map(u64::to_string).collect();
            format!("every combination of {} values of the keys", counts.join(" times "))
        }
        (None, true) => "a sample of the keys from a scrambled Sobol sequence, arranged for Sobol indices".to_owned(),
        (None, false) => "a list of points".to_owned(),
    };
    format!("{} points: {which}. Each is {each}.", plan.count())
}

/// Returns minimum, median and maximum of a column, and the number of its values.
fn spread(file: &RowsFile, name: &str) -> Result<([String; 3], u64), FolderError> {
    let values = ascending(file.column(name)?.into_iter().flatten());
    let three = [values.first().copied(), quantile(&values, 0.5), values.last().copied()];
    Ok((three.map(|value| value.map_or_else(|| "–".to_owned(), number)), values.len() as u64))
}

/// Returns the points of the smallest and of the largest value of a metric, as `key=value`.
fn places(layout: &Layout, file: &RowsFile, metric: &str) -> Result<[String; 2], FolderError> {
    let column = file.column(metric)?;
    let present = || column.iter().enumerate().filter_map(|(row, value)| Some((row, (*value)?)));
    let ends = [present().min_by(|a, b| a.1.total_cmp(&b.1)), present().rev().max_by(|a, b| a.1.total_cmp(&b.1))];
    let mut places = [const { String::new() }; 2];
    for key in &layout.keys {
        let values = file.column(key)?;
        let tail = key.rsplit('.').next().unwrap_or(key);
        for (place, end) in places.iter_mut().zip(ends) {
            if let Some(value) = end.and_then(|(row, _)| values[row]) {
                *place += &format!("{}{tail}={}", if place.is_empty() { "" } else { ", " }, number(value));
            }
        }
    }
    Ok(places)
}

fn keys(layout: &Layout, file: &RowsFile) -> Result<TableBlock, FolderError> {
    let row = |key: &String| Ok([vec![key.clone(), unit(key)], spread(file, key)?.0.to_vec()].concat());
    let rows = layout.keys.iter().map(row).collect::<Result<Vec<_>, FolderError>>()?;
    Ok(TableBlock::new("keys", "Keys", "", &["key", "unit", "minimum", "median", "maximum"], rows))
}

/// Returns the values of all points, one row each.
fn values(plan: &PlanFile, layout: &Layout, rows: &Rows) -> TableBlock {
    let heading = |name: &String| match unit(name).as_str() {
        "1" => format!("{name}{}", plan.mark(name)),
        unit => format!("{name} [{unit}]{}", plan.mark(name)),
    };
    let faults = rows.fault_codes.iter().flatten().any(|code| *code != 0);
    let header = layout
        .keys
        .iter()
        .chain(layout.metrics.iter().take(MAX_PRINTED_METRICS))
        .map(heading)
        .chain(faults.then(|| "fault".to_owned()));
    let row = |row: usize| -> Vec<String> {
        let keys = rows.keys.iter().map(|key| shown(key[row]));
        let metrics = rows.metrics.iter().take(MAX_PRINTED_METRICS);
        let metrics = metrics.map(|metric| metric[row].map_or_else(|| "–".to_owned(), number));
        let fault = rows.fault_codes[row].filter(|code| *code != 0).map_or_else(String::new, |code| code.to_string());
        keys.chain(metrics).chain(faults.then_some(fault)).collect()
    };
    let cells = (0..rows.points.len()).map(row).collect();
    let more = match layout.metrics.len().saturating_sub(MAX_PRINTED_METRICS) {
        0 => String::new(),
        more => format!("{more} more metrics are in {ROWS}."),
    };
    TableBlock::new("points", "Points", &more, &header.collect::<Vec<_>>(), cells)
}

fn metrics(plan: &PlanFile, layout: &Layout, file: &RowsFile) -> Result<TableBlock, FolderError> {
    let row = |metric: &String| {
        let ([low, median, high], present) = spread(file, metric)?;
        let [least, largest] = if low == high { Default::default() } else { places(layout, file, metric)? };
        let without = (file.count() - present).to_string();
        Ok(vec![format!("{metric}{}", plan.mark(metric)), unit(metric), low, least, median, high, largest, without])
    };
    let rows = layout.metrics.iter().map(row).collect::<Result<Vec<_>, FolderError>>()?;
    Ok(TableBlock::new(
        "metrics",
        "Metrics",
        "Over all points.",
        &["metric", "unit", "minimum", "at", "median", "maximum", "at", "without value"],
        rows,
    ))
}

/// Returns one table of the Sobol indices of all metrics.
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
        "First order: fraction of the metric's variance caused by the key alone. Total: fraction including interactions with \
         other keys. In parentheses: 95 % confidence interval from a bootstrap.",
        &["metric", "key", "first order", "total", "draws"],
        rows,
    )]
}
