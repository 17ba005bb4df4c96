//! Monte Carlo: many runs of a scene, each with its own seed and newly drawn values.
//!
//! Run `r` depends only on the scene's seed and on `r` ([`draw`]), so that it can be repeated
//! alone, and is independent of the number of threads. Of each run, its metrics are stored and, if
//! the firmware drives, its frequency error over time ([`error`]). Its record is not stored, so
//! that the memory is a few kilobytes per run.

pub mod draw;
pub mod error;
pub mod figures;
pub mod statistics;
pub mod table;
pub mod uncertainty;

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
use crate::instruments::{self, Line, View};
use crate::metrics::Metrics;
use crate::record::{Record, text_hash};
use crate::run::LANES;
use scene::load::Loaded;
use scene::{Driven, Scene};

/// Largest number of runs if nobody set it.
const MOST_DEFAULT_RUNS: u32 = 4096;

/// Name of a flaw, and test for it.
type Flaw = (&'static str, fn(&OneRun) -> bool);

/// Flaws that make a run the worst, the most severe first.
const FLAWS: [Flaw; 4] = [
    ("a false lock", |run| run.metrics.get("false_locks") == Some(1.0)),
    ("an undetected loss of lock", |run| run.metrics.get("undetected_losses") == Some(1.0)),
    ("a fault", OneRun::faulted),
    ("no lock", |run| !run.locked),
];
/// Metrics that are better if they are larger; any other is worst at its largest magnitude.
const LARGER_IS_BETTER: [&str; 4] =
    ["reduction_percent", "shoulder_force_reduction_percent", "tip_velocity_m_per_s", "release_speed_m_per_s"];

/// Result of several runs of a scene.
#[derive(Clone, Debug)]
pub struct MonteCarlo {
    /// Keys that vary.
    pub keys: Vec<String>,
    /// Level at which the controllers ran, if the firmware drove.
    pub level: Level,
    /// Requested number of runs.
    pub asked: u32,
    /// Completed runs, in order.
    pub runs: Vec<OneRun>,
    /// Metrics that would be infinite.
    pub endless: Vec<&'static str>,
    /// Times of the error traces, ms from the first sample of the lock stage; empty for a contact
    /// study.
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
    /// `true` if the run reached a true lock.
    pub locked: bool,
    /// Hash of every drive code played, if the firmware drove.
    pub drive_hash: Option<u64>,
    /// Distance of the drive from the true resonance at [`MonteCarlo::times_ms`], Hz; infinite
    /// before the lock stage and after a fault, NaN without drive.
    pub error_hz: Vec<f32>,
}

impl OneRun {
    /// Runs a scene, and stores its results.
    fn read(draw: Draw, made: &Made, grid: Option<&Grid>) -> Result<Self, StudyError> {
        let Some(scene) = made.scene.driven() else {
            let metrics = made.metrics()?;
            return Ok(OneRun { draw, metrics, locked: false, drive_hash: None, error_hz: Vec::new() });
        };
        Ok(OneRun::from_record(draw, &scene, &made.record(&scene)?, grid))
    }

    /// Runs several scenes in a batch, and stores their results.
    fn read_batch(group: Vec<(Draw, Made)>, grid: Option<&Grid>) -> Result<Vec<Self>, StudyError> {
        let cells: Vec<&Made> = group.iter().map(|(_, made)| made).collect();
        let records = Made::run_batch(&cells);
        let read =
            |((draw, made), record): ((Draw, Made), Result<Option<Record>, StudyError>)| match made.scene.driven().zip(record?) {
                Some((scene, record)) => Ok(OneRun::from_record(draw, &scene, &record, grid)),
                None => OneRun::read(draw, &made, grid),
            };
        group.into_iter().zip(records).map(read).collect()
    }

    /// Evaluates the record of a run.
    fn from_record(draw: Draw, scene: &Driven, record: &Record, grid: Option<&Grid>) -> Self {
        let view = View::new(scene, record);
        let locked = claims::evaluate(&view).is_some_and(|claims| claims.true_lock);
        let error_hz = grid.map_or_else(Vec::new, |grid| grid.errors_hz(&view));
        OneRun { draw, metrics: instruments::metrics(&view), locked, drive_hash: Some(record.drive_hash), error_hz }
    }

    /// Returns `true` if the run ended in a fault.
    pub fn faulted(&self) -> bool {
        self.metrics.get("fault_code").is_some_and(|code| code != 0.0)
    }
}

impl MonteCarlo {
    /// Returns the worst run with the reason: a flaw, or else the worst value of the scene's main
    /// metric. `None` if that is equal in all runs.
    pub fn worst(&self, scene: &Scene) -> Option<(&OneRun, String)> {
        let driven = scene.controller.is_some();
        let flawed =
            FLAWS.iter().filter(|_| driven).find_map(|(flaw, has)| Some((self.runs.iter().find(|run| has(run))?, *flaw)));
        if let Some((run, flaw)) = flawed {
            return Some((run, flaw.to_owned()));
        }
        let worst = |(label, metric, _): Line| {
            let larger_is_better = LARGER_IS_BETTER.contains(&metric);
            let badness = |run: &OneRun| run.metrics.get(metric).map(|value| if larger_is_better { -value } else { value.abs() });
            let rated = || self.runs.iter().filter_map(|run| Some((run, badness(run)?)));
            let (run, most) = rated().rev().max_by(|a, b| a.1.total_cmp(&b.1))?;
            let differs = rated().any(|(_, badness)| badness < most);
            differs.then(|| (run, format!("{} {label}", if larger_is_better { "smallest" } else { "largest" })))
        };
        uncertainty::lines(scene).into_iter().find_map(worst)
    }

    /// Creates a result without runs.
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

    /// Returns a hash of the codes of all runs, in order.
    pub fn drive_hash(&self) -> Option<u64> {
        let hashes: Option<Vec<String>> = self.runs.iter().map(|run| Some(format!("{:016x}", run.drive_hash?))).collect();
        hashes.map(|hashes| text_hash(&hashes.concat()))
    }
}

/// Returns the largest number of runs of a scene.
pub fn most_runs(loaded: &Loaded) -> u32 {
    if loaded.default_runs { loaded.scene.runs.max(MOST_DEFAULT_RUNS) } else { loaded.scene.runs }
}

/// Runs a scene `runs` times, in parallel, and combines the metrics. If nobody set that number, it
/// is doubled until the ends of the main interval are known. If it is stopped, it keeps the
/// completed runs. `progress` is called with their number.
pub(super) fn run(loaded: &Loaded, options: Options, stop: &AtomicBool) -> Result<(MonteCarlo, Metrics), StudyError> {
    let Options { start, progress, clock, .. } = options;
    let began = clock.map(|clock| clock());
    let scene = &loaded.scene;
    let plan = Plan::on(loaded, stop, start, progress.map(|progress| progress as Progress))?;
    let (draws, grid) = (Draws::of(scene), scene.driven().map(|scene| Grid::from_scene(&scene)));
    let cell = |draw: &Draw| {
        let sets = draw.sets(&draws.keys);
        Cell { label: format!("of run {} of `{}` ({})", draw.number, loaded.name, sets.join(", ")), sets }
    };
    let (mut runs, mut asked) = (Vec::new(), scene.runs);
    loop {
        let drawn = (runs.len() as u32 + 1..=asked).map(|number| draws.draw(number)).collect();
        let more = match start {
            Some(_) => plan.run(drawn, cell, |draw, made| OneRun::read(draw, made, grid.as_ref()))?,
            None => plan.run_groups(drawn, LANES, cell, |group| OneRun::read_batch(group, grid.as_ref()))?,
        };
        runs.extend(more.into_iter().flatten());
        let is_known = uncertainty::end_error_rel(scene, &runs).is_none_or(|error| error < uncertainty::END_ERROR_REL);
        if is_known || 2 * asked > most_runs(loaded) {
            break;
        }
        asked *= 2;
        if plan.is_stopped() {
            break;
        }
    }
    let wall_s = clock.zip(began).map(|(clock, began)| (clock() - began).as_secs_f64());
    let Statistics { mut metrics, endless } = statistics::combine(runs.iter().map(|run| &run.metrics));
    metrics.put("runs_completed", runs.len() as f64);
    if scene.driven().is_some() {
        metrics.put("runs_locked", runs.iter().filter(|run| run.locked).count() as f64);
        metrics.put("runs_faulted", runs.iter().filter(|run| run.faulted()).count() as f64);
    }
    let times_ms = grid.map_or_else(Vec::new, |grid| grid.times_s.iter().map(|s| 1e3 * s).collect());
    Ok((MonteCarlo { keys: draws.keys, level: Level::from_start(start), asked, runs, endless, times_ms, wall_s }, metrics))
}
