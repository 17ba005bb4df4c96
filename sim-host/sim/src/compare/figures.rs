//! Overlay of the figures that two runs have in common, read from the CSV files of their folders.

use std::collections::BTreeMap;
use std::path::Path;

use super::Side;
use crate::data::FigureData;
use columns::file;
use report::{Axis, Figure, Panel, Series, Style};
use scene::schema::{unit_of, words_of};

/// Ends of the names of a band's edges, which are not drawn as curves.
const BAND_SUFFIXES: [&str; 2] = ["_lower", "_upper"];
/// Maximum number of curves of a figure at which two runs remain readable.
const MAX_CURVES: usize = 4;

/// Columns of a figure's file: the first, and the others with their names.
struct Curves {
    x: Vec<f64>,
    columns: Vec<(String, Vec<f64>)>,
}

/// Returns the figures of both sides, the first with solid lines, the second dashed.
pub(super) fn overlaid(a: &Side, b: &Side) -> Vec<Figure> {
    let (Some(one), Some(other)) = (&a.folder, &b.folder) else { return Vec::new() };
    let (ours, theirs) = (files(one), files(other));
    ours.iter().filter_map(|(id, file)| figure(id, &curves(file)?, &curves(theirs.get(id)?)?)).collect()
}

/// Returns the files of a folder that may contain a figure's data, by figure id.
pub(super) fn files(folder: &Path) -> BTreeMap<String, std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    entries
        .filter(|path| path.extension().is_some_and(|end| end == "csv"))
        .filter_map(|path| Some((path.file_stem()?.to_str()?.to_owned(), path)))
        .filter(|(id, _)| FigureData::of(id).is_some())
        .collect()
}

/// Reads the curves of a file with one common x; `None` for a map or for curves over different x.
fn curves(path: &Path) -> Option<Curves> {
    let bytes = file::read(path, file::MAX_DATA_BYTES).ok()?;
    let mut reader = csv::Reader::from_reader(&bytes[..]);
    let header: Vec<String> = reader.headers().ok()?.iter().map(str::to_owned).collect();
    let mut columns = vec![Vec::new(); header.len()];
    for record in reader.records() {
        let record = record.ok()?;
        for (column, cell) in columns.iter_mut().zip(&record) {
            column.push(if cell.is_empty() { f64::NAN } else { cell.parse().ok()? });
        }
    }
    let mut columns = header.into_iter().zip(columns);
    let (_, x) = columns.next()?;
    Some(Curves { x, columns: columns.filter(|(name, _)| !BAND_SUFFIXES.iter().any(|edge| name.ends_with(edge))).collect() })
}

fn figure(id: &str, a: &Curves, b: &Curves) -> Option<Figure> {
    let data = FigureData::of(id)?;
    // Figures of many curves, and maps, are not readable when overlaid.
    if a.columns.len() > MAX_CURVES || !a.columns.iter().chain(&b.columns).all(|(name, _)| data.may_have(name)) {
        return None;
    }
    let common = |(name, _): &&(String, Vec<f64>)| b.columns.iter().any(|(other, _)| other == name);
    let unit = |name: &str| unit_of(name).unwrap_or_else(|| "1".into());
    let mut units: Vec<String> = Vec::new();
    for (name, _) in a.columns.iter().filter(common) {
        if !units.contains(&unit(name)) {
            units.push(unit(name));
        }
    }
    let series = |side: &str, style: Style, curves: &Curves, of: &str| -> Vec<Series> {
        let one = |(name, y): &(String, Vec<f64>)| Series {
            name: format!("{side}: {}", words_of(name)),
            csv_column: format!("{}_{name}", side.to_lowercase()),
            x: curves.x.clone(),
            y: y.clone(),
            style: style.clone(),
        };
        curves.columns.iter().filter(|(name, _)| unit(name) == of).map(one).collect()
    };
    // Each unit has its own plot; errors are drawn by their magnitudes.
    let errors = id == "lock-acquisition";
    let panel = |of: &String| Panel {
        y: Axis { log: errors, magnitude: errors, ..Axis::of(quantity(of), of) },
        series: [series("A", Style::Line, a, of), series("B", Style::Dashed, b, of)].concat(),
        ..Panel::default()
    };
    let mut panels: Vec<Panel> = units.iter().map(panel).collect();
    if panels.is_empty() {
        return None;
    }
    let first = panels.remove(0);
    Some(Figure {
        id: id.to_owned(),
        title: id.replace('-', " "),
        caption: format!("{}; A is solid, B dashed.", data.meaning),
        x: Axis { label: data.x.to_owned(), ..Axis::default() },
        y: first.y,
        series: first.series,
        panels,
        ..Figure::default()
    })
}

/// Returns the quantity of a unit, for an axis that several names share.
fn quantity(unit: &str) -> &'static str {
    match unit {
        "m/s" => "velocity",
        "rad/s" => "angular speed",
        "m" | "mm" | "um" | "µm" | "nm" => "displacement",
        "N" => "force",
        "Hz" => "frequency",
        "V" => "voltage",
        "A" => "current",
        "W" | "mW" => "power",
        "J" => "work",
        "S" => "admittance",
        "s" | "ms" => "time",
        "degrees" => "phase",
        "%" => "fraction",
        _ => "ratio",
    }
}
