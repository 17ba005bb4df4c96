//! A study driven by the firmware.

use std::sync::atomic::AtomicBool;

use super::{Start, StudyError};
use crate::instruments::sweep::record::{self, SweepRecord};
use crate::instruments::{self, View};
use crate::metrics::Metrics;
use crate::overlay::Overlaid;
use crate::record::Record;
use crate::run::{self, RunError, Watch};
use contact::Clock;
use scene::Driven;

/// Level at which the controller of a study ran, which determines the meaning of its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// The controller ran on the host.
    Sil,
    /// The controller ran as thumb code in an emulator.
    Pil,
    /// The controller ran in the flashed image, on a model of its part.
    Board,
}

impl Level {
    /// Returns the level of runs with these processors.
    pub fn from_start(start: Option<Start>) -> Self {
        start.map_or(Level::Sil, |start| start.level)
    }
}

impl std::fmt::Display for Level {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Level::Sil => "SIL (software in the loop: the controller on the host)",
            Level::Pil => "PIL (processor in the loop: the controller as thumb code in QEMU)",
            Level::Board => {
                "PIL (processor in the loop: the flashed image on a model of its part, replayed on the host bit for bit)"
            }
        })
    }
}

/// A run driven by the firmware, with its results.
#[derive(Clone, Debug)]
pub struct Run<'a> {
    /// Scene that was run.
    pub scene: Driven<'a>,
    /// Level at which the controller ran.
    pub level: Level,
    /// Record of the run.
    pub record: Record,
}

/// Runs a scene with the windows of its figures, and measures it.
pub(super) fn run<'a, 'w>(
    scene: Driven<'a>,
    (start, clock): (Option<Start>, Option<Clock>),
    stop: &'w AtomicBool,
    progress: Option<&'w mut dyn FnMut(f64)>,
) -> Result<(Run<'a>, Metrics, Option<Overlaid>), StudyError> {
    let watch = Watch { windows: instruments::windows(&scene), stop: Some(stop), progress, clock };
    let record = run_where(&scene, start, watch)?;
    let (metrics, overlaid) = instruments::overlaid(&View::new(&scene, &record));
    Ok((Run { scene, level: Level::from_start(start), record }, metrics, overlaid))
}

/// Runs a scene with the controller on a processor from `start`, or in this process.
fn run_where(scene: &Driven, start: Option<Start>, watch: Watch) -> Result<Record, RunError> {
    match start {
        Some(start) => {
            // The time includes the start of the processor.
            let timed = watch.clock.map(|clock| (clock, clock()));
            let record = run::run_on(&mut *(start.processor)(scene)?, scene, watch)?;
            Ok(Record { wall_s: timed.map(|(clock, began)| (clock() - began).as_secs_f64()), ..record })
        }
        None => run::run(scene, watch),
    }
}

/// Runs a scene only for its metrics, without windows that only its figures need.
pub(super) fn record(scene: &Driven, start: Option<Start>, stop: &AtomicBool) -> Result<Record, StudyError> {
    let windows = instruments::windows_of_metrics(scene);
    Ok(run_where(scene, start, Watch { windows, stop: Some(stop), ..Watch::default() })?)
}

/// Records the sweep of a cell's scene, sample by sample.
pub(super) fn sweep(scene: &Driven, name: &str, stop: &AtomicBool) -> Result<Option<SweepRecord>, StudyError> {
    let windows = record::window(scene).into_iter().collect();
    let record = run::run(scene, Watch { windows, stop: Some(stop), ..Watch::default() })?;
    Ok(SweepRecord::from_record(name, scene, &record))
}
