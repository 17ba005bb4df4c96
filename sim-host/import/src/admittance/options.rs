//! Options for properties that a file does not contain.

use std::path::PathBuf;

use super::coordinate::Topology;
use crate::units::Units;

/// Options of an import.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Reference resistance of scattering parameters in a table, ohm; a Touchstone file has its
    /// own.
    pub z0_ohm: f64,
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
}

impl Default for Options {
    fn default() -> Self {
        Options {
            z0_ohm: 50.0,
            topology: None,
            units: Units::default(),
            columns: None,
            open: None,
            short: None,
            series_ohm: 0.0,
            modes: None,
        }
    }
}
