//! `trace.csv`, or `trace.npy` or `trace.parquet` as set in the scene's `[trace]`. Units are in the
//! column names.
//!
//! A driven run has the signals of its `[trace]` at the sample rate; without `[trace]`, a table of
//! the whole run with one row for every few blocks. A contact study has its last periods, step by
//! step.

use std::path::{Path, PathBuf};

use super::{OutputError, npy, parquet_file};
use crate::study::Study;
use crate::trace_table::{self, columns};
use scene::TraceFormat;

/// Writes the trace of a study into its folder.
pub(super) fn write(study: &Study, dir: &Path) -> Result<(), OutputError> {
    let traced = study.run().and_then(|run| run.record.trace.as_ref()).zip(study.scene.trace.as_ref());
    let path = |end: &str| dir.join(format!("trace.{end}"));
    let written = |path: PathBuf| |io| OutputError::Write { path, io };
    match traced.map(|(tracer, trace)| (tracer, trace.format)) {
        Some((tracer, TraceFormat::Npy)) => {
            npy::write(&columns(tracer), tracer.rows(), &path("npy")).map_err(written(path("npy")))
        }
        Some((tracer, TraceFormat::Parquet)) => {
            parquet_file::write_table(&columns(tracer), tracer.rows(), &path("parquet")).map_err(written(path("parquet")))
        }
        _ => Ok(trace_table::write(study, csv::Writer::from_path(path("csv"))?)?),
    }
}
