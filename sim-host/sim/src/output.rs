//! What a study leaves in its folder: manifest, summary, trace, report and figures.

mod comparison;
mod folder;
mod grid_file;
pub mod npy;
mod parquet_file;
mod runs_file;
pub mod sweep;
mod trace_file;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::provenance::Provenance;
use crate::record::text_hash;
use crate::study::answer::Answer;
use crate::study::{Outcome, Study};
use crate::tables;
use report::{self, Drawing, ReportError};
use scene::load::Loaded;
use scene::resolved::resolved_json;

pub use folder::Folder;

/// What went wrong with the folder.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A file cannot be written.
    #[error("cannot write `{path}`")]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        #[source]
        io: io::Error,
    },
    /// A file that looks like a run's, and that no run's manifest lists.
    #[error(
        "`{path}` is there already, and no run's manifest says whose it is: remove it if it is an old result, or choose another folder with -o"
    )]
    Strange {
        /// The file.
        path: PathBuf,
    },
    /// Another run is being written into the folder.
    #[error(
        "another run is being written into `{path}`, by process {process}: wait for its end, or choose another folder with -o"
    )]
    Held {
        /// The folder.
        path: PathBuf,
        /// Who writes it.
        process: String,
    },
    /// A file that is not of a run has the name of one of the run's.
    #[error(
        "`{path}` is not of an earlier run, and is not written over; the whole run is in `{run}` instead: move one of the two, or choose another folder with -o"
    )]
    InTheWay {
        /// The file.
        path: PathBuf,
        /// Where the run is.
        run: PathBuf,
    },
    /// A figure or the report.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The trace cannot be written.
    #[error("cannot write the trace")]
    Trace(#[from] csv::Error),
    /// The table of several runs.
    #[error("cannot write the table of the runs")]
    Runs(#[source] csv::Error),
    /// The table of the grid.
    #[error("cannot write the table of the grid")]
    Grid(#[source] csv::Error),
}

/// What a folder's pages show beside the results: how figures are drawn, and where they come from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Presentation {
    /// Size and formats of the figures.
    pub drawing: Drawing,
    /// The command, the commit and the date.
    pub provenance: Provenance,
}

/// What `--format json` prints: the summary, with what depends on the machine beside it.
pub fn printed(study: &Study) -> Value {
    let mut printed = summary(study);
    printed["machine"] = machine(study);
    printed
}

/// The figures of the machine, as `machine.json` holds them: all that differs from run to run.
pub fn machine(study: &Study) -> Value {
    let (wall_s, speed, ns) = match &study.outcome {
        Outcome::Driven(run) => (run.record.wall_s, run.record.simulated_s_per_wall_s(), None),
        Outcome::Contact(solved) => (None, None, solved.answer.as_ref().and_then(|answer| answer.solution.ns_per_period)),
        Outcome::MonteCarlo(runs) => {
            let speed = runs.wall_s.map(|wall_s| runs.runs.len() as f64 * study.scene.duration_s / wall_s);
            (runs.wall_s, speed, None)
        }
    };
    let processors = std::thread::available_parallelism().map(std::num::NonZero::get).ok();
    let figures = [
        ("wall_s", wall_s.map(Value::from)),
        ("simulated_s_per_wall_s", speed.map(Value::from)),
        ("ns_per_period", ns.map(Value::from)),
        ("processors", processors.map(Value::from)),
        ("system", Some(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH).into())),
    ];
    figures.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect::<serde_json::Map<_, _>>().into()
}

