//! A signal over time and frequency: by the short-time Fourier transform, by wavelets, or as its Wigner-Ville distribution; as a figure, a table, arrays.

use std::fmt;

use report::time_frequency::{Morlet, Smoothing, ratios, stft, wavelet, wigner_ville};
use report::{Axis, Figure, HeatMap, Report, TableBlock, significant};
use serde_json::{Value, json};

use super::{Signal, SignalError};

/// Most columns of a map.
const COLUMNS: usize = 500;
/// Rows of a wavelet map.
const ROWS: usize = 240;
/// Most rows of a map that is shown: the part of the frequencies beyond is left to --band.
const MOST_ROWS: usize = 1200;
/// Most samples at a time.
const MOST: usize = 1 << 20;
/// Decibels below the strongest cell that have a colour.
const FLOOR_DB: f64 = 60.0;
/// A swing below this part of the mean is rounding.
const STILL: f64 = 1e-12;
/// Samples to each side that a Wigner-Ville distribution looks at, at most.
const LAGS: usize = 1024;

/// How times and frequencies are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Short-time Fourier transform, through Hann windows of one length.
    Stft,
    /// Morlet's wavelets: at each frequency as many cycles.
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

/// What is asked of an analysis; what is absent follows from the signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    /// The method.
    pub method: Method,
    /// Length of a window of the short-time transform, s.
    pub window_s: Option<f64>,
    /// Cycles of a wavelet.
    pub cycles: Option<f64>,
    /// Length of the window of times of the Wigner-Ville distribution, s; zero is none.
    pub smooth_s: Option<f64>,
    /// Lowest and highest frequency, Hz.
    pub band_hz: Option<(f64, f64)>,
}

/// A signal over time and frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrogram {
    /// The signal.
    pub signal: Signal,
    /// The method.
    pub method: Method,
    /// What the method was given, in words, with what it makes indistinct.
    pub how: Vec<(String, String)>,
    /// Times of the columns, s.
    pub times_s: Vec<f64>,
    /// Frequencies of the rows, Hz, rising: evenly, or of wavelets by equal ratios.
    pub hz: Vec<f64>,
    /// For each time, the power at each frequency, in squares of the signal's unit: a sine of amplitude `a` has a peak of `a^2 / 2` in the transforms.
    pub power: Vec<Vec<f64>>,
}

fn refuse<T>(text: String) -> Result<T, SignalError> {
    Err(SignalError::Option(text))
}

/// A number with four digits.
fn shown(value: f64) -> String {
    significant(value)
}

impl Spectrogram {
    /// Analyses a signal about its mean.
    ///
    /// # Errors
    /// If the signal is constant or too long, or the method is asked for what the signal does not have.
    pub fn new(signal: Signal, asked: &Asked) -> Result<Self, SignalError> {
        let count = signal.samples.len();
        if count > MOST {
            return refuse(format!("{count} samples are more than {MOST}: choose a part with --from-s and --to-s"));
        }
        let mean = signal.samples.iter().sum::<f64>() / count as f64;
        let swing: Vec<f64> = signal.samples.iter().map(|sample| sample - mean).collect();
        if swing.iter().all(|swing| swing.abs() <= STILL * mean.abs()) {
            return refuse(format!("`{}` is constant, {}: it has no frequencies", signal.name, shown(mean)));
        }
        let half_hz = 0.5 * signal.sample_hz();
        let least_hz = 1.0 / signal.duration_s();
        let band = match asked.band_hz {
            Some((from, to)) if !(from >= 0.0 && from < to) => {
                return refuse(format!("--band {from}:{to} is no band: the lower frequency comes first, in Hz"));
            }
            Some((from, to)) if from >= half_hz || to - from < least_hz => {
                return refuse(format!(
                    "--band {from}:{to} shows nothing: at {} Hz the frequencies go up to {} Hz, and {} s tell {} Hz apart",
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
                refuse(format!("{option} is of --method {method}, and has no meaning with {}", asked.method))
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

    /// The strongest cell: time, s, frequency, Hz, and power.
    pub fn strongest(&self) -> (f64, f64, f64) {
        let cells = self
            .power
            .iter()
            .zip(&self.times_s)
            .flat_map(|(column, &time_s)| column.iter().zip(&self.hz).map(move |(&power, &hz)| (time_s, hz, power)));
        cells.fold((0.0, 0.0, f64::NEG_INFINITY), |best, cell| if cell.2 > best.2 { cell } else { best })
    }

    /// The map as a figure: in dB of the strongest cell.
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
                range: (-FLOOR_DB, 0.0),
                label: "power [dB]".into(),
                csv_column: "power_db".into(),
            }),
            ..Figure::default()
        }
    }

    /// What was analysed, and how, as a table.
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
        rows.extend(self.how.iter().map(|(what, value)| row(what, value.clone())));
        rows.push(row("strongest", format!("{} Hz at {} s", shown(hz), shown(time_s))));
        rows.push(row("its power", format!("{}, of a sine of amplitude {}", shown(power), shown((2.0 * power.max(0.0)).sqrt()))));
        if self.method == Method::WignerVille {
            // The distribution is a density: its height depends on the windows.
            rows.pop();
        }
        TableBlock::new("spectrum", "Spectrum over time", "", &["", ""], rows)
    }

