//! Output of a study into its folder: manifest, summary, trace, report and figures.

mod folder;
mod grid_file;
pub mod npy;
pub mod optimise;
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
use crate::study::design::stack;
use crate::study::{Outcome, Study};
use crate::summary::{with_own, with_provisos};
use crate::tables;
use report::{self, Drawing, ReportError};
use scene::load::Loaded;
use scene::resolved::resolved_json;

pub use crate::summary::{machine, printed, summary};
pub(crate) use folder::checksum;
pub use folder::{Folder, Owner, default_dir, rename_synced};

/// Error of writing a folder.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A file cannot be written.
    #[error("cannot write `{path}`")]
    Write {
        /// File or folder.
        path: PathBuf,
        /// Reason.
        #[source]
        io: io::Error,
    },
    /// A file in the folder may not be replaced.
    #[error("`{path}` {why}, and is not replaced: move it, or choose another folder with -o")]
    Taken {
        /// File.
        path: PathBuf,
        /// Reason, as a predicate.
        why: String,
    },
    /// Another run is being written into the folder.
    #[error(
        "another run is being written into `{path}`, by process {process}: wait for its end, or choose another folder with -o"
    )]
    Held {
        /// Folder.
        path: PathBuf,
        /// Process that writes the folder.
        process: String,
    },
    /// After the run, a file in the folder may not be replaced.
    #[error(
        "`{path}` {why}, and is not replaced; the complete result is in `{run}`: move one of the two, or choose another folder \
         with -o"
    )]
    InTheWay {
        /// File.
        path: PathBuf,
        /// Reason, as a predicate.
        why: String,
        /// Folder of the result.
        run: PathBuf,
    },
    /// A figure or the report cannot be written.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The trace cannot be written.
    #[error("cannot write the trace")]
    Trace(#[from] csv::Error),
    /// The table of several runs cannot be written.
    #[error("cannot write the table of the runs")]
    Runs(#[source] csv::Error),
    /// The table of the grid cannot be written.
    #[error("cannot write the table of the grid")]
    Grid(#[source] csv::Error),
}

/// Presentation of a folder's results: figures, and provenance.
#[derive(Clone, Debug, Default)]
pub struct Presentation {
    /// Size and formats of the figures.
    pub drawing: Drawing,
    /// Levels of the contour lines in the maps of a sweep.
    pub contours: Vec<f64>,
    /// Command, commit and date.
    pub provenance: Provenance,
}

/// Returns the manifest: everything that the run depended on.
fn manifest(loaded: &Loaded, study: &Study, provenance: &Provenance) -> Value {
    let mut scene = resolved_json(study.scene);
    if let Some(runs) = study.monte_carlo() {
        scene["runs"] = json!(runs.asked);
    }
    let mut manifest = json!({
        "scene": study.name, "seed": study.scene.seed,
        "level": tables::level(study), "input_hash": format!("{:016x}", text_hash(&loaded.input)), "set": loaded.sets,
        "interrupted": study.interrupted, "complete": !study.interrupted, "resolved_scene": scene,
    });
    if let Some(commit) = &provenance.commit {
        manifest["commit"] = json!(commit);
    }
    if let Some(inherited) = &study.inherited {
        manifest["inherited"] = json!(inherited);
    }
    with_own(with_provisos(manifest, study), study)
}

/// Writes a study into `dir`, which is created if needed, and replaces the run in it.
pub fn write(loaded: &Loaded, study: &Study, dir: &Path) -> Result<(), OutputError> {
    write_into(loaded, study, &Folder::open(dir, Owner::new("run", loaded.files()))?, &Presentation::default())
}

/// Writes a study into a folder, and replaces the run in it.
pub fn write_into(loaded: &Loaded, study: &Study, folder: &Folder, shown: &Presentation) -> Result<(), OutputError> {
    let dir = folder.unfinished();
    let mut machine = machine(study);
    if let Some(date) = &shown.provenance.date {
        machine["date"] = json!(date);
    }
    for (name, json) in [("summary.json", summary(study)), ("machine.json", machine)] {
        let path = dir.join(name);
        fs::write(&path, format!("{json:#}\n")).map_err(|io| OutputError::Write { path, io })?;
    }
    match &study.outcome {
        Outcome::MonteCarlo(runs) => runs_file::write(runs, &dir.join("runs.csv")).map_err(OutputError::Runs)?,
        Outcome::Design(drawn) if drawn.solved.circuit.is_some() => {
            let path = dir.join("stack.toml");
            fs::write(&path, stack::text(drawn, &study.name)).map_err(|io| OutputError::Write { path, io })?;
        }
        Outcome::Design(_) => {}
        Outcome::Driven(_) | Outcome::Contact(_) => trace_file::write(study, dir)?,
    }
    if let Some(grid) = &study.grid {
        grid_file::write(grid, &dir.join("grid.csv")).map_err(OutputError::Grid)?;
    }
    report::write_drawn(&tables::report(study, &shown.provenance), dir, &shown.drawing)?;
    folder.finish(manifest(loaded, study, &shown.provenance))
}
