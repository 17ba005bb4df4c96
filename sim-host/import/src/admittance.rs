//! Equivalent circuit of a measured admittance: [`import`].

pub(crate) mod bounds;
pub mod circuit;
pub mod coordinate;
mod figures;
mod fit;
pub mod fixture;
pub mod measured;
mod memory;
pub mod options;
mod passivity;
mod result;
mod samples;
mod scene_file;
mod start;
mod sweep;
mod table;
mod topology;
mod weights;

use std::path::Path;

use crate::error::ImportError;
pub use fit::MOST_MODES;
use measured::Measured;
use options::Options;
pub use result::{Admittance, Circuit, Mode, Value};

/// Fits a circuit to a measured file.
///
/// # Errors
/// Returns [`ImportError`], with the line or value that shows the reason.
pub fn import(path: &Path, options: &Options) -> Result<Admittance, ImportError> {
    let mut measured = Measured::read(path, options)?;
    fixture::correct(&mut measured, options)?;
    let name = path.file_stem().map_or_else(|| "transducer".into(), |stem| stem.to_string_lossy().into_owned());
    let fit = fit::Fitter::new(&measured).fit(options.modes)?;
    Admittance::from_fit(name, measured, fit, options.mode)
}

/// Fits a circuit to a sweep, with this number of resonances, or with the number that the data
/// show.
///
/// # Errors
/// Returns [`ImportError`] if the sweep has no resonance, or too few points.
pub fn fit(name: &str, measured: Measured, modes: Option<usize>) -> Result<Admittance, ImportError> {
    let fit = fit::Fitter::new(&measured).fit(modes)?;
    Admittance::from_fit(name.to_owned(), measured, fit, None)
}