    /// The report.
    pub fn report(&self, source: &str) -> Report {
        Report {
            title: format!("{} over time and frequency", self.signal.name),
            subtitle: format!("Source: {source}"),
            tables: vec![self.table(source)],
            figures: vec![self.figure()],
            ..Report::default()
        }
    }

    /// The summary as JSON.
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

/// The rows of a map within a band; no more than a picture can show.
fn within(rows: usize, bin_hz: f64, band: (f64, f64)) -> Result<std::ops::Range<usize>, SignalError> {
    let first = (band.0 / bin_hz).ceil() as usize;
    let end = ((band.1 / bin_hz).floor() as usize + 1).min(rows);
    if end < first + 2 {
        return refuse(format!("--band {}:{} is narrower than two rows of {} Hz", shown(band.0), shown(band.1), shown(bin_hz)));
    }
    Ok(first..end)
}

/// What of a map lies in a band, thinned to the strongest of neighbouring rows where there are too many.
fn cut(
    signal: Signal,
    method: Method,
    how: Vec<(String, String)>,
    map: &report::time_frequency::Map,
    band: (f64, f64),
) -> Result<Spectrogram, SignalError> {
    let rows = within(map.columns.first().map_or(0, Vec::len), map.bin_hz, band)?;
    let group = rows.len().div_ceil(MOST_ROWS);
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
            "a window of {} s has {window} samples: it must have 8 at least, and the half of all {count} at most ({} s)",
            shown(window_s.unwrap_or_default()),
            shown(signal.sample_s * (count / 2) as f64)
        ));
    }
    // A sixteenth of the signal, within what is usual.
    let usual = || (count / 16).next_power_of_two().clamp(32, 4096).min(count / 2);
    let window = given.map_or_else(usual, |window| window as usize) & !1;
    let hop = (count - window).div_ceil(COLUMNS).max(1);
    let map = stft(swing, signal.sample_s, window, hop);
    let seconds = window as f64 * signal.sample_s;
    let how = vec![
        ("window".to_owned(), format!("Hann, {window} samples, {} s, every {hop} samples", shown(seconds))),
        ("indistinct by".to_owned(), format!("{} s and {} Hz", shown(0.5 * seconds), shown(2.0 / seconds))),
    ];
    cut(signal, Method::Stft, how, &map, band)
}

