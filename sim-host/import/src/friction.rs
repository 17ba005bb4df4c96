//! Friction measurements: contact models fitted to a log without vibration, and one fit of all
//! conditions with and without vibration: [`import_files`].
//!
//! ```text
//! log -> (slip, velocity, force, normal force, OFF and ON) -> motion between samples -> fit of each model to the OFF part
//!     -> choice -> contact, scene
//! logs or tables with OFF and ON -> measurements -> conditions -> shared fit, friction ratios, predictions, scene
//! ```

pub(crate) mod certainty;
pub mod conditions;
pub(crate) mod fit;
mod log;
mod maxwell;
mod models;
pub(crate) mod motion;
mod quantity;
pub(crate) mod result;
pub(crate) mod smoothed;
mod start;
mod view;

use std::path::{Path, PathBuf};

use crate::error::ImportError;
use columns::file;
use conditions::Conditions;
pub use log::{Log, Options};
pub use models::Model;
use quantity::{Columns, Quantity};
pub use result::{Fitted, Friction};

/// Result of files.
pub enum Found {
    /// Log of a contact without vibration.
    Log(Box<Friction>),
    /// Measurements without and with vibration, and the contact of the part without, if they are
    /// one log.
    Conditions(Box<Conditions>, Option<Box<Friction>>),
}

/// Fits a log without vibration, or the conditions of one or several files.
///
/// # Errors
/// Returns [`ImportError`], with the file, the line or the column that shows the reason.
pub fn import_files(paths: &[PathBuf], options: &Options) -> Result<Found, ImportError> {
    from_columns(&paths.iter().map(|path| conditions::open(path, read(path), options)).collect::<Result<Vec<_>, _>>()?, options)
}

/// Fits the content of a file with this name, as [`import_files`] does.
///
/// # Errors
/// Returns [`ImportError`], with the file, the line or the column that shows the reason.
pub fn import_content(name: &str, content: Vec<u8>, options: &Options) -> Result<Found, ImportError> {
    from_columns(&[conditions::open(Path::new(name), Ok(content), options)?], options)
}

/// Returns `true` for a table of friction that a fit can use: over the time, it also needs a
/// displacement, a speed, or the vibration.
pub fn has_friction(content: &[u8]) -> bool {
    let Ok(columns) = Columns::parse(content, None) else { return false };
    let has = |quantity| columns.place(quantity).is_some();
    let is_friction = |quantity| matches!(quantity, Some(Quantity::Force(_) | Quantity::Mu(_)));
    let friction = (0..columns.names.len()).any(|at| is_friction(Quantity::parse(columns.heading(at).name)));
    let conditions = [Quantity::Displacement, Quantity::Velocity, Quantity::State, Quantity::Level, Quantity::Tip];
    friction && (!has(Quantity::Time) || conditions.into_iter().any(has))
}

fn from_columns(files: &[(PathBuf, Columns)], options: &Options) -> Result<Found, ImportError> {
    let is_log = |columns: &Columns| {
        let has = |quantity| columns.place(quantity).is_some();
        (has(Quantity::Force(None)) || has(Quantity::Mu(None)))
            && (has(Quantity::Displacement) || has(Quantity::Time) && has(Quantity::Velocity))
    };
    let [(path, columns)] = files else {
        return Ok(Found::Conditions(Box::new(Conditions::from_files(files, options, None)?), None));
    };
    let states = columns.states().map_err(|error| error.of_file(path))?;
    // A strength of the vibration also tells ON from OFF.
    let has_strength = [Quantity::Level, Quantity::Tip]
        .into_iter()
        .filter_map(|quantity| columns.place(quantity))
        .any(|at| columns.table.columns[at].values.iter().any(|value| *value != 0.0));
    let has_on = states.map_or(!options.on_s.is_empty() || has_strength, |states| states.contains(&true));
    let log = || Log::from_columns(columns, options).and_then(|log| fit(&stem(std::slice::from_ref(path)), log));
    if is_log(columns) && !has_on {
        return Ok(Found::Log(Box::new(log().map_err(|error| error.of_file(path))?)));
    }
    // The presliding of the OFF part may show the stiffness.
    let contact = if is_log(columns) { log().ok().map(Box::new) } else { None };
    let known = contact.as_ref().zip(options.frequency_hz).and_then(|(contact, hz)| contact.stiffness_s(hz));
    Ok(Found::Conditions(Box::new(Conditions::from_files(files, options, known)?), contact))
}

/// Fits contact models to a log.
///
/// # Errors
/// Returns [`ImportError`], with the line or value that shows the reason.
pub fn import(path: &Path, options: &Options) -> Result<Friction, ImportError> {
    fit(&stem(&[path.to_owned()]), Log::parse(read(path)?, options)?)
}

/// Returns the name of a contact from its files.
pub fn stem(paths: &[PathBuf]) -> String {
    match paths {
        [path] => path.file_stem().map_or_else(|| "contact".into(), |stem| stem.to_string_lossy().into_owned()),
        _ => "conditions".to_owned(),
    }
}

fn read(path: &Path) -> Result<Vec<u8>, ImportError> {
    file::read(path, file::MAX_DATA_BYTES).map_err(|source| ImportError::Unreadable { path: path.to_owned(), source })
}

/// Fits contact models to a log.
///
/// # Errors
/// Returns [`ImportError`] if no model of a scene fits.
pub fn fit(name: &str, log: Log) -> Result<Friction, ImportError> {
    Friction::from_log(name, log)
}
