//! A cell: the scene with some keys set and nothing run beside it, for a grid and for a comparison. Each is a scene of its own,
//! seeded as the scene is, so that a result does not depend on the number of threads.

use std::sync::atomic::AtomicBool;

use super::swept::Swept;
use super::{StudyError, contact, driven};
use crate::metrics::Metrics;
use scene::Kind;
use scene::load::Loaded;

/// The scene of a cell; `place` names it.
pub(super) fn load(loaded: &Loaded, place: &str, sets: &[String]) -> Result<Loaded, StudyError> {
    loaded.cell(sets).map_err(|error| StudyError::Cell(place.to_owned(), error))
}

/// Runs a cell, and measures it.
pub(super) fn run(cell: &Loaded, place: &str, stop: &AtomicBool) -> Result<Metrics, StudyError> {
    let metrics = match cell.scene.kind().ok_or(StudyError::Incomplete)? {
        Kind::Driven(scene) => driven::cell(&scene, stop),
        Kind::Excited(scene) => contact::cell(&scene, stop),
    };
    metrics.map_err(empty(place))
}

/// Runs a cell for its sweep, which is to be called `name`; nothing if it has none.
pub(super) fn sweep(cell: &Loaded, place: &str, name: &str, stop: &AtomicBool) -> Result<Option<Swept>, StudyError> {
    cell.scene.driven().map_or(Ok(None), |scene| driven::sweep(&scene, name, stop).map_err(empty(place)))
}

pub(super) fn empty(place: &str) -> impl FnOnce(StudyError) -> StudyError {
    |error| StudyError::EmptyCell(place.to_owned(), Box::new(error))
}
