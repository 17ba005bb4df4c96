//! Time-frequency maps of a signal, as figure, table and arrays: by the short-time Fourier
//! transform, by wavelets, or by the Wigner-Ville distribution.

use std::fmt;

use report::time_frequency::{Morlet, Smoothing, ratios, stft, wavelet, wigner_ville};
use report::{Axis, Figure, HeatMap, Report, TableBlock, significant};
use serde_json::{Value, json};

use super::{Signal, SignalError};

/// Maximum number of columns of a map.
const MAX_COLUMNS: usize = 500;
/// Number of rows of a wavelet map.
const WAVELET_ROWS: usize = 240;
/// Maximum number of rows of a map; `--band` limits the frequencies.
const MAX_ROWS: usize = 1200;
/// Maximum number of samples.
const MAX_SAMPLES: usize = 1 << 20;
/// Range of the colours, dB below the strongest cell.
const COLOUR_RANGE_DB: f64 = 60.0;
/// Deviation from the mean, relative to it, below which a signal counts as constant.
const CONSTANT_REL: f64 = 1e-12;
/// Maximum number of lags of a Wigner-Ville distribution, samples to either side.
const MAX_LAGS: usize = 1024;

/// Method of a time-frequency map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Short-time Fourier transform with Hann windows of one length.
    Stft,
    /// Morlet wavelets with the same number of cycles at each frequency.
    Wavelet,
    /// Smoothed pseudo Wigner-Ville distribution.
    WignerVille,
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Method::Stft => "stft",
            Method::Wavelet => "wavelet",
            Method::WignerVille => "wigner-ville",
        })
    }
}

/// Parameters of an analysis; absent ones follow from the signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    /// Method.
    pub method: Method,
    /// Length of a window of the short-time Fourier transform, s.
    pub window_s: Option<f64>,
    /// Number of cycles of a wavelet.
    pub cycles: Option<f64>,
    /// Length of the time window of the Wigner-Ville distribution, s; zero for none.
    pub smooth_s: Option<f64>,
    /// Lowest and highest frequency, Hz.
    pub band_hz: Option<(f64, f64)>,
}

/// Time-frequency map of a signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrogram {
    /// Analysed signal.
    pub signal: Signal,
    /// Method.
    pub method: Method,
    /// Names and descriptions of the method's parameters, with its resolution.
    pub how: Vec<(String, String)>,
    /// Times of the columns, s.
    pub times_s: Vec<f64>,
    /// Frequencies of the rows, Hz, ascending: in equal steps, or in equal ratios for wavelets.
    pub hz: Vec<f64>,
    /// Power at each frequency, for each time, in the square of the signal's unit. In the
    /// transforms, a sine of amplitude `a` has a peak of `a^2 / 2`.
    pub power: Vec<Vec<f64>>,
}

fn refuse<T>(text: String) -> Result<T, SignalError> {
    Err(SignalError::Option(text))
}

/// Formats a number with four digits.
fn shown(value: f64) -> String {
    significant(value)
}

