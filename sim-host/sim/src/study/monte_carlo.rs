//! Monte Carlo: a scene run many times, each time with a seed of its own and with what the scene varies drawn again.
//!
//! What run `r` of a scene is follows from the scene's seed and from `r` only ([`draw`]), so that a run can be repeated by itself and
//! nothing depends on the number of threads. Of each run its metrics are stored and, if the firmware drives, how its frequency error
//! fell ([`error`]); its record is not, so that memory is a few kilobytes a run.

pub mod draw;
pub mod error;
pub mod figures;
pub mod statistics;
pub mod table;

#[cfg(test)]
mod tests;

use std::sync::atomic::AtomicBool;

use self::draw::{Draw, Draws};
use self::error::Grid;
use self::statistics::Statistics;
use super::driven::Level;
use super::plan::{Cell, Made, Plan, Progress};
use super::{Options, StudyError};
use crate::instruments::lock::claims;
use crate::instruments::{self, View};
use crate::metrics::Metrics;
use crate::record::{Record, text_hash};
use crate::run::LANES;
use scene::Driven;
use scene::load::Loaded;

/// What it is called, and whether a run has it.
type Flaw = (&'static str, fn(&OneRun) -> bool);

/// What makes a run the worst, the gravest first.
const FLAWS: [Flaw; 4] = [
    ("a false lock", |run| run.metrics.get("false_locks") == Some(1.0)),
    ("a loss of lock that was not noticed", |run| run.metrics.get("undetected_losses") == Some(1.0)),
    ("a fault", OneRun::faulted),
    ("no lock", |run| !run.locked),
];
/// What the worst run has most of, where none has a flaw.
const MEASURES: [(&str, &str); 5] = [
    ("lock_time_20hz_ms", "longest to within 20 Hz"),
    ("relock_time_20hz_ms", "longest to within 20 Hz again"),
    ("lock_time_4hz_ms", "longest to within 4 Hz"),
    ("relock_time_4hz_ms", "longest to within 4 Hz again"),
    ("frequency_bias_hz", "largest bias"),
];

/// A scene that was run many times.
#[derive(Clone, Debug)]
pub struct MonteCarlo {
    /// The keys that vary.
    pub keys: Vec<String>,
    /// Where the controllers ran, if the firmware drove.
    pub level: Level,
    /// How many runs were asked for.
    pub asked: u32,
    /// The runs that came to their end, in order.
    pub runs: Vec<OneRun>,
    /// Metrics that would be infinite.
    pub endless: Vec<&'static str>,
    /// Moments of the error traces, ms from the first sample of the lock stage; none of a contact study.
    pub times_ms: Vec<f64>,
    /// Wall time of all runs together, s.
    pub wall_s: Option<f64>,
}

/// One of the runs.
#[derive(Clone, Debug, PartialEq)]
pub struct OneRun {
    /// Values that the run has drawn.
    pub draw: Draw,
    /// Metrics of the run.
    pub metrics: Metrics,
    /// Whether it came to a lock that was one.
    pub locked: bool,
    /// Hash of every drive code played, if the firmware drove.
    pub drive_hash: Option<u64>,
    /// How far the drive was from the true resonance at [`MonteCarlo::times_ms`], Hz: infinite before it ever comes to lock and after
    /// a fault, not a number without drive.
    pub error_hz: Vec<f32>,
}

impl OneRun {
    /// Runs it, and keeps its numbers.
    fn read(draw: Draw, made: &Made, grid: Option<&Grid>) -> Result<Self, StudyError> {
        let Some(scene) = made.scene.driven() else {
            let metrics = made.metrics()?;
            return Ok(OneRun { draw, metrics, locked: false, drive_hash: None, error_hz: Vec::new() });
        };
        Ok(OneRun::of(draw, &scene, &made.record(&scene)?, grid))
    }

    /// Runs several side by side, and keeps their numbers.
    fn read_abreast(group: Vec<(Draw, Made)>, grid: Option<&Grid>) -> Result<Vec<Self>, StudyError> {
        let cells: Vec<&Made> = group.iter().map(|(_, made)| made).collect();
        let records = Made::abreast(&cells);
        let read =
            |((draw, made), record): ((Draw, Made), Result<Option<Record>, StudyError>)| match made.scene.driven().zip(record?) {
                Some((scene, record)) => Ok(OneRun::of(draw, &scene, &record, grid)),
                None => OneRun::read(draw, &made, grid),
            };
        group.into_iter().zip(records).map(read).collect()
    }

    /// The numbers of a run.
    fn of(draw: Draw, scene: &Driven, record: &Record, grid: Option<&Grid>) -> Self {
        let view = View::new(scene, record);
        let locked = claims::of(&view).is_some_and(|claims| claims.true_lock);
        let error_hz = grid.map_or_else(Vec::new, |grid| grid.errors_hz(&view));
        OneRun { draw, metrics: instruments::metrics(&view), locked, drive_hash: Some(record.drive_hash), error_hz }
    }

    /// Whether it ended in a fault.
    pub fn faulted(&self) -> bool {
        self.metrics.get("fault_code").is_some_and(|code| code != 0.0)
    }
}

impl MonteCarlo {
    /// The run that did worst, and in what; none of a contact study.
    pub fn worst(&self) -> Option<(&OneRun, &'static str)> {
        if self.times_ms.is_empty() {
            return None;
        }
        let flawed = FLAWS.iter().find_map(|(flaw, has)| Some((self.runs.iter().find(|run| has(run))?, *flaw)));
        flawed.or_else(|| MEASURES.iter().find_map(|(metric, measure)| Some((self.most(metric)?, *measure))))
    }

    /// The first run that lacks a metric which others have, or else has the most of it; none if all have nothing of it.
    fn most(&self, metric: &str) -> Option<&OneRun> {
        let size = |run: &OneRun| run.metrics.get(metric).map_or(f64::INFINITY, f64::abs);
        let has = |run: &&OneRun| run.metrics.get(metric).is_some();
        self.runs.iter().find(has)?;
        let worst = self.runs.iter().rev().max_by(|a, b| size(a).total_cmp(&size(b)));
        worst.filter(|run| size(run) > 0.0)
    }

    /// A result without any runs.
    pub fn none() -> Self {
        MonteCarlo {
            keys: Vec::new(),
            level: Level::Sil,
            asked: 0,
            runs: Vec::new(),
            endless: Vec::new(),
            times_ms: Vec::new(),
            wall_s: None,
        }
    }

    /// A hash of what all runs played, in order.
    pub fn drive_hash(&self) -> Option<u64> {
        let hashes: Option<Vec<String>> = self.runs.iter().map(|run| Some(format!("{:016x}", run.drive_hash?))).collect();
        hashes.map(|hashes| text_hash(&hashes.concat()))
    }
}

/// Runs a scene as often as it says, in parallel, and puts the metrics together. Stopped, it keeps the runs that came to their end.
/// `progress` is called with how many have.
pub(super) fn run(loaded: &Loaded, options: Options, stop: &AtomicBool) -> Result<(MonteCarlo, Metrics), StudyError> {
    let Options { start, progress, clock, .. } = options;
    let began = clock.map(|clock| clock());
    let scene = &loaded.scene;
    let plan = Plan::on(loaded, stop, start, progress.map(|progress| progress as Progress))?;
    let (draws, grid) = (Draws::of(scene), scene.driven().map(|scene| Grid::of(&scene)));
    let drawn = (1..=scene.runs).map(|number| draws.draw(number)).collect();
    let cell = |draw: &Draw| {
        let sets = draw.sets(&draws.keys);
        Cell { label: format!("of run {} of `{}` ({})", draw.number, loaded.name, sets.join(", ")), sets }
    };
    let runs = match start {
        Some(_) => plan.run(drawn, cell, |draw, made| OneRun::read(draw, made, grid.as_ref()))?,
        None => plan.run_groups(drawn, LANES, cell, |group| OneRun::read_abreast(group, grid.as_ref()))?,
    };
    let runs: Vec<OneRun> = runs.into_iter().flatten().collect();
    let wall_s = clock.zip(began).map(|(clock, began)| (clock() - began).as_secs_f64());
    let Statistics { mut metrics, endless } = statistics::of(runs.iter().map(|run| &run.metrics));
    metrics.put("runs_completed", runs.len() as f64);
    if scene.driven().is_some() {
        metrics.put("runs_locked", runs.iter().filter(|run| run.locked).count() as f64);
        metrics.put("runs_faulted", runs.iter().filter(|run| run.faulted()).count() as f64);
    }
    let times_ms = grid.map_or_else(Vec::new, |grid| grid.times_s.iter().map(|s| 1e3 * s).collect());
    Ok((MonteCarlo { keys: draws.keys, level: Level::of(start), asked: scene.runs, runs, endless, times_ms, wall_s }, metrics))
}
