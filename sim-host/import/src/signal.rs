//! Signals from files: one column of a trace, a capture or any other table, evenly sampled.
//!
//! ```text
//! CSV or other delimited text, NPY, NPZ, Parquet, WAV -> columns by name -> samples and sample time, or an error -> time and frequency
//! ```

pub mod spectrogram;
mod table;

use std::path::{Path, PathBuf};

use columns::file;
pub use table::Columns;

/// Minimum number of samples of a signal.
pub const MIN_SAMPLES: usize = 64;
/// Largest step of times without a unit that are taken as seconds: as milliseconds, a sampling rate
/// above 100 MHz would follow.
const MAX_STEP_WITHOUT_UNIT: f64 = 1e-5;
/// Largest deviation of a time step from the mean step, relative.
const MAX_STEP_ERROR_REL: f64 = 0.01;

/// Reason why a file does not contain the signal.
#[derive(Debug, thiserror::Error)]
pub enum SignalError {
    /// The file cannot be read.
    #[error("{} cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Reason given by the system.
        source: std::io::Error,
    },
    /// The file has no known format.
    #[error("{}: {why}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// Error of the file.
        why: String,
    },
    /// No column of the file has this name.
    #[error("{} has no column `{name}`: {known}", path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// Requested name.
        name: String,
        /// Nearest name, and the existing names.
        known: String,
    },
    /// A cell is not a number.
    #[error("{}, {place}: `{name}` is {what}, but a signal needs a number in every row", path.display())]
    Cell {
        /// The file.
        path: PathBuf,
        /// Line or row.
        place: String,
        /// Name of the column.
        name: String,
        /// Content of the cell.
        what: String,
    },
    /// The times of the samples are not given.
    #[error(
        "{} does not contain the times of its samples: name the column of times with --time, or give the sampling rate with \
         --sample-hz ({columns})",
        path.display()
    )]
    Time {
        /// The file.
        path: PathBuf,
        /// Existing columns.
        columns: String,
    },
    /// The column of times has a unit that is not one of time.
    #[error("{}: the unit `{unit}` of `{name}` is not a unit of time; known are s, ms, us, ns, min and h", path.display())]
    Unit {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        name: String,
        /// Unit as in the file.
        unit: String,
    },
    /// The column of times has no unit.
    #[error(
        "unit missing: {}: the times `{name}` have no unit; give it with the column, as in `--time \"{name} [ms]\"`",
        path.display()
    )]
    UnitMissing {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        name: String,
    },
    /// The samples are not evenly spaced.
    #[error(
        "uneven sampling: {}, {place}: a step of {step_s:e} s, but the mean step is {mean_s:e} s; resample the signal evenly, or \
         give the rate with --sample-hz if the times are wrong",
        path.display()
    )]
    Uneven {
        /// The file.
        path: PathBuf,
        /// Line or row.
        place: String,
        /// Time step at this line or row, s.
        step_s: f64,
        /// Mean step, s.
        mean_s: f64,
    },
    /// The signal has too few samples.
    #[error("too few samples: {count}{part}; at least {MIN_SAMPLES} are needed to distinguish frequencies")]
    TooFew {
        /// Number of samples.
        count: usize,
        /// Part of the file, if not the whole file.
        part: String,
    },
    /// An option does not fit the signal.
    #[error("{0}")]
    Option(String),
}

/// Choice of a signal in a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Choice {
    /// Name of the column, or its number from 1.
    pub column: Option<String>,
    /// Name of the column of times, or its number; by default the first column with a name of a
    /// time.
    pub time: Option<String>,
    /// Sampling rate, Hz, instead of a column of times.
    pub sample_hz: Option<f64>,
    /// Beginning of the part to use, s.
    pub from_s: Option<f64>,
    /// End of the part to use, s.
    pub to_s: Option<f64>,
}

/// Evenly sampled signal.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Name of the column.
    pub name: String,
    /// Time of the first sample, s.
    pub start_s: f64,
    /// Sampling interval, s.
    pub sample_s: f64,
    /// Samples.
    pub samples: Vec<f64>,
    /// Inferred unit of the times, and omitted rows, if there are any.
    pub remark: Option<String>,
}

impl Signal {
    /// Reads a signal from a file.
    ///
    /// # Errors
    /// Returns an error with the line if the file does not contain the signal.
    pub fn read(path: &Path, choice: &Choice) -> Result<Self, SignalError> {
        let bytes =
            file::read(path, file::MAX_DATA_BYTES).map_err(|source| SignalError::Unreadable { path: path.to_owned(), source })?;
        let columns = Columns::parse(path, &bytes)?;
        Self::from_columns(path, &columns, choice)
    }

