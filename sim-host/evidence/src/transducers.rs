//! Transducers: share of a random set that locks, and the outcomes of the others.
//!
//! ```text
//! random set (draw) --> ranges of a front end (front_end) --+
//! suites/transducers.toml --> runs of each case -----------+--> run --> outcome against the plant (outcome)
//!                                                                           |
//!                    tables, transducers.csv  <--- summary <----------------+---> baseline: no count is worse
//! ```
//!
//! This bench is separate from `tracking`, whose targets are statistics of metrics: they cannot
//! hold the verdict on a single run, and six hundred transducers that differ in everything are not
//! named cases. The breaking points are a suite nevertheless, so that each case can be run alone.
//!
//! All results are simulated (SIL).

mod baseline;
pub(crate) mod draw;
pub(crate) mod drift;
pub(crate) mod estimates;
pub(crate) mod front_end;
pub(crate) mod outcome;
mod restart;
mod summary;
mod table;

#[cfg(test)]
pub(crate) mod tests;

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use self::draw::Transducer;
use self::outcome::{JudgedRun, judge};
use self::restart::Restarted;
use crate::campaign::{self, each};
use crate::evidence::{Error, Evidence, Options};
use scene::Driven;
use scene::load::load;
use scene::settings;
use scene::suite::{self, ReadyCase};
use sim::processor::Here;
use sim::run::{RunError, Watch, run_on};
use sim::study::StudyError;
use sim::study::monte_carlo::draw::Draws;

/// Text of the suite.
pub(crate) const SUITE: &str = include_str!("../suites/transducers.toml");
/// Number of transducers in the random set, full and quick variant.
const SET_SIZES: [u32; 2] = [600, 96];
/// Group of the suite whose drive is stopped and restarted.
const RESTART_GROUP: &str = "restart";

/// Judged run with the command that repeats it.
#[derive(Clone, Debug)]
struct RepeatableRun {
    /// Command that repeats the run.
    command: String,
    /// Verdict on the run.
    judged: JudgedRun,
}

/// Transducer of the random set with its runs.
#[derive(Clone, Debug)]
struct TransducerRuns {
    transducer: Transducer,
    /// Run with the observer, the default tracking mode.
    observer: RepeatableRun,
    /// Run with the phase loop, which begins with a scan; not in the wider set.
    phase_lock: Option<RepeatableRun>,
}

/// Case of the suite with its runs.
#[derive(Clone, Debug)]
struct CaseRuns {
    name: String,
    group: String,
    runs: Vec<RepeatableRun>,
}

/// Runs the random set and the suite.
pub(crate) fn run(options: &mut Options) -> Result<Evidence, Error> {
    let suite = suite::load_text("transducers", SUITE, options.quick)?;
    let number = SET_SIZES[usize::from(options.quick)];
    (options.progress)(&format!("{number} transducers"));
    let set = each(number, options.stop, |number| run_transducer(Transducer::draw(number), true, options.stop))?;
    let wide = options.count.unwrap_or(number);
    let first = options.seed.unwrap_or(0).min(u32::MAX.into()) as u32;
    (options.progress)(&format!("{wide} transducers of the wider set, from number {first}"));
    let wider = |number| run_transducer(Transducer::draw_wider(first.saturating_add(number)), false, options.stop);
    let wide = each(wide, options.stop, wider)?;
    (options.progress)("cases");
    let cases = suite.cases.par_iter().map(|case| run_case(case, options.stop)).collect::<Result<Vec<_>, Error>>()?;
    let counted = baseline::count(options.quick, &set, &wide, &cases);
    // Of other transducers there is no baseline.
    let missed = if options.count.is_some() || options.seed.is_some() { Vec::new() } else { baseline::compare(&counted) };
    let files = vec![
        ("transducers.csv", table::csv(&set)?),
        ("wider.csv", table::csv(&wide)?),
        (baseline::FILE, baseline::text(&counted)),
    ];
    let title = "Transducers: how many lock, and the outcomes of the others";
    let subtitle = "Simulated: the controller on the host, against the simulated stack and its converters";
    Ok(campaign::evidence(title, subtitle, table::tables(&set, &wide, &cases), files, missed))
}

/// Runs a transducer of a random set in the default tracking mode or in both.
fn run_transducer(transducer: Transducer, both: bool, stop: Option<&AtomicBool>) -> Result<TransducerRuns, Error> {
    let by_mode = |mode: &str| {
        let sets = front_end::sets(&transducer, mode);
        let loaded = load(front_end::SCENE, &sets)?;
        let scene = loaded.scene.driven().ok_or(StudyError::Incomplete)?;
        let sets: String = sets.iter().map(|set| format!(" --set {set}")).collect();
        Ok::<_, Error>(RepeatableRun {
            command: format!("sim-host run {}{sets}", front_end::SCENE),
            judged: run_scene(&scene, false, stop)?,
        })
    };
    let (observer, phase_lock) = (by_mode("observer")?, both.then(|| by_mode("phase_lock")).transpose()?);
    Ok(TransducerRuns { transducer, observer, phase_lock })
}

/// Runs a case of the suite as often as the case specifies.
fn run_case(case: &ReadyCase, stop: Option<&AtomicBool>) -> Result<CaseRuns, Error> {
    let draws = Draws::of(&case.loaded.scene);
    let run_once = |number: u32| {
        let loaded = case.loaded.cell(&draws.draw(number).sets(&draws.keys))?;
        let scene = loaded.scene.driven().ok_or(StudyError::Incomplete)?;
        let command = format!("{} --run {number}", case.command);
        Ok(RepeatableRun { command, judged: run_scene(&scene, case.group == RESTART_GROUP, stop)? })
    };
    let runs = (1..=case.loaded.scene.runs).map(run_once).collect::<Result<Vec<_>, Error>>()?;
    Ok(CaseRuns { name: case.name.clone(), group: case.group.clone(), runs })
}

/// Runs a scene once and judges it; with `restart`, the drive is stopped and restarted during the
/// run.
fn run_scene(scene: &Driven, restart: bool, stop: Option<&AtomicBool>) -> Result<JudgedRun, Error> {
    let controller = Here::new(&settings::config(scene))?;
    let watch = Watch { stop, ..Watch::default() };
    let record =
        if restart { run_on(&mut Restarted::new(controller), scene, watch) } else { run_on(&mut { controller }, scene, watch) };
    let record = record.map_err(|error: RunError| StudyError::from(error))?;
    if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
        return Err(StudyError::Interrupted.into());
    }
    Ok(judge(scene, &record))
}
