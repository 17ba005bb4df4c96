//! Figures of the frequency, as command, estimate and truth: during acquisition, at the lock, and
//! over the whole run.

use firmware::seam::mode::Mode;

use crate::instruments::View;
use crate::instruments::curves::{axis, curve, shaded};
use crate::record::Row;
use report::{Axis, Figure, Series, Style};

/// Bounds of the lock times, Hz.
const BOUNDS_HZ: [f64; 3] = [100.0, 20.0, 4.0];
/// Lower end of the axis, Hz; the distance is zero where the curves cross.
const MIN_SHOWN_HZ: f64 = 0.01;

fn series(name: &str, csv_column: &str, x: Vec<f64>, y: Vec<f64>, style: Style) -> Series {
    Series { name: name.into(), csv_column: csv_column.into(), x, y, style }
}

/// Returns the blocks that play between two times, with their times in ms from the first.
fn between<'a>(view: &View<'a>, from_s: f64, to_s: f64) -> (Vec<f64>, &'a [Row]) {
    let rows = view.after(from_s);
    let rows = &rows[..rows.partition_point(|row| row.time_s <= to_s)];
    (rows.iter().map(|row| 1e3 * (row.time_s - from_s)).collect(), rows)
}

/// Returns the figure of the drive frequency during acquisition: the sweeps of the scan, then the
/// lock.
pub(super) fn acquisition(run: &View) -> Option<Figure> {
    let from = run.plays_from(Mode::Scan)?;
    let to = run.plays_from(Mode::Run).unwrap_or(run.rows.last()?.time_s);
    let (x, rows) = between(run, from, to + 0.02 * (to - from));
    let played = rows.iter().map(|row| if row.drive_v > 0.0 { row.frequency_hz } else { f64::NAN }).collect();
    let truth = rows.iter().map(|row| row.truth.series_resonance_hz).collect();
    Some(Figure {
        id: "acquisition".into(),
        title: "Acquisition: scan, then lock".into(),
        caption: "A sweep over the window plus 10 %; its spectrum yields all resonances. If the working mode is not known well \
                  enough, slow sweeps over two bandwidths about it follow, without settling times in between."
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

/// Returns the figure of the distances of command and estimate from the truth, from the first
/// sample of the lock stage on.
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
        caption: "Absolute distance from the true series resonance; the data file has the sign. The scan ends when the residual \
                  vibration of its sweep no longer affects the phase. A contact adds stiffness to the stack: under load, the \
                  lock is slightly above the unloaded truth."
            .into(),
        x: axis("time from the first sample of the lock stage [ms]"),
        y: Axis {
            log: true,
            magnitude: true,
            range: Some((MIN_SHOWN_HZ, 1.5 * farthest)),
            ..axis("distance from the true resonance [Hz]")
        },
        series: vec![
            series("played", "frequency_off_hz", x.clone(), played, Style::Line),
            series("controller's estimate", "estimate_off_hz", x, estimate, Style::Dashed),
        ],
        hlines: BOUNDS_HZ.map(|hz| (hz, format!("{hz} Hz"))).to_vec(),
        interactive: true,
        ..Figure::default()
    })
}

/// Returns the figure of command, estimate and truth over the run, from the lock on.
pub(super) fn over_time(run: &View) -> Option<Figure> {
    let rows = run.after(run.plays_from(Mode::Run)?);
    Some(Figure {
        id: "frequency".into(),
        title: "Frequency: command, estimate, truth".into(),
        caption: "While the drive is OFF the frequency is held. The truth is the series resonance of the stack alone; a contact \
                  adds its stiffness, and the lock follows the combined resonance."
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