    /// Reads a signal from a table.
    ///
    /// # Errors
    /// Returns the errors of [`Signal::read`].
    pub fn from_columns(path: &Path, columns: &Columns, choice: &Choice) -> Result<Self, SignalError> {
        if let Some(hz) = choice.sample_hz.filter(|hz| !(*hz > 0.0 && hz.is_finite())) {
            return Err(SignalError::Option(format!("--sample-hz {hz} is not a sampling rate: it must be above zero")));
        }
        let time = match (&choice.time, choice.sample_hz) {
            (_, Some(_)) => None,
            (Some(name), None) => Some(columns.place(path, name)?),
            (None, None) => columns.time(),
        };
        let place = match &choice.column {
            Some(name) => columns.place(path, name)?,
            None => columns.only(path, time)?,
        };
        let rows = columns.span(place);
        let samples = columns.numbers(path, place, &rows)?;
        let (start_s, sample_s, remark) = match (choice.sample_hz, time) {
            (Some(hz), _) => (0.0, 1.0 / hz, None),
            (None, Some(time)) => {
                let unit_s = columns.time_unit_s(path, time, choice.time.as_deref())?;
                let times = columns.numbers(path, time, &rows)?;
                let (start_s, sample_s) = even(path, columns, rows.start, &times, unit_s.unwrap_or(1.0))?;
                let name = columns.name(time);
                if unit_s.is_none() && sample_s > MAX_STEP_WITHOUT_UNIT {
                    return Err(SignalError::UnitMissing { path: path.to_owned(), name: name.to_owned() });
                }
                let inferred = || format!("`{name}` has no unit: s is assumed, as ms would be a sampling rate above 100 MHz");
                (start_s, sample_s, unit_s.is_none().then(inferred))
            }
            (None, None) => return Err(SignalError::Time { path: path.to_owned(), columns: columns.listed() }),
        };
        let empty = columns.rows() - rows.len();
        let cut = (empty > 0).then(|| format!("{empty} rows at the ends, in which the column is empty, are left out"));
        let remarks: Vec<String> = remark.into_iter().chain(cut).collect();
        let remark = (!remarks.is_empty()).then(|| remarks.join("; "));
        let whole = Signal { name: columns.name(place).to_owned(), start_s, sample_s, samples, remark };
        whole.part(choice)
    }

    /// Returns the part of the signal between the chosen times.
    fn part(self, choice: &Choice) -> Result<Self, SignalError> {
        let last_s = self.start_s + self.sample_s * self.samples.len().saturating_sub(1) as f64;
        let (from_s, to_s) = (choice.from_s.unwrap_or(self.start_s), choice.to_s.unwrap_or(last_s));
        if from_s >= to_s || from_s > last_s || to_s < self.start_s {
            let asked = format!("from {from_s} s to {to_s} s");
            return Err(SignalError::Option(format!(
                "no samples {asked}: the samples are from {} s to {last_s} s",
                self.start_s
            )));
        }
        let number = |s: f64| ((s - self.start_s) / self.sample_s).max(0.0);
        let first = (number(from_s) - 1e-6).ceil().max(0.0) as usize;
        let end = ((number(to_s) + 1e-6).floor() as usize + 1).min(self.samples.len());
        let samples = self.samples.get(first..end).unwrap_or_default().to_vec();
        if samples.len() < MIN_SAMPLES {
            let part = if samples.len() < self.samples.len() { format!(" from {from_s} s to {to_s} s") } else { String::new() };
            return Err(SignalError::TooFew { count: samples.len(), part });
        }
        Ok(Signal { start_s: self.start_s + first as f64 * self.sample_s, samples, ..self })
    }

    /// Returns the sampling rate, Hz.
    pub fn sample_hz(&self) -> f64 {
        1.0 / self.sample_s
    }

    /// Returns the duration, s.
    pub fn duration_s(&self) -> f64 {
        self.sample_s * self.samples.len() as f64
    }
}

