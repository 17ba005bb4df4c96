//! Transducers: how many of them lock, and what becomes of the others.
//!
//! ```text
//! random set (draw) --> ranges of a front end (front_end) --+
//! suites/transducers.toml --> runs of each case -----------+--> run --> outcome against the plant (outcome)
//!                                                                           |
//!                    tables, transducers.csv  <--- summary <----------------+---> baseline: nothing became worse
//! ```
//!
//! A bench beside `tracking` and no part of it: a suite's targets are statistics of metrics, of which one run's verdict is none, and six hundred transducers
//! that differ in everything are no cases with names. What breaks is a suite all the same, so that each case can be run by itself.
//!
//! All of it is simulated (SIL).

mod baseline;
pub(crate) mod draw;
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
use self::outcome::{Judged, judge};
use self::restart::Restarted;
use crate::evidence::{Error, Evidence, Options};
use report::Report;
use scene::Driven;
use scene::load::load;
use scene::settings;
use scene::suite::{self, ReadyCase};
use sim::processor::Here;
use sim::run::{RunError, Watch, run_on};
use sim::study::StudyError;
use sim::study::monte_carlo::draw::Draws;

/// The text of the suite.
pub(crate) const SUITE: &str = include_str!("../suites/transducers.toml");
/// Transducers of the random set, and of its quick variant.
const SET: [u32; 2] = [600, 96];
/// The group of the suite whose drive is stopped and ordered again.
const RESTART: &str = "restart";

/// A run, and how it is repeated.
#[derive(Clone, Debug)]
struct Tried {
    /// Command that repeats the run.
    command: String,
    /// The run, judged.
    judged: Judged,
}

/// A transducer of the random set that was run.
#[derive(Clone, Debug)]
struct TriedTransducer {
    transducer: Transducer,
    /// The run with the observer, the default mode of tracking.
    tried: Tried,
    /// The run with the phase loop, which begins with a scan.
    phase_lock: Tried,
}

/// A case of the suite that was run.
#[derive(Clone, Debug)]
struct TriedCase {
    name: String,
    group: String,
    runs: Vec<Tried>,
}

/// Runs the random set and the suite.
pub(crate) fn run(options: &mut Options) -> Result<Evidence, Error> {
    let suite = suite::load_text("transducers", SUITE, options.quick)?;
    let number = SET[usize::from(options.quick)];
    (options.progress)(&format!("{number} transducers"));
    let set = (0..number).into_par_iter().map(|number| of_set(number, options.stop)).collect::<Result<Vec<_>, Error>>()?;
    (options.progress)("cases");
    let cases = suite.cases.par_iter().map(|case| of_case(case, options.stop)).collect::<Result<Vec<_>, Error>>()?;
    let counted = baseline::count(options.quick, &set, &cases);
    let missed = baseline::compare(&counted);
    let tables = table::tables(&set, &cases);
    Ok(Evidence {
        report: Report {
            title: "Transducers: how many lock, and what becomes of the others".into(),
            subtitle: "Simulated: the controller on the host, against the simulated stack and its converters".into(),
            tables: tables.clone(),
            ..Report::default()
        },
        files: vec![("transducers.csv", table::csv(&set)?), (baseline::FILE, baseline::text(&counted))],
        docs: tables,
        missed,
        ..Evidence::default()
    })
}

/// Runs a transducer of the random set, in either mode of tracking.
fn of_set(number: u32, stop: Option<&AtomicBool>) -> Result<TriedTransducer, Error> {
    let transducer = Transducer::draw(number);
    let by_mode = |mode: &str| {
        let sets = front_end::sets(&transducer, mode);
        let loaded = load(front_end::SCENE, &sets)?;
        let scene = loaded.scene.driven().ok_or(StudyError::Incomplete)?;
        let sets: String = sets.iter().map(|set| format!(" --set {set}")).collect();
        Ok::<_, Error>(Tried {
            command: format!("sim-host run {}{sets}", front_end::SCENE),
            judged: of_scene(&scene, false, stop)?,
        })
    };
    let (tried, phase_lock) = (by_mode("observer")?, by_mode("phase_lock")?);
    Ok(TriedTransducer { transducer, tried, phase_lock })
}

/// Runs a case of the suite as often as it says.
fn of_case(case: &ReadyCase, stop: Option<&AtomicBool>) -> Result<TriedCase, Error> {
    let draws = Draws::of(&case.loaded.scene);
    let of_run = |number: u32| {
        let loaded = case.loaded.cell(&draws.draw(number).sets(&draws.keys))?;
        let scene = loaded.scene.driven().ok_or(StudyError::Incomplete)?;
        let command = format!("{} --run {number}", case.command);
        Ok(Tried { command, judged: of_scene(&scene, case.group == RESTART, stop)? })
    };
    let runs = (1..=case.loaded.scene.runs).map(of_run).collect::<Result<Vec<_>, Error>>()?;
    Ok(TriedCase { name: case.name.clone(), group: case.group.clone(), runs })
}

/// Runs a scene once, with the drive stopped on the way and ordered again, if asked for, and judges it.
fn of_scene(scene: &Driven, restart: bool, stop: Option<&AtomicBool>) -> Result<Judged, Error> {
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
