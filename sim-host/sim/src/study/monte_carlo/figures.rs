//! Figures of several runs: lock times, and frequency error over time.

use super::uncertainty::{self, Interval};
use super::{MonteCarlo, OneRun};
use crate::bounds::PLAYED_BLOCKS;
use crate::cramer_rao::{Setting, bound};
use crate::instruments::curves::axis;
use report::statistics::{ascending, median, percentile};
use report::{Axis, Figure, Series, Span, Style};
use scene::{Scene, TrackingMode};

/// Bounds of the lock times, and names of their metrics.
const LOCK: [(&str, &str); 3] = [("100 Hz", "lock_time_100hz_ms"), ("20 Hz", "lock_time_20hz_ms"), ("4 Hz", "lock_time_4hz_ms")];
const RELOCK: [(&str, &str); 3] =
    [("100 Hz", "relock_time_100hz_ms"), ("20 Hz", "relock_time_20hz_ms"), ("4 Hz", "relock_time_4hz_ms")];
/// Lower limit of drawn errors, Hz: a logarithmic axis has no zero.
const FLOOR_HZ: f64 = 1e-2;
/// Bounds of the lock times, Hz.
const BOUNDS_HZ: [f64; 3] = [100.0, 20.0, 4.0];

/// Returns all figures that apply to these runs of a scene.
pub fn all(scene: &Scene, runs: &MonteCarlo) -> Vec<Figure> {
    let limits = limit(scene).into_iter().collect();
    let lock = Texts { id: "lock-times", title: "Time to lock", x: "time from the first sample of the lock stage [ms]" };
    let relock = Texts { id: "relock-times", title: "Time to relock", x: "time from the last step [ms]" };
    let own = uncertainty::intervals(scene, runs).into_iter().next().map(|interval| histogram(runs, &interval));
    [own, error(runs, limits), within(runs, &lock, &LOCK), within(runs, &relock, &RELOCK)].into_iter().flatten().collect()
}

/// Returns the histogram of a metric, with its interval.
fn histogram(runs: &MonteCarlo, interval: &Interval) -> Figure {
    let (label, metric, unit) = interval.line;
    let values = ascending(runs.runs.iter().filter_map(|run| run.metrics.get(metric)).filter(|value| value.is_finite()));
    let (low, high) = (values.first().copied().unwrap_or(0.0), values.last().copied().unwrap_or(1.0));
    // Rice's rule.
    let bins = (2.0 * (values.len() as f64).cbrt()).ceil() as usize;
    let width = (high - low) / bins as f64;
    let edge = |bin: usize| low + width * bin as f64;
    let below = |bin: usize| if bin == bins { values.len() } else { values.partition_point(|value| *value < edge(bin)) };
    let part = |bin: usize| 100.0 * (below(bin + 1) - below(bin)) as f64 / values.len() as f64;
    let steps = (0..bins).flat_map(|bin| [(edge(bin), part(bin)), (edge(bin + 1), part(bin))]);
    let (x, y) = std::iter::once((low, 0.0)).chain(steps).chain([(high, 0.0)]).unzip();
    Figure {
        id: "distribution".into(),
        title: format!("Distribution of the {label}"),
        caption: format!("Part of the runs in each interval of `{metric}`. Between the shaded ends are 95 % of the runs."),
        x: axis(&if unit.is_empty() { label.to_owned() } else { format!("{label} [{unit}]") }),
        y: axis("runs [%]"),
        series: vec![Series { name: label.into(), csv_column: "runs_percent".into(), x, y, style: Style::Line }],
        shaded: vec![Span { from: interval.ends[0], to: interval.ends[1], ..Span::default() }],
        ..Figure::default()
    }
}

/// Returns the Cramer-Rao bound of a cold start of the scene itself, with each point delayed until
/// its estimate can be played. It applies only to an observer, whose lock stage begins from rest;
/// that of a loop begins at the end of a scan.
fn limit(scene: &Scene) -> Option<Series> {
    let driven = scene.driven().filter(|driven| driven.controller.tracking.mode == TrackingMode::Observer)?;
    let setting = Setting::from_scene(&driven)?;
    let late_s = PLAYED_BLOCKS * setting.block_s;
    let (x, y) = bound(&setting).into_iter().filter(|(_, hz)| hz.is_finite()).map(|(s, hz)| (1e3 * (s + late_s), hz)).unzip();
    let (name, csv_column) = ("bound (Cramer-Rao), rms".into(), "cramer_rao_hz".into());
    Some(Series { name, csv_column, x, y, style: Style::Line })
}

struct Texts {
    id: &'static str,
    title: &'static str,
    x: &'static str,
}

/// Returns the figure of the runs that remain within a bound, over time.
fn within(runs: &MonteCarlo, texts: &Texts, bounds: &[(&str, &str)]) -> Option<Figure> {
    let times = |metric: &str| ascending(runs.runs.iter().filter_map(|run| run.metrics.get(metric)));
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
            "Fraction of the runs that are within the bound and remain there. A curve that ends below 100 % lacks runs that \
             never lock."
                .into(),
        x: axis(texts.x),
        y: Axis { range: Some((0.0, 102.0)), ..axis("runs [%]") },
        series: series.collect(),
        ..Figure::default()
    })
}