/// Returns the first time and the step, s, if the times are evenly spaced.
fn even(path: &Path, columns: &Columns, first_row: usize, times: &[f64], scale: f64) -> Result<(f64, f64), SignalError> {
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return Err(SignalError::TooFew { count: 0, part: String::new() });
    };
    if times.len() < 2 {
        return Err(SignalError::TooFew { count: times.len(), part: String::new() });
    }
    let mean = (last - first) / (times.len() - 1) as f64;
    // Times with few digits are rounded. The errors of rounding do not accumulate.
    let off = |n: usize| (times[n] - first - mean * n as f64).abs();
    let uneven = (1..times.len()).find(|&n| {
        let step = times[n] - times[n - 1];
        let is_even = (step - mean).abs() <= MAX_STEP_ERROR_REL * mean.abs();
        // Late times have few binary digits left.
        let resolution = 4.0 * f64::EPSILON * times[n].abs();
        let is_rounded = || {
            off(n) <= resolution && off(n - 1) <= resolution
                || step > 0.0 && off(n) <= 0.5 * mean && off(n - 1) <= 0.5 * mean && rounded(times, mean)
        };
        !is_even && !is_rounded()
    });
    if let Some(n) = uneven.or((mean <= 0.0).then_some(1)) {
        let step_s = scale * (times[n] - times[n - 1]);
        if step_s <= 0.0 {
            let why = format!("{}: the time does not increase here", columns.at(first_row + n));
            return Err(SignalError::Form { path: path.to_owned(), why });
        }
        return Err(SignalError::Uneven {
            path: path.to_owned(),
            place: columns.at(first_row + n),
            step_s,
            mean_s: scale * mean,
        });
    }
    Ok((scale * first, scale * mean))
}

