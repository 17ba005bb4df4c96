//! Options for properties that a file does not contain.

use std::path::PathBuf;
use std::str::FromStr;

use super::MOST_MODES;
use super::coordinate::Topology;
use crate::units::Units;

/// Choice of the working mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModeChoice {
    /// Number of the mode by frequency, from 1.
    Number(usize),
    /// Frequency near the mode, Hz.
    Near(f64),
}

impl FromStr for ModeChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        /// Smallest frequency of a mode, Hz.
        const MIN_HZ: f64 = 100.0;
        if let Some(number) = text.parse().ok().filter(|number| (1..=MOST_MODES).contains(number)) {
            return Ok(ModeChoice::Number(number));
        }
        let hz = columns::hertz(text).filter(|hz| (MIN_HZ..1e12).contains(hz));
        hz.map(ModeChoice::Near)
            .ok_or_else(|| format!("give the number of a mode from 1 to {MOST_MODES}, or a frequency in Hz, as 40.1k"))
    }
}

/// Options of an import.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Reference resistance of scattering parameters in a table, ohm; a Touchstone file has its
    /// own.
    pub z0_ohm: Option<f64>,
    /// Connection of the transducer to a network analyser; `None` determines it from the data.
    pub topology: Option<Topology>,
    /// Units of columns whose headings have none.
    pub units: Units,
    /// Names of the columns of a table, replacing its heading.
    pub columns: Option<String>,
    /// Measurement of the open fixture.
    pub open: Option<PathBuf>,
    /// Measurement of the shorted fixture.
    pub short: Option<PathBuf>,
    /// Resistance in series with the transducer that is not part of it, ohm.
    pub series_ohm: f64,
    /// Number of resonances to fit; `None` determines it from the data.
    pub modes: Option<usize>,
    /// Working mode; `None` chooses the one with the largest figure of merit.
    pub mode: Option<ModeChoice>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            z0_ohm: None,
            topology: None,
            units: Units::default(),
            columns: None,
            open: None,
            short: None,
            series_ohm: 0.0,
            modes: None,
            mode: None,
        }
    }
}