impl Spectrogram {
    /// Analyses a signal after subtraction of its mean.
    ///
    /// # Errors
    /// Returns an error if the signal is constant or too long, or if the parameters do not fit it.
    pub fn new(signal: Signal, asked: &Asked) -> Result<Self, SignalError> {
        let count = signal.samples.len();
        if count > MAX_SAMPLES {
            return refuse(format!("{count} samples are more than {MAX_SAMPLES}: choose a part with --from-s and --to-s"));
        }
        let mean = signal.samples.iter().sum::<f64>() / count as f64;
        let swing: Vec<f64> = signal.samples.iter().map(|sample| sample - mean).collect();
        if swing.iter().all(|swing| swing.abs() <= CONSTANT_REL * mean.abs()) {
            return refuse(format!("`{}` is constant, {}: its spectrum is empty", signal.name, shown(mean)));
        }
        let half_hz = 0.5 * signal.sample_hz();
        let least_hz = 1.0 / signal.duration_s();
        let band = match asked.band_hz {
            Some((from, to)) if !(from >= 0.0 && from < to) => {
                return refuse(format!("--band {from}:{to} is not a band: give the lower frequency first, in Hz"));
            }
            Some((from, to)) if from >= half_hz || to - from < least_hz => {
                return refuse(format!(
                    "--band {from}:{to} is empty: at {} Hz the frequencies go up to {} Hz, and the resolution of {} s is {} Hz",
                    shown(signal.sample_hz()),
                    shown(half_hz),
                    shown(signal.duration_s()),
                    shown(least_hz)
                ));
            }
            Some((from, to)) => (from, to.min(half_hz)),
            None => (0.0, half_hz),
        };
        let foreign = |given: bool, option: &str, method: Method| {
            if given && asked.method != method {
                refuse(format!("{option} belongs to --method {method}, and has no effect with {}", asked.method))
            } else {
                Ok(())
            }
        };
        foreign(asked.window_s.is_some(), "--window-s", Method::Stft)?;
        foreign(asked.cycles.is_some(), "--cycles", Method::Wavelet)?;
        foreign(asked.smooth_s.is_some(), "--smooth-s", Method::WignerVille)?;
        match asked.method {
            Method::Stft => short_time(signal, &swing, asked.window_s, band),
            Method::Wavelet => wavelets(signal, &swing, asked.cycles, band),
            Method::WignerVille => distribution(signal, &swing, asked.smooth_s, band),
        }
    }

    /// Returns time, s, frequency, Hz, and power of the strongest cell.
    pub fn strongest(&self) -> (f64, f64, f64) {
        let cells = self
            .power
            .iter()
            .zip(&self.times_s)
            .flat_map(|(column, &time_s)| column.iter().zip(&self.hz).map(move |(&power, &hz)| (time_s, hz, power)));
        cells.fold((0.0, 0.0, f64::NEG_INFINITY), |best, cell| if cell.2 > best.2 { cell } else { best })
    }

    /// Returns the map as a figure, in dB relative to the strongest cell.
    pub fn figure(&self) -> Figure {
        let peak = self.strongest().2;
        let decibel = |power: f64| (100.0 * 10.0 * (power.max(peak * 1e-12) / peak).log10()).round() / 100.0;
        let edge = |values: &[f64], step: f64| (values[0] - 0.5 * step, values[values.len() - 1] + 0.5 * step);
        let step = |values: &[f64]| {
            if values.len() > 1 { (values[values.len() - 1] - values[0]) / (values.len() - 1) as f64 } else { 1.0 }
        };
        let log = self.method == Method::Wavelet;
        let y = if log {
            let ratio = (self.hz[self.hz.len() - 1] / self.hz[0]).powf(0.5 / (self.hz.len() - 1).max(1) as f64);
            (self.hz[0] / ratio, self.hz[self.hz.len() - 1] * ratio)
        } else {
            edge(&self.hz, step(&self.hz))
        };
        Figure {
            id: format!("spectrum-{}", self.method),
            title: format!("{} over time and frequency", self.signal.name),
            caption: self.how.iter().map(|(what, value)| format!("{what}: {value}.")).collect::<Vec<_>>().join(" "),
            x: Axis { label: "time [s]".into(), ..Axis::default() },
            y: Axis { label: "frequency [Hz]".into(), log, ..Axis::default() },
            map: Some(HeatMap {
                x: edge(&self.times_s, step(&self.times_s)),
                y,
                columns: self.power.iter().map(|column| column.iter().map(|&power| decibel(power)).collect()).collect(),
                range: (-COLOUR_RANGE_DB, 0.0),
                label: "power [dB]".into(),
                csv_column: "power_db".into(),
                ..HeatMap::default()
            }),
            ..Figure::default()
        }
    }

