//! Time-frequency pictures of a sweep (thesis 4.4): the short-time transform of the whole sweep,
//! and the Wigner-Ville distribution of its passage through the resonance.

pub mod record;

use super::curves::axis;
use super::{Instrument, View};
use crate::record::Window;
use plant::truth::Sample;
use report::time_frequency::{Map, Smoothing, stft, wigner_ville, window_for};
use report::{Figure, HeatMap};
use scene::Driven;

use record::SweepRecord;

/// Maximum number of columns of a picture.
const MAX_COLUMNS: usize = 480;
/// Lower ends of the colour scale relative to the strongest cell, dB: short-time transform,
/// Wigner-Ville. The latter has side lobes of either sign.
const FLOOR_DB: [f64; 2] = [60.0, 40.0];
/// Length of the section around the resonance, time constants before and after.
const SECTION_TIME_CONSTANTS: [f64; 2] = [1.5, 5.0];
/// Number of samples to each side in a Wigner-Ville distribution.
const LAGS: usize = 1024;
/// Minimum number of rows of a Wigner-Ville picture, limited by [`MAX_BINS`].
const MIN_ROWS: f64 = 300.0;
/// Maximum number of frequency bins up to half the sample rate.
const MAX_BINS: usize = 1 << 14;
/// Length of the time window of a Wigner-Ville distribution, samples. It removes the cross terms of
/// components further apart than about a fiftieth of the sample rate.
const TIME_WINDOW: usize = 101;

/// Deviation from the mean, relative to it, below which it is rounding.
const ROUNDING_REL: f64 = 1e-9;

/// A signal of the plant.
struct Signal {
    id: &'static str,
    name: &'static str,
    of: fn(&Sample) -> f64,
    harmonics: bool,
}

const DRIVE: Signal = Signal { id: "drive", name: "voltage at the stack", of: |sample| sample.voltage_v, harmonics: false };
const TIP: Signal =
    Signal { id: "tip-velocity", name: "tip velocity", of: |sample| sample.tip_velocity_m_per_s, harmonics: false };
const FRICTION: Signal = Signal { id: "friction", name: "friction", of: |sample| sample.friction_n, harmonics: true };

/// Instrument of scenes whose drive sweeps.
pub(super) struct Sweep;

impl Instrument for Sweep {
    fn windows(&self, scene: &Driven) -> Vec<Window> {
        record::window(scene).into_iter().collect()
    }

    fn figures(&self, run: &View) -> Vec<Figure> {
        SweepRecord::from_record("", &run.scene, run.record).iter().flat_map(figures).collect()
    }
}

/// Returns the pictures of a sweep; empty if it was not recorded.
pub fn figures(record: &SweepRecord) -> Vec<Figure> {
    let signals: &[Signal] = if record.rubs { &[DRIVE, TIP, FRICTION] } else { &[DRIVE, TIP] };
    let whole = signals.iter().filter_map(|signal| short_time(record, signal));
    let near = signals.iter().filter_map(|signal| near_resonance(record, signal, TIME_WINDOW));
    whole.chain(near).chain(near_resonance(record, &TIP, 1)).collect()
}

/// Returns the short-time spectrum of the whole sweep.
fn short_time(record: &SweepRecord, signal: &Signal) -> Option<Figure> {
    let samples = swinging(&record.window.samples, signal);
    let window = window_for(record.law.slowest_hz_per_s(), record.sample_s).min(samples.len() / 4);
    let hop = samples.len().div_ceil(MAX_COLUMNS).max(1);
    let map = stft(&samples, record.sample_s, window, hop);
    let (from_hz, to_hz) = band_hz(record, signal, [record.law.start_hz, record.law.stop_hz], 0.1);
    let frame = Frame { from_s: 0.0, from_hz, to_hz, floor_db: FLOOR_DB[0] };
    let kilohertz = 2e-3 / (window as f64 * record.sample_s);
    Some(Figure {
        id: id(record, "stft", signal),
        title: format!("{}: short-time spectrum of the sweep", heading(record, signal)),
        caption: format!(
            "Power about the mean in dB relative to the strongest cell, with Hann windows of {window} samples: a window blurs \
             each time by about half its length, and each frequency by about {kilohertz:.2} kHz. {}",
            if signal.id == TIP.id {
                "When the sweep passes the resonance, the tip responds and then rings at its own frequency."
            } else {
                ""
            }
        ),
        ..picture(record, &map, &frame)?
    })
}