fn wavelets(signal: Signal, swing: &[f64], cycles: Option<f64>, band: (f64, f64)) -> Result<Spectrogram, SignalError> {
    let morlet = cycles.map_or_else(Morlet::default, |cycles| Morlet { centre: std::f64::consts::TAU * cycles });
    if !(5.0..=200.0).contains(&morlet.centre) {
        return refuse(format!(
            "--cycles {} must be from 0.8 to 31: fewer are no wave, and more are a window",
            shown(cycles.unwrap_or_default())
        ));
    }
    // The lowest has room for its cycles twice over.
    let cycles = morlet.centre / std::f64::consts::TAU;
    let lowest = 2.0 * cycles / signal.duration_s();
    let from = if band.0 > 0.0 { band.0 } else { lowest.max(band.1 / 1000.0) };
    if from >= band.1 {
        return refuse(format!("of {} s wavelets show nothing below {} Hz", shown(signal.duration_s()), shown(lowest)));
    }
    let hop = swing.len().div_ceil(COLUMNS).max(1);
    let map = wavelet(swing, signal.sample_s, morlet, &ratios(from, band.1, ROWS), hop);
    let how = vec![
        ("wavelet".to_owned(), format!("Morlet, {} cycles (angular centre frequency {})", shown(cycles), shown(morlet.centre))),
        (
            "indistinct by".to_owned(),
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
    let lags = LAGS.min(count / 4).max(16);
    let times =
        smooth_s.map_or_else(|| (count / 40).clamp(5, 101), |seconds| (seconds / signal.sample_s).round().max(1.0) as usize) | 1;
    let rows = (2 * lags).next_power_of_two();
    let hop = count.div_ceil(COLUMNS).max(1);
    let map = wigner_ville(swing, signal.sample_s, Smoothing { rows, lags: Some(lags), times, hop });
    let of_times =
        if times > 1 { format!("{times} samples, {} s", shown(times as f64 * signal.sample_s)) } else { "none".to_owned() };
    let apart = 2.0 / (times as f64 * signal.sample_s);
    let terms = if times > 1 {
        format!("removed between components further apart than some {} Hz; what is left swings about zero", shown(apart))
    } else {
        "kept: a third term stands halfway between any two components, and swings about zero".to_owned()
    };
    let how = vec![
        ("window of lags".to_owned(), format!("Hann, {} samples to either side", lags)),
        ("window of times".to_owned(), of_times),
        ("terms between components".to_owned(), terms),
    ];
    cut(signal, Method::WignerVille, how, &map, band)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE_S: f64 = 1e-5;

    fn signal(count: usize, value: impl Fn(f64) -> f64) -> Signal {
        let samples = (0..count).map(|n| value(n as f64 * SAMPLE_S)).collect();
        Signal { name: "force_n".into(), start_s: 1.0, sample_s: SAMPLE_S, samples }
    }

    fn asked(method: Method) -> Asked {
        Asked { method, window_s: None, cycles: None, smooth_s: None, band_hz: None }
    }

    /// A tone of 8 kHz from 10 to 30 ms on a mean that is far stronger.
    fn tone() -> Signal {
        signal(4000, |t| 100.0 + if (0.01..0.03).contains(&t) { 0.5 * (std::f64::consts::TAU * 8e3 * t).sin() } else { 0.0 })
    }

    #[test]
    fn every_method_finds_a_tone_where_it_is() {
        for method in [Method::Stft, Method::Wavelet, Method::WignerVille] {
            let found = Spectrogram::new(tone(), &asked(method)).unwrap();
            let (time_s, hz, power) = found.strongest();
            assert!((1.009..1.031).contains(&time_s), "{method}: {time_s}");
            assert!((hz / 8e3 - 1.0).abs() < 0.03, "{method}: {hz}");
            if method != Method::WignerVille {
                assert!((power / 0.125 - 1.0).abs() < 0.05, "{method}: {power}");
            }
            // Before the tone there is nothing of it.
            let early = found.times_s.iter().position(|&time_s| time_s > 1.004).unwrap();
            let before = found.power[early].iter().copied().fold(0.0, f64::max);
            assert!(before < 1e-3 * power, "{method}: {before}");
            assert_eq!((found.power.len(), found.power[0].len()), (found.times_s.len(), found.hz.len()));
        }
    }

    #[test]
    fn a_band_is_all_that_is_shown() {
        for method in [Method::Stft, Method::Wavelet, Method::WignerVille] {
            let found = Spectrogram::new(tone(), &Asked { band_hz: Some((5e3, 12e3)), ..asked(method) }).unwrap();
            assert!(found.hz.iter().all(|hz| (4999.0..=12001.0).contains(hz)), "{method}");
            assert!(found.hz.len() > 10, "{method}: {}", found.hz.len());
        }
    }

    #[test]
    fn each_refusal_says_what_would_do() {
        let refused = |signal: Signal, asked: &Asked| Spectrogram::new(signal, asked).unwrap_err().to_string();
        let stft = asked(Method::Stft);
        assert_eq!(refused(signal(100, |_| 5.0), &stft), "`force_n` is constant, 5: it has no frequencies");
        let long = Asked { window_s: Some(0.03), ..stft };
        assert!(
            refused(tone(), &long).contains("3000 samples: it must have 8 at least, and the half of all 4000"),
            "{}",
            refused(tone(), &long)
        );
        let above = Asked { band_hz: Some((60e3, 70e3)), ..stft };
        assert!(refused(tone(), &above).contains("the frequencies go up to 50000 Hz"), "{}", refused(tone(), &above));
        let turned = Asked { band_hz: Some((2e3, 1e3)), ..stft };
        assert!(refused(tone(), &turned).contains("the lower frequency comes first"));
        let foreign = Asked { cycles: Some(3.0), ..stft };
        assert_eq!(refused(tone(), &foreign), "--cycles is of --method wavelet, and has no meaning with stft");
        let few = Asked { cycles: Some(0.1), ..asked(Method::Wavelet) };
        assert!(refused(tone(), &few).contains("from 0.8 to 31"));
    }
}
