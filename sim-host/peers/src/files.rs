//! What is written: all points and all ratios as CSV, and a report with the work-precision curves.

use std::path::Path;

use report::{self, Axis, Figure, Report, Series, Style};
use serde::Serialize;

use crate::bench::{Entry, Quantity};
use crate::interpolate::Cost;
use crate::peer::{Family, Setting};
use crate::table::{self, TARGETS};

#[derive(Serialize)]
struct PointRow<'a> {
    peer: &'a str,
    tolerance: Option<f64>,
    steps_per_period: Option<u32>,
    periods: u32,
    ns_per_period: Option<f64>,
    error_mean: Option<f64>,
    error_friction: Option<f64>,
    failure: Option<&'a str>,
}

#[derive(Serialize)]
struct RatioRow<'a> {
    peer: &'a str,
    quantity: &'static str,
    error: f64,
    bound: &'static str,
    ratio: Option<f64>,
    ns_per_period: Option<f64>,
    least_error: Option<f64>,
}

/// Writes everything into a directory.
///
/// # Errors
/// If a file cannot be written.
pub fn write(entries: &[Entry], facts: &[(String, String)], dir: &Path) -> anyhow::Result<()> {
    let troubles = table::troubles(entries);
    let report = Report {
        title: "Peers on one case".into(),
        subtitle: "Table 4.1 on one mass and one spring, Dahl friction, velocity ratio 0.5, from rest".into(),
        paragraphs: troubles,
        tables: vec![table::ratios(entries), table::costs(entries)],
        figures: figures(entries),
        footer: facts.to_vec(),
        ..Report::default()
    };
    report::write(&report, dir)?;
    write_points(entries, dir)?;
    write_ratios(entries, dir)
}

fn write_points(entries: &[Entry], dir: &Path) -> anyhow::Result<()> {
    let mut file = csv::Writer::from_path(dir.join("points.csv"))?;
    for entry in entries {
        for point in &entry.points {
            let run = point.result.as_ref().and_then(|result| result.as_ref().ok());
            let (tolerance, steps_per_period) = match point.setting {
                Setting::Tolerance(tolerance) => (Some(tolerance), None),
                Setting::Steps(steps) => (None, Some(steps)),
            };
            file.serialize(PointRow {
                peer: &entry.name,
                tolerance,
                steps_per_period,
                periods: entry.periods,
                ns_per_period: run.map(|run| run.ns_per_period),
                error_mean: run.map(|run| run.mean_error),
                error_friction: run.map(|run| run.force_error),
                failure: point.result.as_ref().and_then(|result| result.as_ref().err()).map(String::as_str),
            })?;
        }
    }
    Ok(file.flush()?)
}

fn write_ratios(entries: &[Entry], dir: &Path) -> anyhow::Result<()> {
    let mut file = csv::Writer::from_path(dir.join("ratios.csv"))?;
    for entry in entries {
        for ((quantity, error), cell) in TARGETS.into_iter().zip(table::cells(entries, entry)) {
            file.serialize(RatioRow {
                peer: &entry.name,
                quantity: if quantity == Quantity::Mean { "mean" } else { "friction" },
                error,
                bound: cell.bound(),
                ratio: cell.ratio(),
                ns_per_period: cell.cost.and_then(Cost::value),
                least_error: match cell.cost {
                    Some(Cost::NotReached(best)) => Some(best.error),
                    _ => None,
                },
            })?;
        }
    }
    Ok(file.flush()?)
}

/// One figure for each quantity and each family beside ours: more curves than that cannot be distinguished.
fn figures(entries: &[Entry]) -> Vec<Figure> {
    let quantities = [
        (Quantity::Mean, "mean", "error of the mean friction ratio"),
        (Quantity::Force, "friction", "largest error of F at quarter periods, over the largest F"),
    ];
    let families = [(Family::Rust, "rust", "Rust libraries"), (Family::Python, "python", "SciPy")];
    let mut figures = Vec::new();
    for (family, stem, whose) in families {
        if entries.iter().all(|entry| entry.family != family) {
            continue;
        }
        for (quantity, name, label) in quantities {
            let shown = entries.iter().filter(|entry| [Family::Ours, family].contains(&entry.family) && table::usable(entry));
            figures.push(Figure {
                id: format!("{name}-{stem}"),
                title: format!("Ours and {whose}: cost against error, {}", if name == "mean" { "mean" } else { "F(t)" }),
                caption: "Further down is cheaper, further left more accurate. Solid: ours.".into(),
                x: Axis { label: label.into(), log: true, range: None },
                y: Axis { label: "wall time [ns a period]".into(), log: true, range: None },
                series: shown.map(|entry| series(entry, quantity)).collect(),
                ..Figure::default()
            });
        }
    }
    figures
}

fn series(entry: &Entry, quantity: Quantity) -> Series {
    let curve = entry.curve(quantity);
    let word: String = entry.name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
    Series {
        name: entry.name.clone(),
        csv_column: format!("{word}_ns_per_period"),
        x: curve.iter().map(|point| point.error).collect(),
        y: curve.iter().map(|point| point.cost).collect(),
        style: if entry.family == Family::Ours { Style::Line } else { Style::Dashed },
    }
}