/// The summary, as `summary.json` holds it. It is the same, byte for byte, of every run of the same scene.
pub fn summary(study: &Study) -> Value {
    let endless = study.monte_carlo().into_iter().flat_map(|runs| &runs.endless).map(|&name| (name.to_owned(), Value::Null));
    let metrics: serde_json::Map<String, Value> =
        study.metrics.iter().map(|(name, value)| (name.to_owned(), json!(value))).chain(endless).collect();
    let expect: Vec<Value> = study
        .judged
        .iter()
        .map(|judged| {
            let mut expect = json!({
                "metric": judged.metric, "value": judged.value, "limit": judged.limit,
                "pass": judged.pass, "source": judged.source,
            });
            if !judged.counts {
                expect["counts"] = json!(false);
            }
            if let Some((case, equal)) = &judged.case {
                (expect["case"], expect["match"]) = (json!(case), json!(equal));
            }
            expect
        })
        .collect();
    let grid = study.grid.as_ref().map(grid_file::json);
    let comparison = study.comparison.as_ref().map(comparison::json);
    let summary = json!({
        "scene": study.name, "seed": study.scene.seed, "metrics": metrics, "expect": expect, "grid": grid,
        "comparison": comparison, "interrupted": study.interrupted,
    });
    with_own(with_not_drawn(summary, study), study)
}

/// Adds which measured curves are not shown, if there are such.
fn with_not_drawn(mut of: Value, study: &Study) -> Value {
    let not_drawn = tables::not_drawn(study);
    if !not_drawn.is_empty() {
        of["overlays_not_drawn"] = json!(not_drawn);
    }
    of
}

/// Adds what only this kind of study has: the hash of what was played, or how the answer was come by.
fn with_own(mut of: Value, study: &Study) -> Value {
    match &study.outcome {
        Outcome::Driven(run) => of["drive_hash"] = json!(format!("{:016x}", run.record.drive_hash)),
        Outcome::MonteCarlo(runs) => {
            of["runs"] = json!(runs.runs.len());
            of["drive_hash"] = json!(runs.drive_hash().map(|hash| format!("{hash:016x}")));
        }
        Outcome::Contact(solved) => {
            of["solution"] = json!(solved.answer.as_ref().map(|Answer { solution, .. }| {
                let mut how = json!({
                    "method": solution.method.name(), "why": solution.why, "order": solution.order,
                    "steps_per_period": solution.steps_per_period, "error_estimate": solution.error_estimate,
                    "tolerance_met": solution.tolerance_met,
                    "warnings": solution.warnings,
                });
                if let Some(error) = solution.record_error_estimate {
                    how["record_error_estimate"] = json!(error);
                }
                how
            }));
        }
    }
    of
}

/// The manifest: everything that the run depended on.
fn manifest(loaded: &Loaded, study: &Study, provenance: &Provenance) -> Value {
    let mut manifest = json!({
        "program": "sim-host", "version": crate::VERSION, "scene": study.name, "seed": study.scene.seed,
        "level": tables::level(study), "input_hash": format!("{:016x}", text_hash(&loaded.input)), "set": loaded.sets,
        "interrupted": study.interrupted, "complete": !study.interrupted, "resolved_scene": resolved_json(study.scene),
    });
    if let Some(commit) = &provenance.commit {
        manifest["commit"] = json!(commit);
    }
    if let Some(inherited) = &study.inherited {
        manifest["inherited"] = json!(inherited);
    }
    with_own(with_not_drawn(manifest, study), study)
}

/// Writes everything into `dir`, which is made if it is not there, in place of the run that it holds.
pub fn write(loaded: &Loaded, study: &Study, dir: &Path) -> Result<(), OutputError> {
    write_into(loaded, study, &Folder::open(dir)?, &Presentation::default())
}

/// Writes everything into a folder, in place of the run that it holds, shown as it is asked for.
pub fn write_into(loaded: &Loaded, study: &Study, folder: &Folder, shown: &Presentation) -> Result<(), OutputError> {
    let dir = folder.unfinished();
    for (name, json) in [("summary.json", summary(study)), ("machine.json", machine(study))] {
        let path = dir.join(name);
        fs::write(&path, format!("{json:#}\n")).map_err(|io| OutputError::Write { path, io })?;
    }
    match study.monte_carlo() {
        Some(runs) => runs_file::write(runs, &dir.join("runs.csv")).map_err(OutputError::Runs)?,
        None => trace_file::write(study, dir)?,
    }
    if let Some(grid) = &study.grid {
        grid_file::write(grid, &dir.join("grid.csv")).map_err(OutputError::Grid)?;
    }
    report::write_drawn(&tables::report(study, &shown.provenance), dir, &shown.drawing)?;
    folder.finish(manifest(loaded, study, &shown.provenance))
}
