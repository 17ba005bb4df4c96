//! Writes all points and all comparisons as CSV, and a report with the work-precision curves.

use std::path::Path;

use report::{self, Axis, Figure, Report, Series, Style};
use serde::Serialize;

use crate::bench::{Entry, Point, Quantity, Results};
use crate::choice::TARGETS;
use crate::peer::{Family, Setting};
use crate::table;

#[derive(Serialize)]
struct PointRow<'a> {
    case: &'static str,
    peer: &'a str,
    way: &'a str,
    tolerance: Option<f64>,
    steps_per_period: Option<u32>,
    periods: u32,
    ns_per_period: Option<f64>,
    rounds: usize,
    error_mean: Option<f64>,
    error_end: Option<f64>,
    failure: Option<&'a str>,
}

#[derive(Serialize)]
struct CostRow<'a> {
    case: &'static str,
    peer: &'a str,
    quantity: &'static str,
    error: f64,
    ns_per_period: Option<f64>,
    over_ours: Option<f64>,
    setting: Option<String>,
    error_of_setting: Option<f64>,
    least_error: Option<f64>,
}

/// Writes everything into a directory.
///
/// # Errors
/// If a file cannot be written.
pub fn write(all: &[Results], notes: &[String], facts: &[(String, String)], dir: &Path) -> anyhow::Result<()> {
    let report = Report {
        title: "Peers on four cases".into(),
        subtitle: "One mass, one spring, Dahl or LuGre friction, velocity ratio 0.5, from rest".into(),
        paragraphs: notes.to_vec(),
        tables: all.iter().flat_map(|results| [table::costs(results), table::settings(results)]).collect(),
        figures: all.iter().flat_map(figures).collect(),
        footer: facts.to_vec(),
        ..Report::default()
    };
    report::write(&report, dir)?;
    write_points(all, dir)?;
    write_costs(all, dir)
}

fn write_points(all: &[Results], dir: &Path) -> anyhow::Result<()> {
    let mut file = csv::Writer::from_path(dir.join("points.csv"))?;
    for results in all {
        for entry in &results.entries {
            for point in &entry.points {
                let run = point.result.as_ref().ok();
                let (tolerance, steps_per_period) = match point.setting {
                    Setting::Tolerance(tolerance) => (Some(tolerance), None),
                    Setting::Steps(steps) => (None, Some(steps)),
                };
                file.serialize(PointRow {
                    case: results.kind.name(),
                    peer: &entry.name,
                    way: &point.way.name,
                    tolerance,
                    steps_per_period,
                    periods: entry.periods,
                    ns_per_period: point.ns(),
                    rounds: point.rounds.len(),
                    error_mean: run.map(|run| run.mean_error),
                    error_end: run.map(|run| run.end_error),
                    failure: point.result.as_ref().err().map(String::as_str),
                })?;
            }
        }
    }
    Ok(file.flush()?)
}

fn write_costs(all: &[Results], dir: &Path) -> anyhow::Result<()> {
    let mut file = csv::Writer::from_path(dir.join("costs.csv"))?;
    for results in all {
        for entry in &results.entries {
            for (quantity, error) in TARGETS {
                let cell = table::cell(results, entry, quantity, error);
                file.serialize(CostRow {
                    case: results.kind.name(),
                    peer: &entry.name,
                    quantity: quantity.name(),
                    error,
                    ns_per_period: cell.ns,
                    over_ours: cell.ratio,
                    setting: cell.setting,
                    error_of_setting: cell.error,
                    least_error: cell.least_error,
                })?;
            }
        }
    }
    Ok(file.flush()?)
}

/// Returns one figure for each quantity of a case.
fn figures(results: &Results) -> Vec<Figure> {
    let labels = [
        (Quantity::Mean, "error of the mean friction ratio"),
        (Quantity::End, "largest error of displacement, velocity and friction at the end"),
    ];
    let figure = |(quantity, label): (Quantity, &str)| Figure {
        id: format!("{}-{}", results.kind.stem(), quantity.name()),
        title: format!("{}: cost against error, {}", results.kind.name(), quantity.name()),
        caption: "Each peer's cheapest settings. Further down is cheaper, further left more accurate. Solid: ours.".into(),
        x: Axis { label: label.into(), log: true, ..Axis::default() },
        y: Axis { label: "wall time [ns a period]".into(), log: true, ..Axis::default() },
        series: results.entries.iter().map(|entry| series(entry, quantity)).collect(),
        ..Figure::default()
    };
    labels.into_iter().map(figure).collect()
}

/// Returns the settings of a peer for which no other is both cheaper and more accurate.
fn series(entry: &Entry, quantity: Quantity) -> Series {
    let measured = |point: &Point| Some((point.result.as_ref().ok()?.error(quantity), point.ns()?));
    let mut points: Vec<(f64, f64)> = entry.points.iter().filter_map(measured).filter(|(error, _)| *error < 1e-2).collect();
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut least = f64::INFINITY;
    points.retain(|(error, _)| {
        let better = *error < least && *error > 0.0;
        least = if better { *error } else { least };
        better
    });
    let word: String = entry.name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
    Series {
        name: entry.name.clone(),
        csv_column: format!("{word}_ns_per_period"),
        x: points.iter().map(|point| point.0).collect(),
        y: points.iter().map(|point| point.1).collect(),
        style: if entry.family == Family::Ours { Style::Line } else { Style::Dashed },
    }
}
