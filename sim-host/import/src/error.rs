//! Reasons why measured data are refused, with the line or the values that show it.

use std::path::{Path, PathBuf};

use columns::{Table, TableError};

/// Reason why no parameters can be determined from a measured file.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file cannot be read.
    #[error("{} cannot be read: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Reason given by the system.
        source: std::io::Error,
    },
    /// One of several files has an error.
    #[error("{file}: {source}")]
    InFile {
        /// Name of the file.
        file: String,
        /// Error of the file.
        source: Box<ImportError>,
    },
    /// The file does not contain a table of numbers in a known format.
    #[error("unknown format: {seen}")]
    UnknownForm {
        /// Content of the file, and the known formats.
        seen: String,
    },
    /// A line of the data cannot be used.
    #[error("line {line}: {what}")]
    BadLine {
        /// Number of the line, from 1.
        line: usize,
        /// Error of the line.
        what: String,
    },
    /// Two columns have the same quantity.
    #[error(
        "the columns `{}` and `{}` have the same quantity; list all columns with `--columns`, and write `-` for the one to ignore",
        columns::beginning(first),
        columns::beginning(second)
    )]
    SameQuantity {
        /// Heading of the first column.
        first: String,
        /// Heading of the other column.
        second: String,
    },
    /// A column has no unit, neither in its heading nor by option.
    #[error("unit missing: {column} has no unit; {help}")]
    UnitMissing {
        /// Heading of the column.
        column: String,
        /// Ways to give the unit.
        help: String,
    },
    /// The unit of a column is unknown, ambiguous, or that of another quantity.
    #[error("the unit `{unit}` of the column `{column}` cannot be used: {help}")]
    UnitUnknown {
        /// Heading of the column.
        column: String,
        /// The unit as in the heading.
        unit: String,
        /// Known units.
        help: String,
    },
    /// An angle may be in degrees or in radians.
    #[error(
        "degrees or radians? The largest angle in {column} is {largest}, which can be either; choose with `--unit deg` or \
         `--unit rad`"
    )]
    AngleDoubtful {
        /// Heading of the column.
        column: String,
        /// Largest magnitude of an angle in the file.
        largest: f64,
    },
    /// Two neighbouring points have the same frequency.
    #[error(
        "neighbouring frequencies are equal: lines {first} and {second} both have {hz} Hz. The exporter has rounded the \
         frequencies{step}; export the sweep with more digits, because a resonance cannot be fitted to rounded frequencies"
    )]
    FrequenciesEqual {
        /// Number of the first of the two lines.
        first: usize,
        /// Number of the second line.
        second: usize,
        /// The frequency, Hz.
        hz: f64,
        /// Step to which the frequencies seem to be rounded; may be empty.
        step: String,
    },
    /// The frequencies rise and fall.
    #[error("the frequencies are not in order: line {line} goes back to {hz} Hz; give a file with one sweep")]
    FrequenciesUnordered {
        /// Number of the line.
        line: usize,
        /// Frequency of the line, Hz.
        hz: f64,
    },
    /// The file has fewer points than a fit needs.
    #[error(
        "too few points: {points}; a circuit with {modes} resonance(s) has {parameters} parameters and needs {needed} points"
    )]
    TooFewPoints {
        /// Number of points of the file.
        points: usize,
        /// Number of resonances of the circuit.
        modes: usize,
        /// Number of parameters of the circuit.
        parameters: usize,
        /// Minimum number of points.
        needed: usize,
    },
    /// No resonance within the sweep exceeds the noise.
    #[error("no resonance in the range from {from_hz} to {to_hz} Hz: {why}")]
    NoResonance {
        /// Beginning of the sweep, Hz.
        from_hz: f64,
        /// End of the sweep, Hz.
        to_hz: f64,
        /// Reason.
        why: String,
    },
    /// The connection of the transducer cannot be determined from a two-port file.
    #[error("series-through or shunt-through? {why}; choose with `--topology series-through` or `--topology shunt-through`")]
    TopologyDoubtful {
        /// Evidence from the file.
        why: String,
    },
    /// A correction by measurements of the fixture is not possible.
    #[error("the fixture cannot be corrected: {0}")]
    Fixture(String),
    /// The chosen mode is not among the resonances of the fit, which are listed.
    #[error("no such mode; the resonances are {0}")]
    NoSuchMode(String),
    /// The values are not those of a passive transducer.
    #[error("not a transducer: {0}")]
    NotATransducer(String),
    /// The fit has not found parameters.
    #[error("no fit: {0}")]
    NoFit(String),
}

impl ImportError {
    /// Returns the error with the file that has it.
    pub(crate) fn of_file(self, path: &Path) -> Self {
        match self {
            ImportError::Unreadable { .. } | ImportError::InFile { .. } => self,
            error => ImportError::InFile { file: path.display().to_string(), source: Box::new(error) },
        }
    }

    /// Returns the error of a row of a table.
    pub(crate) fn bad_row(table: &Table, row: usize, what: String) -> Self {
        match table.lines.get(row) {
            Some(&line) => ImportError::BadLine { line, what },
            None => ImportError::UnknownForm { seen: format!("{}: {what}", table.place(row)) },
        }
    }
}

impl From<TableError> for ImportError {
    fn from(error: TableError) -> Self {
        let what = error.to_string();
        match error {
            TableError::Empty | TableError::NoNumbers { .. } | TableError::Binary(_) | TableError::Long { .. } => {
                ImportError::UnknownForm {
                    seen: format!(
                        "{what}; expected a table with columns of numbers, separated by commas, semicolons, tabs or blanks. An \
                     admittance may also be a Touchstone file (.s1p, .s2p)"
                    ),
                }
            }
            TableError::Interrupted { line, .. } | TableError::Cells { line, .. } => {
                ImportError::BadLine { line, what: format!("{what}; fix or delete the line, or give one sweep per file") }
            }
            TableError::Comma { line, .. } | TableError::Width { line, decimal_comma: true, .. } => {
                ImportError::BadLine { line, what }
            }
            TableError::Width { line, .. } => ImportError::BadLine {
                line,
                what: format!(
                    "{what}; name the columns with `--columns`, such as `--columns \"f [Hz], |Z| [ohm], theta [deg]\"`"
                ),
            },
        }
    }
}