    /// Returns a table with the signal and the method.
    pub fn table(&self, source: &str) -> TableBlock {
        let (time_s, hz, power) = self.strongest();
        let row = |what: &str, value: String| vec![what.to_owned(), value];
        let mut rows = vec![
            row("file", source.to_owned()),
            row("column", self.signal.name.clone()),
            row(
                "samples",
                format!(
                    "{}, from {} s at {} Hz",
                    self.signal.samples.len(),
                    shown(self.signal.start_s),
                    shown(self.signal.sample_hz())
                ),
            ),
            row("method", self.method.to_string()),
        ];
        rows.extend(self.signal.remark.iter().map(|remark| row("times", remark.clone())));
        rows.extend(self.how.iter().map(|(what, value)| row(what, value.clone())));
        rows.push(row("strongest", format!("{} Hz at {} s", shown(hz), shown(time_s))));
        rows.push(row(
            "its power",
            format!("{}, as of a sine of amplitude {}", shown(power), shown((2.0 * power.max(0.0)).sqrt())),
        ));
        if self.method == Method::WignerVille {
            // The distribution is a density: its value depends on the windows.
            rows.pop();
        }
        TableBlock::new("spectrum", "Spectrum over time", "", &["", ""], rows)
    }

    /// Returns the report.
    pub fn report(&self, source: &str) -> Report {
        Report {
            title: format!("{} over time and frequency", self.signal.name),
            subtitle: format!("Source: {source}"),
            tables: vec![self.table(source)],
            figures: vec![self.figure()],
            ..Report::default()
        }
    }

    /// Returns the summary as JSON.
    pub fn json(&self, source: &str) -> Value {
        let (time_s, hz, power) = self.strongest();
        json!({
            "file": source, "column": self.signal.name, "samples": self.signal.samples.len(), "start_s": self.signal.start_s,
            "sample_hz": self.signal.sample_hz(), "method": self.method.to_string(),
            "how": self.how.iter().map(|(what, value)| (what.clone(), json!(value))).collect::<serde_json::Map<_, _>>(),
            "times": self.times_s.len(), "frequencies": self.hz.len(),
            "strongest": { "time_s": time_s, "frequency_hz": hz, "power": power },
        })
    }
}

/// Returns the range of a map's rows within a band.
fn within(rows: usize, bin_hz: f64, band: (f64, f64)) -> Result<std::ops::Range<usize>, SignalError> {
    let first = (band.0 / bin_hz).ceil() as usize;
    let end = ((band.1 / bin_hz).floor() as usize + 1).min(rows);
    if end < first + 2 {
        return refuse(format!("--band {}:{} is narrower than two rows of {} Hz", shown(band.0), shown(band.1), shown(bin_hz)));
    }
    Ok(first..end)
}

/// Cuts a map to a band. If there are too many rows, the strongest of each group of neighbours is
/// used.
fn cut(
    signal: Signal,
    method: Method,
    how: Vec<(String, String)>,
    map: &report::time_frequency::Map,
    band: (f64, f64),
) -> Result<Spectrogram, SignalError> {
    let rows = within(map.columns.first().map_or(0, Vec::len), map.bin_hz, band)?;
    let group = rows.len().div_ceil(MAX_ROWS);
    let strongest = |column: &Vec<f64>| {
        column[rows.clone()].chunks(group).map(|rows| rows.iter().copied().fold(f64::NEG_INFINITY, f64::max)).collect()
    };
    let hz = rows.clone().step_by(group).map(|row| (row as f64 + 0.5 * (group - 1) as f64) * map.bin_hz).collect();
    let times_s = (0..map.columns.len()).map(|column| signal.start_s + map.time_s(column)).collect();
    Ok(Spectrogram { method, how, times_s, hz, power: map.columns.iter().map(strongest).collect(), signal })
}

