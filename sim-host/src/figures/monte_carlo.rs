//! The figures of several runs: how soon they lock, and how their frequency error falls.

use super::axis;
use crate::metrics::over_runs::{median, percentile};
use crate::report::{Axis, Figure, Series, Style};
use crate::study::monte_carlo::{MonteCarlo, OneRun};

/// Bounds of the lock times, Hz, and how their metrics are called.
const LOCK: [(&str, &str); 3] = [("100 Hz", "lock_time_100hz_ms"), ("20 Hz", "lock_time_20hz_ms"), ("4 Hz", "lock_time_4hz_ms")];
const RELOCK: [(&str, &str); 3] =
    [("100 Hz", "relock_time_100hz_ms"), ("20 Hz", "relock_time_20hz_ms"), ("4 Hz", "relock_time_4hz_ms")];
/// What lies below is drawn here, Hz: a logarithmic axis has no zero.
const FLOOR_HZ: f64 = 1e-3;
/// The bounds that the lock times are counted to, Hz.
const BOUNDS_HZ: [f64; 3] = [100.0, 20.0, 4.0];

/// All figures that these runs have something to show in. What is known of how the error could fall at best stands here as further curves.
pub(super) fn of(runs: &MonteCarlo) -> Vec<Figure> {
    let limits = Vec::new();
    let lock = Texts { id: "lock-times", title: "Time to lock", x: "time from the first sample of the lock stage [ms]" };
    let relock = Texts { id: "relock-times", title: "Time to lock again", x: "time from the last step [ms]" };
    [error(runs, limits), within(runs, &lock, &LOCK), within(runs, &relock, &RELOCK)].into_iter().flatten().collect()
}

struct Texts {
    id: &'static str,
    title: &'static str,
    x: &'static str,
}

/// The part of the runs that is within a bound for good, over time.
fn within(runs: &MonteCarlo, texts: &Texts, bounds: &[(&str, &str)]) -> Option<Figure> {
    let times = |metric: &str| {
        let mut times: Vec<f64> = runs.runs.iter().filter_map(|run| run.metrics.get(metric)).collect();
        times.sort_by(f64::total_cmp);
        times
    };
    let all: Vec<_> = bounds.iter().map(|&(bound, metric)| (bound, metric, times(metric))).collect();
    let last_ms = all.iter().filter_map(|(.., times)| times.last().copied()).reduce(f64::max)?;
    let end_ms = if last_ms > 0.0 { 1.05 * last_ms } else { 1.0 };
    let series = all.into_iter().filter(|(.., times)| !times.is_empty()).map(|(bound, metric, times)| {
        let part = |count: usize| 100.0 * count as f64 / runs.runs.len() as f64;
        let steps = times.iter().enumerate().flat_map(|(n, &time)| [(time, part(n)), (time, part(n + 1))]);
        let (x, y) = std::iter::once((0.0, 0.0)).chain(steps).chain([(end_ms, part(times.len()))]).unzip();
        Series { name: format!("within {bound}"), csv_column: format!("{metric}_percent"), x, y, style: Style::Line }
    });
    Some(Figure {
        id: texts.id.into(),
        title: texts.title.into(),
        caption:
            "Part of the runs that are within the bound and stay there. A curve that ends below 100 % lacks runs that never do."
                .into(),
        x: axis(texts.x),
        y: Axis { range: Some((0.0, 102.0)), ..axis("runs [%]") },
        series: series.collect(),
        ..Figure::default()
    })
}

/// The frequency error over time: median and the middle nine tenths of the runs. Laid over it: `limits`, each an error in Hz rms over a
/// time in ms.
fn error(runs: &MonteCarlo, limits: Vec<Series>) -> Option<Figure> {
    let bands: Vec<(f64, [f64; 3])> =
        runs.times_ms.iter().enumerate().filter_map(|(place, &ms)| Some((ms, band(&runs.runs, place)?))).collect();
    if bands.iter().all(|(_, band)| !band[1].is_finite()) {
        return None;
    }
    let column = |which: usize| bands.iter().map(|(_, band)| band[which]).collect::<Vec<f64>>();
    let style = Style::Band { lower: column(0), upper: column(2) };
    let x = bands.iter().map(|(ms, _)| *ms).collect();
    let series =
        Series { name: "median, 5 to 95 % of the runs".into(), csv_column: "frequency_error_hz".into(), x, y: column(1), style };
    Some(Figure {
        id: "frequency-error".into(),
        title: "Frequency error after the lock stage begins".into(),
        caption: "Distance of the drive from the true series resonance, at the same moment of all runs. Runs that have ended, and blocks \
                  without drive, are left out; a run that is muted by a fault, or never comes to lock, is infinitely far off, and \
                  where that is true of more than a twentieth of them the band has no upper edge."
            .into(),
        x: Axis { log: true, ..axis("time from the first sample of the lock stage [ms]") },
        y: Axis { log: true, ..axis("off the true resonance [Hz]") },
        series: std::iter::once(series).chain(limits).collect(),
        hlines: BOUNDS_HZ.map(|hz| (hz, format!("{hz} Hz"))).to_vec(),
        ..Figure::default()
    })
}

/// 5th percentile, median and 95th percentile of the errors at one moment, Hz; nothing once fewer than half of the runs are left.
fn band(runs: &[OneRun], place: usize) -> Option<[f64; 3]> {
    let errors = runs.iter().filter_map(|run| run.error_hz.get(place).map(|&hz| f64::from(hz))).filter(|hz| !hz.is_nan());
    let mut errors: Vec<f64> = errors.map(|hz| hz.max(FLOOR_HZ)).collect();
    if 2 * errors.len() < runs.len() {
        return None;
    }
    errors.sort_by(f64::total_cmp);
    Some([percentile(&errors, 0.05), median(&errors), percentile(&errors, 0.95)])
}
