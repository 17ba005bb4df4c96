//! Curves over the time of a run, for the figures of instruments.

use super::View;
use crate::record::Row;
use report::{Axis, Series, Span, Style};

/// Most points of a curve over the whole run.
const BINS: usize = 3000;

/// An axis with a label, linear, as long as its data.
pub(crate) fn axis(label: &str) -> Axis {
    Axis { label: label.into(), ..Axis::default() }
}

/// Rows in at most [`BINS`] groups of equal length.
pub(super) fn binned(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunks(rows.len().div_ceil(BINS).max(1))
}

/// The mean over the rows of a group.
pub(super) fn mean(rows: &[Row], value: impl Fn(&Row) -> f64) -> f64 {
    rows.iter().map(value).sum::<f64>() / rows.len() as f64
}

/// A curve of bin means over time, s.
pub(super) fn curve(rows: &[Row], name: &str, csv_column: &str, style: Style, value: impl Fn(&Row) -> f64) -> Series {
    let (x, y) = binned(rows).map(|bin| (mean(bin, |row| row.time_s), mean(bin, &value))).unzip();
    Series { name: name.into(), csv_column: csv_column.into(), x, y, style }
}

/// The ON windows as shaded spans. A schedule of many short bursts is not shaded: it would be one grey field.
pub(super) fn shaded(run: &View) -> Vec<Span> {
    let windows = run.on_windows();
    if windows.len() > 12 {
        return Vec::new();
    }
    windows.into_iter().map(|(from, to)| Span { from, to, label: "ON".into() }).collect()
}