fn short_time(signal: Signal, swing: &[f64], window_s: Option<f64>, band: (f64, f64)) -> Result<Spectrogram, SignalError> {
    let count = swing.len();
    let given = window_s.map(|seconds| (seconds / signal.sample_s).round());
    if let Some(window) = given.filter(|window| !(8.0..=(count / 2) as f64).contains(window)) {
        return refuse(format!(
            "a window of {} s has {window} samples: it must have at least 8, and at most half of all {count} ({} s)",
            shown(window_s.unwrap_or_default()),
            shown(signal.sample_s * (count / 2) as f64)
        ));
    }
    // A sixteenth of the signal, within the usual limits.
    let usual = || (count / 16).next_power_of_two().clamp(32, 4096).min(count / 2);
    let window = given.map_or_else(usual, |window| window as usize) & !1;
    let hop = (count - window).div_ceil(MAX_COLUMNS).max(1);
    let map = stft(swing, signal.sample_s, window, hop);
    let seconds = window as f64 * signal.sample_s;
    let how = vec![
        ("window".to_owned(), format!("Hann, {window} samples, {} s, every {hop} samples", shown(seconds))),
        ("resolution".to_owned(), format!("{} s and {} Hz", shown(0.5 * seconds), shown(2.0 / seconds))),
    ];
    cut(signal, Method::Stft, how, &map, band)
}

fn wavelets(signal: Signal, swing: &[f64], cycles: Option<f64>, band: (f64, f64)) -> Result<Spectrogram, SignalError> {
    let morlet = cycles.map_or_else(Morlet::default, |cycles| Morlet { centre: std::f64::consts::TAU * cycles });
    if !(5.0..=200.0).contains(&morlet.centre) {
        return refuse(format!(
            "--cycles {} must be from 0.8 to 31: fewer are not a wave, and more are better analysed by --method stft",
            shown(cycles.unwrap_or_default())
        ));
    }
    // At the lowest frequency the signal is twice as long as the wavelet's cycles.
    let cycles = morlet.centre / std::f64::consts::TAU;
    let lowest = 2.0 * cycles / signal.duration_s();
    let from = if band.0 > 0.0 { band.0 } else { lowest.max(band.1 / 1000.0) };
    if from >= band.1 {
        return refuse(format!("wavelets over {} s show nothing below {} Hz", shown(signal.duration_s()), shown(lowest)));
    }
    let hop = swing.len().div_ceil(MAX_COLUMNS).max(1);
    let map = wavelet(swing, signal.sample_s, morlet, &ratios(from, band.1, WAVELET_ROWS), hop);
    let how = vec![
        ("wavelet".to_owned(), format!("Morlet, {} cycles (angular centre frequency {})", shown(cycles), shown(morlet.centre))),
        (
            "resolution".to_owned(),
            format!("{} % of a frequency, and {} of its periods", shown(100.0 / morlet.centre), shown(cycles)),
        ),
        ("near both ends".to_owned(), format!("weaker within {} periods", shown(std::f64::consts::SQRT_2 * cycles))),
    ];
    let times_s = (0..map.columns.len()).map(|column| signal.start_s + map.first_s + column as f64 * map.every_s).collect();
    Ok(Spectrogram { method: Method::Wavelet, how, times_s, hz: map.hz, power: map.columns, signal })
}

