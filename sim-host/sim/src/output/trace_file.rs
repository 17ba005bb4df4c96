//! `trace.csv`. Units are in the column names.
//!
//! Of a driven run: what the scene's `[trace]` asked for, at the sample rate; or, without one, a table of the whole run, one row for
//! every few blocks. Of a contact study: the last periods, step by step.

use std::path::Path;

use crate::data::{OVERVIEW, PERIODS};
use crate::record::Record;
use crate::study::contact::Solved;
use crate::study::{Outcome, Study};
use crate::trace::Tracer;

/// Most rows of the table of a whole run.
const ROWS: usize = 3000;

/// Writes the trace of a study.
pub(super) fn write(study: &Study, path: &Path) -> Result<(), csv::Error> {
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
    file.write_record(std::iter::once("time_s".to_owned()).chain(tracer.signals().iter().map(|signal| signal.name())))?;
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
