//! What a study leaves in its folder: manifest, summary, trace, report and figures.

mod trace_file;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::findings;
use crate::record::text_hash;
use crate::report::{self, ReportError};
use crate::scene::load::Loaded;
use crate::scene::resolved::resolved_json;
use crate::study::Study;

/// What went wrong with the folder.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A file.
    #[error("cannot write `{path}`")]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        #[source]
        io: io::Error,
    },
    /// A figure or the report.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The trace.
    #[error("cannot write the trace")]
    Trace(#[from] csv::Error),
}

/// The summary: what `--format json` prints, and `summary.json` holds.
pub fn summary(study: &Study) -> Value {
    let metrics: serde_json::Map<String, Value> =
        study.metrics.iter().map(|(name, value)| (name.to_owned(), json!(value))).collect();
    let expect: Vec<Value> = study
        .judged
        .iter()
        .map(|judged| {
            json!({
                "metric": judged.metric, "value": judged.value, "limit": judged.limit,
                "pass": judged.pass, "source": judged.source,
            })
        })
        .collect();
    let grid = study.grid.as_ref().map(|result| {
        json!({
            "title": result.grid.title, "metric": result.grid.metric, "row_key": result.grid.row_key, "rows": result.grid.rows,
            "column_key": result.grid.column_key, "columns": result.grid.columns, "cells": result.cells,
        })
    });
    json!({
        "scene": study.name, "seed": study.scene.seed, "metrics": metrics, "expect": expect, "grid": grid,
        "drive_hash": format!("{:016x}", study.record.drive_hash), "interrupted": study.record.interrupted,
    })
}

/// The manifest: everything that the run depended on.
fn manifest(loaded: &Loaded, study: &Study) -> Value {
    json!({
        "program": "sim-host", "version": findings::VERSION, "scene": study.name, "seed": study.scene.seed, "level": study.level.to_string(),
        "input_hash": format!("{:016x}", text_hash(&loaded.input)), "set": loaded.sets,
        "drive_hash": format!("{:016x}", study.record.drive_hash), "interrupted": study.record.interrupted,
        "resolved_scene": resolved_json(&study.scene),
    })
}

/// Writes everything into `dir`, which is made if it is not there.
pub fn write(loaded: &Loaded, study: &Study, dir: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(dir).map_err(|io| OutputError::Write { path: dir.into(), io })?;
    let json = |name: &str, value: &Value| {
        let path = dir.join(name);
        fs::write(&path, format!("{value:#}\n")).map_err(|io| OutputError::Write { path, io })
    };
    json("manifest.json", &manifest(loaded, study))?;
    json("summary.json", &summary(study))?;
    trace_file::write(&study.record, &dir.join("trace.csv"))?;
    report::write(&findings::report(study), dir)?;
    Ok(())
}