/// Returns `true` if rounding explains the deviations from even steps. The digit of rounding must
/// be at most a step, all times must be multiples of it, and the steps must be two neighbouring
/// multiples.
fn rounded(times: &[f64], mean: f64) -> bool {
    let digit = 10f64.powf(mean.log10().floor());
    [digit, 0.1 * digit].into_iter().any(|digit| {
        let whole = |time: f64| (time / digit - (time / digit).round()).abs() < 1e-6;
        let steps = times.windows(2).map(|pair| ((pair[1] - pair[0]) / digit).round());
        let (least, most) =
            steps.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), step| (least.min(step), most.max(step)));
        times.iter().all(|&time| whole(time)) && most - least <= 1.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(text: &str) -> Columns {
        Columns::parse(Path::new("a.csv"), text.as_bytes()).unwrap_or_else(|error| panic!("{error}"))
    }

    fn table(step: impl Fn(usize) -> f64, rows: usize) -> String {
        let rows: String = (0..rows).map(|n| format!("{},{},Run\n", step(n), n * n)).collect();
        format!("time_ms,force_n,mode\n{rows}")
    }

    fn signal(text: &str, choice: &Choice) -> Result<Signal, SignalError> {
        Signal::from_columns(Path::new("a.csv"), &columns(text), choice)
    }

    fn force() -> Choice {
        Choice { column: Some("force_n".into()), ..Choice::default() }
    }

    #[test]
    fn a_column_is_read_with_its_times() {
        let signal = signal(&table(|n| 2.0 + 0.5 * n as f64, 100), &force()).unwrap();
        assert_eq!((signal.name.as_str(), signal.samples.len(), signal.samples[3]), ("force_n", 100, 9.0));
        assert!((signal.start_s - 2e-3).abs() < 1e-15 && (signal.sample_s - 0.5e-3).abs() < 1e-15);
    }

    #[test]
    fn a_part_is_cut_out() {
        let choice = Choice { from_s: Some(10e-3), to_s: Some(80e-3), ..force() };
        let signal = signal(&table(|n| n as f64, 100), &choice).unwrap();
        assert_eq!((signal.samples.len(), signal.samples[0]), (71, 100.0));
        assert!((signal.start_s - 10e-3).abs() < 1e-12);
    }

    #[test]
    fn rounded_times_count_as_even() {
        // 781.25 ns, written with nine decimals.
        let text = |n: usize| (n as f64 * 0.78125e-3 * 1e6).round() / 1e6;
        let signal = signal(&table(text, 2000), &force()).unwrap();
        assert!((signal.sample_hz() - 1.28e6).abs() < 10.0, "{}", signal.sample_hz());
    }

    #[test]
    fn refusals_state_the_reason_and_the_place() {
        let refused = |text: &str, choice: &Choice| signal(text, choice).unwrap_err().to_string();
        let even = table(|n| n as f64, 100);
        let named = |name: &str| Choice { column: Some(name.into()), ..Choice::default() };
        assert_eq!(
            refused(&even, &named("forc_n")),
            "a.csv has no column `forc_n`: did you mean `force_n`? It has time_ms, force_n, mode"
        );
        assert_eq!(refused(&even, &named("mode")), "a.csv, line 2: `mode` is `Run`, but a signal needs a number in every row");
        let jump = table(|n| n as f64 + if n > 50 { 0.5 } else { 0.0 }, 100);
        assert!(
            refused(&jump, &force()).starts_with("uneven sampling: a.csv, line 53: a step of 1.5e-3 s"),
            "{}",
            refused(&jump, &force())
        );
        let back = table(|n| if n == 10 { 8.0 } else { n as f64 }, 100);
        assert!(
            refused(&back, &force()).starts_with("a.csv: line 12: the time does not increase"),
            "{}",
            refused(&back, &force())
        );
        assert!(refused(&table(|n| n as f64, 63), &force()).starts_with("too few samples: 63; at least 64"));
        let late = Choice { from_s: Some(1.0), ..force() };
        assert_eq!(refused(&even, &late), "no samples from 1 s to 0.099 s: the samples are from 0 s to 0.099 s");
        assert!(refused("a,b\n1,2\n2,3\n", &named("b")).contains("--sample-hz (a, b)"));
        let bare = even.replace("time_ms", "time");
        assert!(refused(&bare, &force()).contains("unit missing: a.csv: the times `time` have no unit"));
        let given = Choice { time: Some("time [ms]".into()), ..force() };
        assert_eq!(signal(&bare, &given).unwrap().sample_s, signal(&even, &force()).unwrap().sample_s);
        let hole = even.replace("20,400,Run", "20,,Run");
        assert_eq!(refused(&hole, &force()), "a.csv, line 22: `force_n` is empty, but a signal needs a number in every row");
    }

    /// Layouts of Keysight, PicoScope, Digilent WaveForms, Tektronix (TDS, MSO) and Siglent, as in
    /// public repositories.
    #[test]
    fn files_of_oscilloscopes_are_read() {
        type Row = fn(usize) -> String;
        let layouts: [(&str, Row, Choice); 6] = [
            ("x-axis,1,2\nsecond,Ampere,Volt\n", |n| format!("{:.6E},{n}.5,0\n", n as f64 * 1e-6), Choice::default()),
            ("Time,Channel A\n(ms),(V)\n\n", |n| format!("{:.8},{n}.5\n", n as f64 * 1e-3), Choice::default()),
            (
                "#Digilent WaveForms Oscilloscope Acquisition\n#Samples: 99\n\nTime (s),Channel 1 (V)\n",
                |n| format!("{:.3e},{n}.5\n", n as f64 * 1e-6),
                Choice::default(),
            ),
            (
                "Record Length,2.5e+03,,0,0.5,\nVertical Units,V,,1e-6,1.5,\n",
                |n| format!(",,,{:.9},{n}.5,\n", (n + 2) as f64 * 1e-6),
                Choice { time: Some("1".into()), ..Choice::default() },
            ),
            (
                "Model,MSO4034\n\nRecord Length,99\nVertical Units,V,\n\nTIME,CH1\n",
                |n| format!("{:.4e},{n}.5\n", n as f64 * 1e-6),
                Choice::default(),
            ),
            (
                "Sample Interval,CH1:1.00E-06\nModel Number,SDS1104X-E\nSource,CH1\nSecond,Volt\n",
                |n| format!("{:.11},{n}.5\n", n as f64 * 1e-6),
                Choice::default(),
            ),
        ];
        for (head, row, choice) in layouts {
            let rows: String = (0..99).map(row).collect();
            let found = signal(&format!("{head}{rows}"), &Choice { column: Some("2".into()), ..choice });
            let found = found.unwrap_or_else(|error| panic!("{head}: {error}"));
            assert!((found.sample_s - 1e-6).abs() < 1e-11, "{head}: {}", found.sample_s);
        }
        // The first samples of a channel may be missing.
        let missing: String = (0..99).map(|n| format!("{n}e-6,{}\n", if n < 3 { "" } else { "0.5" })).collect();
        let found = signal(&format!("x-axis,1\nsecond,Volt\n{missing}"), &Choice::default()).unwrap();
        assert_eq!((found.samples.len(), found.start_s), (96, 3e-6));
        assert!(found.remark.is_some_and(|remark| remark.starts_with("3 rows at the ends")));
    }

    #[test]
    fn a_sampling_rate_replaces_the_times() {
        let text: String = (0..100).map(|n| format!("{n}\n")).collect();
        let signal = signal(&text, &Choice { sample_hz: Some(1e3), ..Choice::default() }).unwrap();
        assert_eq!((signal.sample_s, signal.samples[7]), (1e-3, 7.0));
    }
}
