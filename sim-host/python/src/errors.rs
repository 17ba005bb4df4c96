//! The errors of this package: the texts of the command line, as exceptions.

use std::error::Error;
use std::path::Path;

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use scene::load::LoadError;

create_exception!(
    sonoglide,
    SceneError,
    PyValueError,
    "A scene or one of its values is invalid; the text contains line, column and the nearest name."
);
create_exception!(sonoglide, RunError, PyRuntimeError, "A run has no result, or its folder cannot be written.");
create_exception!(
    sonoglide,
    MeasurementError,
    PyValueError,
    "A measured file is refused; the text contains the reason, with the line or the column."
);
create_exception!(sonoglide, LinkError, PyRuntimeError, "A board does not answer, refuses a command, or was lost.");

/// Converts the error of a scene that cannot be loaded, with the report of all its errors.
pub fn scene_error(error: &LoadError) -> PyErr {
    SceneError::new_err(match error {
        LoadError::Invalid(report) => report.render(false),
        error => error.to_string(),
    })
}

/// Converts the error of a measured file that is refused, with the message of the command line.
pub fn import_error(path: &Path, error: &import::error::ImportError) -> PyErr {
    MeasurementError::new_err(match error {
        import::error::ImportError::Unreadable { .. } | import::error::ImportError::InFile { .. } => error.to_string(),
        error => format!("{}: {error}", path.display()),
    })
}

/// Converts the error of a run without a result, with every cause.
pub fn run_error(error: &(dyn Error + 'static)) -> PyErr {
    RunError::new_err(with_causes(error))
}

/// Returns the text of an error with those of its causes.
pub fn with_causes(error: &(dyn Error + 'static)) -> String {
    let causes = std::iter::successors(Some(error), |&error| error.source());
    causes.map(ToString::to_string).collect::<Vec<_>>().join(": ")
}
