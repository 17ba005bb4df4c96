//! The figures of a driven run: what was commanded, what the controller believed, what was true.

mod admittance;
mod belt;
mod crash;
mod edges;
mod energy;
mod friction;
mod motor;
mod resonance;
pub(super) mod time_frequency;
mod webbing;

use super::axis;
use crate::metrics::driven::View;
use crate::record::Row;
use crate::study::driven::Run;
use crate::study::swept::Swept;
use report::{Figure, Series, Span, Style};

/// Most points of a curve over the whole run.
const BINS: usize = 3000;

/// All figures that this run has something to show in, the most telling first.
pub(super) fn of(run: &Run) -> Vec<Figure> {
    let view = View::new(&run.scene, &run.record);
    let mut figures = crash::of(run);
    figures.extend(motor::of(run, &view));
    figures.extend(friction::ratio(run, &view));
    figures.extend(belt::of(run, &view));
    figures.extend(friction::over_time(run, &view));
    figures.extend(webbing::of(run, &view));
    figures.extend(edges::of(run, &view));
    figures.extend(resonance::acquisition(run, &view));
    figures.extend(resonance::lock_in(&view));
    figures.extend(resonance::over_time(&view));
    figures.extend(admittance::locus(run, &view));
    figures.extend(Swept::of("", &run.scene, &run.record).iter().flat_map(time_frequency::of));
    figures.extend(friction::tip_velocity(run, &view));
    figures.extend(energy::budget(run, &view));
    figures
}

/// Rows in at most [`BINS`] groups of equal length.
fn binned(rows: &[Row]) -> impl Iterator<Item = &[Row]> {
    rows.chunks(rows.len().div_ceil(BINS).max(1))
}

fn mean(rows: &[Row], value: impl Fn(&Row) -> f64) -> f64 {
    rows.iter().map(value).sum::<f64>() / rows.len() as f64
}

/// A curve of bin means over time, s.
fn curve(rows: &[Row], name: &str, csv_column: &str, style: Style, value: impl Fn(&Row) -> f64) -> Series {
    let (x, y) = binned(rows).map(|bin| (mean(bin, |row| row.time_s), mean(bin, &value))).unzip();
    Series { name: name.into(), csv_column: csv_column.into(), x, y, style }
}

/// The ON windows as shaded spans. A schedule of many short bursts is not shaded: it would be one grey field.
fn shaded(view: &View) -> Vec<Span> {
    let windows = view.on_windows();
    if windows.len() > 12 {
        return Vec::new();
    }
    windows.into_iter().map(|(from, to)| Span { from, to, label: "ON".into() }).collect()
}
