//! Curves over the time of a run, for the figures of the instruments.

use super::View;
use crate::record::Row;
use report::{Axis, Series, Span, Style};

/// Maximum number of points of a curve over the whole run.
const MAX_BINS: usize = 3000;

/// Returns a linear axis with a label and automatic range.
pub(crate) fn axis(label: &str) -> Axis {
    Axis { label: label.into(), ..Axis::default() }
}

/// Splits rows into at most [`MAX_BINS`] groups of equal length.
pub(super) fn binned(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunks(rows.len().div_ceil(MAX_BINS).max(1))
}

/// Returns the mean over the rows of a group.
pub(super) fn mean(rows: &[Row], value: impl Fn(&Row) -> f64) -> f64 {
    rows.iter().map(value).sum::<f64>() / rows.len() as f64
}

/// Returns a curve of bin means over time, s.
pub(super) fn curve(rows: &[Row], name: &str, csv_column: &str, style: Style, value: impl Fn(&Row) -> f64) -> Series {
    let (x, y) = binned(rows).map(|bin| (mean(bin, |row| row.time_s), mean(bin, &value))).unzip();
    Series { name: name.into(), csv_column: csv_column.into(), x, y, style }
}

/// Returns the ON windows as shaded spans. The list is empty if there are more than 12 windows,
/// because many short bursts would appear as one grey area.
pub(super) fn shaded(run: &View) -> Vec<Span> {
    let windows = run.on_windows();
    if windows.len() > 12 {
        return Vec::new();
    }
    windows.into_iter().map(|(from, to)| Span { from, to, label: "ON".into() }).collect()
}
