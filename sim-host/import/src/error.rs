//! Why measured data are refused: each case by its name, with the line or the values that show it.

use std::path::PathBuf;

use delimited::TableError;

/// Why a measured file gives no parameters.
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
    /// The file has no table of numbers of a known form.
    #[error("not a known form: {seen}")]
    UnknownForm {
        /// What the file contains in place of it, and what would be known.
        seen: String,
    },
    /// A line within the data cannot be used.
    #[error("line {line}: {what}")]
    BadLine {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with it.
        what: String,
    },
    /// A column has neither a unit in its heading nor one by option.
    #[error("unit missing: {column} has no unit; {help}")]
    UnitMissing {
        /// Heading of the column.
        column: String,
        /// How the unit can be given.
        help: String,
    },
    /// An angle may be in degrees or in radians.
    #[error(
        "degrees or radians? The angles in {column} reach {largest} at most, which either could be; say so with `--unit deg` or `--unit rad`"
    )]
    AngleDoubtful {
        /// Heading of the column.
        column: String,
        /// Largest size of an angle, as it stands in the file.
        largest: f64,
    },
    /// Two neighbouring points have the same frequency.
    #[error(
        "neighbouring frequencies are equal: lines {first} and {second} both have {hz} Hz, as an exporter writes that rounds frequencies{step}; \
         export the sweep with more digits, as no resonance can be fitted to points whose frequency is not known"
    )]
    FrequenciesEqual {
        /// Number of the first of the two lines.
        first: usize,
        /// Number of the second.
        second: usize,
        /// The frequency, Hz.
        hz: f64,
        /// What the frequencies seem to be rounded to; may be empty.
        step: String,
    },
    /// The frequencies go up and down.
    #[error("the frequencies are not in order: line {line} goes back to {hz} Hz; give a file with one sweep")]
    FrequenciesUnordered {
        /// Number of the line.
        line: usize,
        /// Frequency of the line, Hz.
        hz: f64,
    },
    /// There are fewer points than a fit needs.
    #[error(
        "too few points: {points}, and a circuit with {modes} resonance(s) has {parameters} parameters and needs {needed} points"
    )]
    TooFewPoints {
        /// Points of the file.
        points: usize,
        /// Resonances of the circuit.
        modes: usize,
        /// Parameters of the circuit.
        parameters: usize,
        /// Least number of points.
        needed: usize,
    },
    /// No resonance stands out of the noise within the sweep.
    #[error("no resonance in the range from {from_hz} to {to_hz} Hz: {why}")]
    NoResonance {
        /// Beginning of the sweep, Hz.
        from_hz: f64,
        /// End of the sweep, Hz.
        to_hz: f64,
        /// How that was seen.
        why: String,
    },
    /// A two-port file does not show how the transducer was connected.
    #[error("series-through or shunt-through? {why}; say so with `--topology series-through` or `--topology shunt-through`")]
    TopologyDoubtful {
        /// What the file shows.
        why: String,
    },
    /// A correction by measurements of the fixture is not possible.
    #[error("the fixture cannot be corrected: {0}")]
    Fixture(String),
    /// The values are those of no passive transducer.
    #[error("not a transducer: {0}")]
    NotATransducer(String),
    /// The fit has found no parameters.
    #[error("no fit: {0}")]
    NoFit(String),
}

impl From<TableError> for ImportError {
    fn from(error: TableError) -> Self {
        let what = error.to_string();
        match error {
            TableError::NoTable { .. } => ImportError::UnknownForm {
                seen: format!(
                    "{what}; known are Touchstone (.s1p, .s2p) and tables of numbers, with commas, semicolons, tabs or blanks between"
                ),
            },
            TableError::OneLine { .. } | TableError::Empty | TableError::NoNumbers => ImportError::UnknownForm { seen: what },
            TableError::Interrupted { line, .. } => {
                ImportError::BadLine { line, what: format!("{what}; mend or remove it, or give one sweep a file") }
            }
            TableError::Width { line, decimal_comma: true, .. } => ImportError::BadLine { line, what },
            TableError::Width { line, .. } => ImportError::BadLine {
                line,
                what: format!("{what}; give the names with `--columns`, as `--columns \"f [Hz], |Z| [ohm], theta [deg]\"`"),
            },
        }
    }
}
