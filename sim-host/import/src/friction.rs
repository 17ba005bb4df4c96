//! Contact models fitted to a friction log: [`import`].
//!
//! ```text
//! file -> log (slip, velocity, force, normal force, OFF and ON) -> motion between samples -> fit of each model to the OFF part
//!      -> choice -> contact, friction ratio ON over OFF, scene
//! ```

pub(crate) mod certainty;
pub(crate) mod fit;
mod log;
mod maxwell;
mod models;
pub(crate) mod motion;
pub(crate) mod result;
pub(crate) mod smoothed;
mod start;
mod view;

use std::path::Path;

use crate::error::ImportError;
use columns::file;
pub use log::{Log, Options};
pub use models::Model;
pub use result::{Fitted, Friction};

/// Fits contact models to a measured file.
///
/// # Errors
/// Returns [`ImportError`], with the line or value that shows the reason.
pub fn import(path: &Path, options: &Options) -> Result<Friction, ImportError> {
    let bytes =
        file::read(path, file::MAX_DATA_BYTES).map_err(|source| ImportError::Unreadable { path: path.to_owned(), source })?;
    let name = path.file_stem().map_or_else(|| "contact".into(), |stem| stem.to_string_lossy().into_owned());
    fit(&name, Log::parse(&bytes, options)?)
}

/// Fits contact models to a log.
///
/// # Errors
/// Returns [`ImportError`] if no model of a scene fits.
pub fn fit(name: &str, log: Log) -> Result<Friction, ImportError> {
    Friction::from_log(name, log)
}
