//! Plan of a study: its cells, each the scene with some keys set, run in parallel.
//!
//! ```text
//! [grid]        every pair of two keys      --+
//! [comparison]  every case, every amplitude --+--> plan --> cells (scene + changes) --> result of each
//! runs          every draw of [[vary]]      --+
//! ```
//!
//! Each cell is a separate scene with its own seed, so that results do not depend on the number of
//! threads.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::{Start, StudyError, contact, design, driven};
use crate::instruments;
use crate::instruments::sweep::record::SweepRecord;
use crate::metrics::Metrics;
use crate::record::Record;
use crate::run;
use scene::load::{Loaded, Template};
use scene::{Driven, Kind, Scene};

/// Function called with the number of completed cells.
pub(super) type Progress<'a> = &'a mut (dyn FnMut(f64) + Send);

/// Data that the cells of a study share.
pub(super) struct Plan<'a> {
    template: Template<'a>,
    start: Option<Start<'a>>,
    stop: &'a AtomicBool,
    progress: Mutex<Option<Progress<'a>>>,
    done: AtomicU32,
}

/// Description of a cell.
pub(super) struct Cell {
    /// Name for messages.
    pub(super) label: String,
    /// Changes of the scene, as `key=value`.
    pub(super) sets: Vec<String>,
}

/// Cell with its scene.
pub(super) struct Made<'p, 'a> {
    /// Scene of the cell.
    pub(super) scene: Scene,
    label: String,
    plan: &'p Plan<'a>,
}

impl<'a> Plan<'a> {
    /// Creates a plan of a scene's cells, whose controllers run in this process.
    pub(super) fn new(loaded: &'a Loaded, stop: &'a AtomicBool) -> Result<Self, StudyError> {
        Self::on(loaded, stop, None, None)
    }

    /// Creates a plan of a scene's cells, whose controllers run on processors from `start`.
    pub(super) fn on(
        loaded: &'a Loaded,
        stop: &'a AtomicBool,
        start: Option<Start<'a>>,
        progress: Option<Progress<'a>>,
    ) -> Result<Self, StudyError> {
        let template = loaded.template().map_err(|error| StudyError::Cell("of every cell".to_owned(), error))?;
        Ok(Plan { template, start, stop, progress: Mutex::new(progress), done: AtomicU32::new(0) })
    }

    /// Makes the cell of each item, reads its result, and counts it as completed; `None` for a cell
    /// that was stopped.
    pub(super) fn run<I: Send, T: Send>(
        &self,
        items: Vec<I>,
        cell: impl Fn(&I) -> Cell + Sync,
        read: impl Fn(I, &Made) -> Result<T, StudyError> + Sync,
    ) -> Result<Vec<Option<T>>, StudyError> {
        let read = |group: Vec<(I, Made)>| group.into_iter().map(|(item, made)| read(item, &made)).collect();
        self.run_groups(items, 1, cell, read)
    }

    /// Does the same for groups of up to `size` cells, whose results are read together.
    pub(super) fn run_groups<I: Send, T: Send>(
        &self,
        items: Vec<I>,
        size: usize,
        cell: impl Fn(&I) -> Cell + Sync,
        read: impl Fn(Vec<(I, Made)>) -> Result<Vec<T>, StudyError> + Sync,
    ) -> Result<Vec<Option<T>>, StudyError> {
        // Smaller groups keep all threads busy.
        let size = size.min(items.len().div_ceil(rayon::current_num_threads())).max(1);
        let of_group = |items: Vec<I>| {
            let stopped = std::iter::repeat_with(|| None).take(items.len());
            if self.is_stopped() {
                return Ok(stopped.collect());
            }
            let make = |item: I| self.make(cell(&item)).map(|made| (item, made));
            let results = read(items.into_iter().map(make).collect::<Result<_, _>>()?)?;
            let count = |result: T| {
                // A stopped contact study has no metrics; a cell that has just ended is also
                // omitted.
                if self.is_stopped() {
                    return None;
                }
                let done = f64::from(self.done.fetch_add(1, Ordering::Relaxed) + 1);
                if let Some(progress) = self.progress.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
                    progress(done);
                }
                Some(result)
            };
            Ok(results.into_iter().map(count).collect::<Vec<_>>())
        };
        let mut items = items.into_iter();
        let groups = std::iter::from_fn(|| Some(items.by_ref().take(size).collect::<Vec<I>>()).filter(|group| !group.is_empty()));
        let results: Result<Vec<Vec<Option<T>>>, StudyError> = groups.collect::<Vec<_>>().into_par_iter().map(of_group).collect();
        Ok(results?.into_iter().flatten().collect())
    }

    /// Converts a cell to a scene.
    pub(super) fn make(&self, Cell { label, sets }: Cell) -> Result<Made<'_, 'a>, StudyError> {
        match self.template.scene(&sets) {
            Ok(scene) => Ok(Made { scene, label, plan: self }),
            Err(error) => Err(StudyError::Cell(label, error)),
        }
    }

    /// Returns the flag that ends the study.
    pub(super) fn stop(&self) -> &'a AtomicBool {
        self.stop
    }

    /// Returns `true` if the study must end.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Made<'_, '_> {
    /// Runs the cell, and measures it.
    pub(super) fn metrics(&self) -> Result<Metrics, StudyError> {
        self.metrics_for(None)
    }

    /// Runs the cell for some metrics, or for all; other metrics may be missing.
    pub(super) fn metrics_for(&self, wanted: Option<&[&str]>) -> Result<Metrics, StudyError> {
        match self.scene.kind().ok_or(StudyError::Incomplete)? {
            Kind::Driven(scene) => self.record(&scene).map(|record| instruments::measure(&scene, &record)),
            Kind::Excited(scene) => contact::cell(&scene, wanted, self.plan.stop).map_err(|error| self.empty(error)),
            Kind::Designed(scene) => design::cell(scene).map_err(|error| self.empty(error)),
        }
    }

    /// Runs a cell that is driven by the firmware.
    pub(super) fn record(&self, scene: &Driven) -> Result<Record, StudyError> {
        driven::record(scene, self.plan.start, self.plan.stop).map_err(|error| self.empty(error))
    }

    /// Runs cells driven by the firmware in this process, in a batch. A cell of another kind has no
    /// record.
    pub(super) fn run_batch(cells: &[&Self]) -> Vec<Result<Option<Record>, StudyError>> {
        let driven: Vec<(&Self, Driven)> = cells.iter().filter_map(|made| Some((*made, made.scene.driven()?))).collect();
        let scenes: Vec<Driven> = driven.iter().map(|(_, scene)| *scene).collect();
        let stop = cells.first().map(|made| made.plan.stop);
        let records = run::run_batch(&scenes, stop).into_iter().zip(&driven);
        let mut records = records.map(|(record, (made, _))| record.map_err(|error| made.empty(error.into())));
        cells.iter().map(|made| made.scene.driven().and_then(|_| records.next()).transpose()).collect()
    }

    /// Runs the cell and returns its sweep with this name; `None` if it has none.
    pub(super) fn sweep(&self, name: &str) -> Result<Option<SweepRecord>, StudyError> {
        let Some(scene) = self.scene.driven() else { return Ok(None) };
        driven::sweep(&scene, name, self.plan.stop).map_err(|error| self.empty(error))
    }

    fn empty(&self, error: StudyError) -> StudyError {
        StudyError::EmptyCell(self.label.clone(), Box::new(error))
    }
}