/// Returns the Wigner-Ville distribution of the passage through the resonance.
fn near_resonance(record: &SweepRecord, signal: &Signal, times: usize) -> Option<Figure> {
    let passes_s = record.law.passes_s(record.resonance_hz)?;
    let from_s = (passes_s - SECTION_TIME_CONSTANTS[0] * record.time_constant_s).max(0.0);
    let to_s = (passes_s + SECTION_TIME_CONSTANTS[1] * record.time_constant_s).min(record.law.time_s);
    let samples = &record.window.samples;
    let place = |seconds: f64| ((seconds / record.sample_s) as usize).min(samples.len());
    let ends = [from_s, to_s].map(|s| record.law.frequency_hz(s));
    let (from_hz, to_hz) = band_hz(record, signal, ends, 0.3);
    let frame = Frame { from_s, from_hz, to_hz, floor_db: FLOOR_DB[1] };
    let (first, end) = (place(from_s), place(to_s));
    let hop = (end - first).div_ceil(MAX_COLUMNS).max(1);
    // The distribution needs samples around the section; their columns are removed afterwards.
    let before = LAGS.min(first) / hop * hop;
    let around = swinging(&samples[first - before..(end + LAGS).min(samples.len())], signal);
    let rows = ((MIN_ROWS * 0.5 / record.sample_s / (frame.to_hz - frame.from_hz)) as usize)
        .next_power_of_two()
        .clamp(2 * LAGS, MAX_BINS);
    let mut map = wigner_ville(&around, record.sample_s, Smoothing { rows, lags: Some(LAGS), times, hop });
    map.columns.drain(..before / hop);
    map.columns.truncate((end - first) / hop);
    let (kind, what) = if times > 1 {
        let microseconds = times as f64 * record.sample_s * 1e6;
        (
            "wigner",
            format!(
                "Smoothed pseudo Wigner-Ville distribution about the mean, in dB relative to the strongest cell. The time \
                 window, {microseconds:.0} us, removes the cross terms of components more than about {:.0} kHz apart. Stripes \
                 next to a ridge are side lobes of the lag window, not spectral lines of the signal.",
                2e3 / microseconds
            ),
        )
    } else {
        (
            "wigner-unsmoothed",
            "The same without a time window: an oscillating cross term appears halfway between any two components; it is not \
             power of the signal. With one component at a time, the two pictures are equal."
                .to_owned(),
        )
    };
    Some(Figure {
        id: id(record, kind, signal),
        title: format!(
            "{}: Wigner-Ville about the resonance{}",
            heading(record, signal),
            if times > 1 { ", smoothed" } else { "" }
        ),
        caption: what,
        ..picture(record, &map, &frame)?
    })
}

/// Returns a signal about its mean, so that the mean does not dominate. A deviation within rounding
/// becomes zero.
fn swinging(samples: &[Sample], signal: &Signal) -> Vec<f64> {
    let mean = samples.iter().map(signal.of).sum::<f64>() / samples.len().max(1) as f64;
    let swing = |sample: &Sample| Some((signal.of)(sample) - mean).filter(|swing| swing.abs() > ROUNDING_REL * mean.abs());
    samples.iter().map(|sample| swing(sample).unwrap_or(0.0)).collect()
}

/// Section of a map that is shown in a picture.
struct Frame {
    /// Time of the first sample, s from the beginning of the sweep.
    from_s: f64,
    from_hz: f64,
    to_hz: f64,
    floor_db: f64,
}

/// Returns the frequency band to show: for friction, from zero to its third harmonic at resonance;
/// for other signals, the frequencies of the sweep and of the stack with the relative margin
/// `margin`.
fn band_hz(record: &SweepRecord, signal: &Signal, ends_hz: [f64; 2], margin: f64) -> (f64, f64) {
    let own_hz = record.resonance_hz;
    if signal.harmonics {
        return (0.0, 3.3 * own_hz);
    }
    let (lowest, highest) = ends_hz.into_iter().fold((own_hz, own_hz), |(a, b), hz| (a.min(hz), b.max(hz)));
    let room_hz = margin * (highest - lowest) + 0.05 * own_hz;
    ((lowest - room_hz).max(0.0), highest + room_hz)
}

/// Converts a map to a figure.
fn picture(record: &SweepRecord, map: &Map, frame: &Frame) -> Option<Figure> {
    let (first, end) = ((frame.from_hz / map.bin_hz) as usize, (frame.to_hz / map.bin_hz) as usize + 1);
    let peak = map.peak();
    if map.columns.is_empty() || peak <= 0.0 {
        return None;
    }
    // Two decimals are finer than any colour step.
    let decibel = |power: f64| (100.0 * 10.0 * (power.max(peak * 1e-12) / peak).log10()).round() / 100.0;
    let columns: Vec<Vec<f64>> =
        map.columns.iter().map(|column| column.iter().take(end).skip(first).map(|&power| decibel(power)).collect()).collect();
    let shown = columns.first().map_or(0, Vec::len) as f64;
    let edge_ms = |column: f64| 1e3 * (frame.from_s + map.first_s + (column - 0.5) * map.every_s);
    let edge_khz = |row: f64| 1e-3 * (row - 0.5) * map.bin_hz;
    Some(Figure {
        x: axis("time from the sweep's beginning [ms]"),
        y: axis("frequency [kHz]"),
        map: Some(HeatMap {
            x: (edge_ms(0.0), edge_ms(columns.len() as f64)),
            y: (edge_khz(first as f64), edge_khz(first as f64 + shown)),
            columns,
            range: (-frame.floor_db, 0.0),
            label: "power [dB]".into(),
            csv_column: "power_db".into(),
            ..HeatMap::default()
        }),
        hlines: vec![(record.resonance_hz / 1e3, "series resonance".into())],
        ..Figure::default()
    })
}

fn id(record: &SweepRecord, kind: &str, signal: &Signal) -> String {
    // File names contain letters, digits and hyphens.
    let plain: String =
        record.name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect();
    let words: Vec<&str> = plain.split('-').filter(|word| !word.is_empty()).collect();
    [&[kind, signal.id][..], &words].concat().join("-")
}

fn heading(record: &SweepRecord, signal: &Signal) -> String {
    let mut letters = signal.name.chars();
    let capital: String = letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect();
    if record.name.is_empty() { capital } else { format!("{}, {}", record.name, signal.name) }
}
