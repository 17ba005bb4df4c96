//! Signals from files: one column of a trace, a capture or any other table, evenly sampled.
//!
//! ```text
//! CSV or other delimited text, NPY, NPZ, Parquet, WAV -> columns by name -> samples and sample time, or an error -> time and frequency
//! ```

pub mod spectrogram;
mod table;
#[cfg(test)]
mod tests;

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