fn distribution(signal: Signal, swing: &[f64], smooth_s: Option<f64>, band: (f64, f64)) -> Result<Spectrogram, SignalError> {
    let count = swing.len();
    let most = 0.25 * signal.duration_s();
    if let Some(seconds) = smooth_s.filter(|seconds| !(0.0..=most).contains(seconds)) {
        return refuse(format!("--smooth-s {} must be from 0 to a quarter of the signal, {} s", shown(seconds), shown(most)));
    }
    let lags = MAX_LAGS.min(count / 4).max(16);
    let times =
        smooth_s.map_or_else(|| (count / 40).clamp(5, 101), |seconds| (seconds / signal.sample_s).round().max(1.0) as usize) | 1;
    let rows = (2 * lags).next_power_of_two();
    let hop = count.div_ceil(MAX_COLUMNS).max(1);
    let map = wigner_ville(swing, signal.sample_s, Smoothing { rows, lags: Some(lags), times, hop });
    let of_times =
        if times > 1 { format!("{times} samples, {} s", shown(times as f64 * signal.sample_s)) } else { "none".to_owned() };
    let apart = 2.0 / (times as f64 * signal.sample_s);
    let terms = if times > 1 {
        format!("removed between components more than about {} Hz apart; the rest oscillates about zero", shown(apart))
    } else {
        "kept: a third term is halfway between any two components, and oscillates about zero".to_owned()
    };
    let how = vec![
        ("lag window".to_owned(), format!("Hann, {} samples to either side", lags)),
        ("time window".to_owned(), of_times),
        ("cross terms".to_owned(), terms),
    ];
    cut(signal, Method::WignerVille, how, &map, band)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_S: f64 = 1e-5;

    fn signal(count: usize, value: impl Fn(f64) -> f64) -> Signal {
        let samples = (0..count).map(|n| value(n as f64 * SAMPLE_S)).collect();
        Signal { name: "force_n".into(), start_s: 1.0, sample_s: SAMPLE_S, samples, remark: None }
    }

    fn asked(method: Method) -> Asked {
        Asked { method, window_s: None, cycles: None, smooth_s: None, band_hz: None }
    }

    /// Tone of 8 kHz from 10 to 30 ms, added to a much larger mean.
    fn tone() -> Signal {
        signal(4000, |t| 100.0 + if (0.01..0.03).contains(&t) { 0.5 * (std::f64::consts::TAU * 8e3 * t).sin() } else { 0.0 })
    }

    #[test]
    fn every_method_locates_a_tone() {
        for method in [Method::Stft, Method::Wavelet, Method::WignerVille] {
            let found = Spectrogram::new(tone(), &asked(method)).unwrap();
            let (time_s, hz, power) = found.strongest();
            assert!((1.009..1.031).contains(&time_s), "{method}: {time_s}");
            assert!((hz / 8e3 - 1.0).abs() < 0.03, "{method}: {hz}");
            if method != Method::WignerVille {
                assert!((power / 0.125 - 1.0).abs() < 0.05, "{method}: {power}");
            }
            // Before the tone the map is empty.
            let early = found.times_s.iter().position(|&time_s| time_s > 1.004).unwrap();
            let before = found.power[early].iter().copied().fold(0.0, f64::max);
            assert!(before < 1e-3 * power, "{method}: {before}");
            assert_eq!((found.power.len(), found.power[0].len()), (found.times_s.len(), found.hz.len()));
        }
    }

    #[test]
    fn the_map_is_limited_to_the_band() {
        for method in [Method::Stft, Method::Wavelet, Method::WignerVille] {
            let found = Spectrogram::new(tone(), &Asked { band_hz: Some((5e3, 12e3)), ..asked(method) }).unwrap();
            assert!(found.hz.iter().all(|hz| (4999.0..=12001.0).contains(hz)), "{method}");
            assert!(found.hz.len() > 10, "{method}: {}", found.hz.len());
        }
    }

    #[test]
    fn refusals_state_the_permitted_values() {
        let refused = |signal: Signal, asked: &Asked| Spectrogram::new(signal, asked).unwrap_err().to_string();
        let stft = asked(Method::Stft);
        assert_eq!(refused(signal(100, |_| 5.0), &stft), "`force_n` is constant, 5: its spectrum is empty");
        let long = Asked { window_s: Some(0.03), ..stft };
        assert!(
            refused(tone(), &long).contains("3000 samples: it must have at least 8, and at most half of all 4000"),
            "{}",
            refused(tone(), &long)
        );
        let above = Asked { band_hz: Some((60e3, 70e3)), ..stft };
        assert!(refused(tone(), &above).contains("the frequencies go up to 50000 Hz"), "{}", refused(tone(), &above));
        let turned = Asked { band_hz: Some((2e3, 1e3)), ..stft };
        assert!(refused(tone(), &turned).contains("the lower frequency first"));
        let foreign = Asked { cycles: Some(3.0), ..stft };
        assert_eq!(refused(tone(), &foreign), "--cycles belongs to --method wavelet, and has no effect with stft");
        let few = Asked { cycles: Some(0.1), ..asked(Method::Wavelet) };
        assert!(refused(tone(), &few).contains("from 0.8 to 31"));
    }
}
