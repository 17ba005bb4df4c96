//! `trace.csv`, or `trace.npy` or `trace.parquet` where the scene's `[trace]` asks for it. Units are in the column names.
//!
//! Of a driven run: what the scene's `[trace]` asked for, at the sample rate; or, without one, a table of the whole run, one row for
//! every few blocks. Of a contact study: the last periods, step by step.

use std::path::{Path, PathBuf};

use super::{OutputError, npy, parquet_file};
use crate::data::{OVERVIEW, PERIODS};
use crate::record::Record;
use crate::study::contact::Solved;
use crate::study::{Outcome, Study};
use crate::trace::Tracer;
use scene::TraceFormat;

/// Most rows of the table of a whole run.
const ROWS: usize = 3000;

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
        _ => Ok(text(study, &path("csv"))?),
    }
}

/// Names of the columns: the time, then the signals.
fn columns(tracer: &Tracer) -> Vec<String> {
    std::iter::once("time_s".to_owned()).chain(tracer.signals().iter().map(|signal| signal.name())).collect()
}

fn text(study: &Study, path: &Path) -> Result<(), csv::Error> {
    let mut file = csv::Writer::from_path(path)?;
    match &study.outcome {
        Outcome::Driven(run) => match &run.record.trace {
            Some(tracer) => signals(tracer, &mut file)?,
            None => overview(&run.record, &mut file)?,
        },
        Outcome::Contact(solved) => last_periods(solved, &mut file)?,
        // What several runs leave is `runs.csv`.
        Outcome::MonteCarlo(_) => {}
    }
    file.flush()?;
    Ok(())
}

fn signals(tracer: &Tracer, file: &mut csv::Writer<std::fs::File>) -> Result<(), csv::Error> {
    file.write_record(columns(tracer))?;
    for row in tracer.rows() {
        file.write_record(row.iter().map(f64::to_string))?;
    }
    Ok(())
}

fn last_periods(solved: &Solved, file: &mut csv::Writer<std::fs::File>) -> Result<(), csv::Error> {
    file.write_record(PERIODS.map(|(name, ..)| name))?;
    for state in solved.playback.last_periods() {
        let row = [state.time_s, state.x_m, state.v_m_per_s, state.force_n];
        file.write_record(row.map(|value| value.to_string()))?;
    }
    Ok(())
}

fn overview(record: &Record, file: &mut csv::Writer<std::fs::File>) -> Result<(), csv::Error> {
    file.write_record(OVERVIEW.iter().map(|column| column.name))?;
    let rows = &record.rows;
    for row in rows.iter().step_by(rows.len().div_ceil(ROWS).max(1)) {
        file.write_record(OVERVIEW.iter().map(|column| (column.value)(row).to_string()))?;
    }
    Ok(())
}