/// Returns the figure of the frequency error over time: median, and 5 to 95 % of the runs. `limits`
/// are curves of an error in Hz rms over a time in ms.
fn error(runs: &MonteCarlo, limits: Vec<Series>) -> Option<Figure> {
    let bands: Vec<(f64, Band)> =
        runs.times_ms.iter().enumerate().filter_map(|(place, &ms)| Some((ms, band(&runs.runs, place)?))).collect();
    if bands.iter().all(|(_, band)| !band.median.is_finite()) {
        return None;
    }
    let column = |value: fn(&Band) -> f64| bands.iter().map(|(_, band)| value(band)).collect::<Vec<f64>>();
    let style = Style::Band { lower: column(|band| band.low), upper: column(|band| band.high) };
    let x: Vec<f64> = bands.iter().map(|(ms, _)| *ms).collect();
    let rms = Series {
        name: "rms of all runs".into(),
        csv_column: "frequency_error_rms_hz".into(),
        x: x.clone(),
        y: column(|band| band.rms),
        style: Style::Line,
    };
    let series = Series {
        name: "median, 5 to 95 % of the runs".into(),
        csv_column: "frequency_error_hz".into(),
        x,
        y: column(|band| band.median),
        style,
    };
    Some(Figure {
        id: "frequency-error".into(),
        title: "Frequency error after the lock stage begins".into(),
        caption: "Distance of the drive from the true series resonance, at the same time in all runs. Runs that have ended, and \
                  blocks without drive, are excluded. The distance is infinite for a run that is muted by a fault or never \
                  reaches the lock stage; if that applies to more than 5 % of the runs, the band has no upper edge. The bound \
                  is that of the scene's own values, for an unbiased estimate, delayed until it can be played."
            .into(),
        x: Axis { log: true, ..axis("time from the first sample of the lock stage [ms]") },
        y: Axis { log: true, ..axis("distance from the true resonance [Hz]") },
        series: [series, rms].into_iter().chain(limits).collect(),
        hlines: BOUNDS_HZ.map(|hz| (hz, format!("{hz} Hz"))).to_vec(),
        ..Figure::default()
    })
}

/// Statistics of the errors of all runs at one time, Hz.
struct Band {
    low: f64,
    median: f64,
    high: f64,
    rms: f64,
}

/// Returns 5th percentile, median, 95th percentile and rms; `None` once fewer than half of the runs
/// have an error.
fn band(runs: &[OneRun], place: usize) -> Option<Band> {
    let errors = runs.iter().filter_map(|run| run.error_hz.get(place).map(|&hz| f64::from(hz))).filter(|hz| !hz.is_nan());
    let errors = ascending(errors.map(|hz| hz.max(FLOOR_HZ)));
    if errors.is_empty() || 2 * errors.len() < runs.len() {
        return None;
    }
    let rms = (errors.iter().map(|hz| hz * hz).sum::<f64>() / errors.len() as f64).sqrt();
    Some(Band { low: percentile(&errors, 0.05), median: median(&errors), high: percentile(&errors, 0.95), rms })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Metrics;
    use crate::study::driven::Level;
    use crate::study::monte_carlo::draw::Draw;

    fn runs(errors_hz: &[f32], times_ms: &[Option<f64>]) -> MonteCarlo {
        let run = |(n, (&hz, &ms)): (usize, (&f32, &Option<f64>))| {
            let mut metrics = Metrics::default();
            metrics.put("lock_time_20hz_ms", ms);
            let draw = Draw { number: n as u32 + 1, seed: 1, values: Vec::new() };
            OneRun { draw, metrics, locked: true, drive_hash: None, error_hz: vec![hz] }
        };
        let runs: Vec<OneRun> = errors_hz.iter().zip(times_ms).enumerate().map(run).collect();
        let asked = runs.len() as u32;
        MonteCarlo { keys: Vec::new(), level: Level::Sil, asked, runs, endless: Vec::new(), times_ms: vec![1.0], wall_s: None }
    }

    fn lock_cold() -> Scene {
        scene::load::load("lock-cold", &[]).unwrap().scene
    }

    /// The delay is 2 blocks of 32 us after the first 25 us; a loop has no bound.
    #[test]
    fn bound_is_drawn_for_an_observer_only() {
        let series = limit(&lock_cold()).unwrap();
        assert!((series.x[0] - 0.089).abs() < 1e-9 && series.y.is_sorted_by(|a, b| a >= b), "{series:?}");
        let looped = scene::load::load("lock-cold", &["controller.tracking.mode=phase_lock".into()]).unwrap().scene;
        assert!(limit(&looped).is_none());
    }

    #[test]
    fn the_distribution_ends_where_runs_never_lock() {
        let figures = all(&lock_cold(), &runs(&[1.0, 2.0, 3.0, 4.0], &[Some(3.0), None, Some(1.0), Some(2.0)]));
        let figure = figures.iter().find(|figure| figure.id == "lock-times").unwrap();
        assert_eq!(figure.series.len(), 1);
        let points: Vec<(f64, f64)> = figure.series[0].x.iter().copied().zip(figure.series[0].y.iter().copied()).collect();
        let steps = [(0.0, 0.0), (1.0, 0.0), (1.0, 25.0), (2.0, 25.0), (2.0, 50.0), (3.0, 50.0), (3.0, 75.0), (1.05 * 3.0, 75.0)];
        assert_eq!(points, steps);
    }

    #[test]
    fn ended_runs_are_excluded_from_errors() {
        let nan = f32::NAN;
        let band = |errors: &[f32]| band(&runs(errors, &[None; 4]).runs, 0).map(|band| (band.median, band.rms));
        assert_eq!(band(&[3.0, 4.0, nan, nan]), Some((3.5, 12.5f64.sqrt())));
        assert!(band(&[3.0, nan, nan, nan]).is_none());
        assert_eq!(band(&[0.0, 0.0, 0.0, 0.0]), Some((FLOOR_HZ, FLOOR_HZ)));
        assert_eq!(band(&[1.0, 1.0, 1.0, f32::INFINITY]), Some((1.0, f64::INFINITY)));
    }
}
