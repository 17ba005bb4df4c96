//! Frequency: command, estimate, truth; while it is looked for, at the moment of lock, and over the whole run.

use firmware::seam::mode::Mode;

use crate::instruments::View;
use crate::instruments::curves::{axis, curve, shaded};
use crate::record::Row;
use report::{Axis, Figure, Series, Style};

/// Bounds of the lock times, Hz.
const BOUNDS_HZ: [f64; 3] = [100.0, 20.0, 4.0];
/// The least distance shown, Hz: where the two cross, it is zero for a moment.
const LEAST_HZ: f64 = 0.01;

fn series(name: &str, csv_column: &str, x: Vec<f64>, y: Vec<f64>, style: Style) -> Series {
    Series { name: name.into(), csv_column: csv_column.into(), x, y, style }
}

/// The blocks that play between two moments, with time in ms from the first.
fn between<'a>(view: &View<'a>, from_s: f64, to_s: f64) -> (Vec<f64>, &'a [Row]) {
    let rows = view.after(from_s);
    let rows = &rows[..rows.partition_point(|row| row.time_s <= to_s)];
    (rows.iter().map(|row| 1e3 * (row.time_s - from_s)).collect(), rows)
}

/// The frequency played while the resonance is looked for: the passes of the scan, then the lock.
pub(super) fn acquisition(run: &View) -> Option<Figure> {
    let from = run.plays_from(Mode::Scan)?;
    let to = run.plays_from(Mode::Run).unwrap_or(run.rows.last()?.time_s);
    let (x, rows) = between(run, from, to + 0.02 * (to - from));
    let played = rows.iter().map(|row| if row.drive_v > 0.0 { row.frequency_hz } else { f64::NAN }).collect();
    let truth = rows.iter().map(|row| row.truth.series_resonance_hz).collect();
    Some(Figure {
        id: "acquisition".into(),
        title: "Acquisition: scan, then lock".into(),
        caption:
            "A sweep over the window and a tenth more, from whose spectrum all resonances are found; then, if the working mode is not known \
                  well enough, slow sweeps over two bandwidths about it. Nothing settles in between."
                .into(),
        x: axis("time from the first sample of the scan [ms]"),
        y: axis("frequency [Hz]"),
        series: vec![
            series("played", "frequency_played_hz", x.clone(), played, Style::Line),
            series("true series resonance", "series_resonance_true_hz", x, truth, Style::Dashed),
        ],
        interactive: true,
        ..Figure::default()
    })
}

/// How far command and estimate are from the truth, from the first sample of the lock stage on.
pub(super) fn lock_acquisition(run: &View) -> Option<Figure> {
    let from = run.plays_from(Mode::Lock)?;
    let locked = run.plays_from(Mode::Run).unwrap_or(from + 0.01);
    let (x, rows) = between(run, from, locked + (locked - from).max(0.005));
    let off = |value: fn(&Row) -> f64| rows.iter().map(|row| value(row) - row.truth.series_resonance_hz).collect::<Vec<f64>>();
    let (played, estimate) = (off(|row| row.frequency_hz), off(|row| row.resonance_estimate_hz));
    let farthest = played.iter().chain(&estimate).map(|hz| hz.abs()).filter(|hz| hz.is_finite()).fold(BOUNDS_HZ[0], f64::max);
    Some(Figure {
        id: "lock-acquisition".into(),
        title: "Lock acquisition".into(),
        caption: "Distance from the true series resonance, without its sign, which the data file has. The scan ends when what its sweep has left \
                  no longer turns the phase. A contact adds its own stiffness to the stack: under load the lock lies a little above the unloaded truth."
            .into(),
        x: axis("time from the first sample of the lock stage [ms]"),
        y: Axis { log: true, magnitude: true, range: Some((LEAST_HZ, 1.5 * farthest)), ..axis("distance from the true resonance [Hz]") },
        series: vec![
            series("played", "frequency_off_hz", x.clone(), played, Style::Line),
            series("controller's estimate", "estimate_off_hz", x, estimate, Style::Dashed),
        ],
        hlines: BOUNDS_HZ.map(|hz| (hz, format!("{hz} Hz"))).to_vec(),
        interactive: true,
        ..Figure::default()
    })
}

/// Command, estimate and truth over the run, from the lock on.
pub(super) fn over_time(run: &View) -> Option<Figure> {
    let rows = run.after(run.plays_from(Mode::Run)?);
    Some(Figure {
        id: "frequency".into(),
        title: "Frequency: command, estimate, truth".into(),
        caption:
            "While the drive is OFF the frequency is held. The truth is the series resonance of the stack by itself; a contact \
                  adds its stiffness, and the lock follows the two together."
                .into(),
        x: axis("time [s]"),
        y: axis("frequency [Hz]"),
        series: vec![
            curve(rows, "command", "frequency_command_hz", Style::Line, |row| row.frequency_hz),
            curve(rows, "controller's estimate", "resonance_estimate_hz", Style::Line, |row| row.resonance_estimate_hz),
            curve(rows, "truth", "series_resonance_true_hz", Style::Dashed, |row| row.truth.series_resonance_hz),
        ],
        shaded: shaded(run),
        interactive: true,
        ..Figure::default()
    })
}
