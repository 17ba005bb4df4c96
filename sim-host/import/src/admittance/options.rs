//! What a file does not say, and the caller may.

use std::path::PathBuf;

use super::coordinate::Topology;
use crate::units::Units;

/// Options of an import.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Reference resistance of scattering parameters in a table, ohm; a Touchstone file has its own.
    pub z0_ohm: f64,
    /// How the transducer was connected to a network analyser; nothing finds out.
    pub topology: Option<Topology>,
    /// Units of columns that name none.
    pub units: Units,
    /// Names of the columns of a table, in place of its heading.
    pub columns: Option<String>,
    /// Measurement of the open fixture.
    pub open: Option<PathBuf>,
    /// Measurement of the shorted fixture.
    pub short: Option<PathBuf>,
    /// Resistance in series with the transducer, which is no part of it, ohm.
    pub series_ohm: f64,
    /// How many resonances to fit; nothing lets the data decide.
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
