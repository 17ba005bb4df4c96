//! Trace of a study as CSV, for a file or for memory. Units are in the column names.

use std::io::Write;

use crate::data::{OVERVIEW, PERIODS};
use crate::record::Record;
use crate::study::contact::Solved;
use crate::study::{Outcome, Study};
use crate::trace::Tracer;

/// Maximum number of rows of the table of a whole run.
const MAX_ROWS: usize = 3000;

/// Returns the trace of a study as the text of `trace.csv`; empty for several runs.
///
/// # Errors
/// If the trace cannot be written.
pub fn text(study: &Study) -> Result<Vec<u8>, csv::Error> {
    let mut text = Vec::new();
    write(study, csv::Writer::from_writer(&mut text))?;
    Ok(text)
}

/// Returns the names of the columns: the time, then the signals.
pub(crate) fn columns(tracer: &Tracer) -> Vec<String> {
    std::iter::once("time_s".to_owned()).chain(tracer.signals().iter().map(|signal| signal.name())).collect()
}

/// Writes the trace of a study as CSV.
pub(crate) fn write<W: Write>(study: &Study, mut file: csv::Writer<W>) -> Result<(), csv::Error> {
    match &study.outcome {
        Outcome::Driven(run) => match &run.record.trace {
            Some(tracer) => signals(tracer, &mut file)?,
            None => overview(&run.record, &mut file)?,
        },
        Outcome::Contact(solved) => last_periods(solved, &mut file)?,
        // Several runs write `runs.csv` instead, and a design its figures.
        Outcome::Design(_) | Outcome::MonteCarlo(_) => {}
    }
    file.flush()?;
    Ok(())
}

fn signals<W: Write>(tracer: &Tracer, file: &mut csv::Writer<W>) -> Result<(), csv::Error> {
    file.write_record(columns(tracer))?;
    for row in tracer.rows() {
        file.write_record(row.iter().map(f64::to_string))?;
    }
    Ok(())
}

fn last_periods<W: Write>(solved: &Solved, file: &mut csv::Writer<W>) -> Result<(), csv::Error> {
    file.write_record(PERIODS.map(|(name, ..)| name))?;
    for state in solved.playback.last_periods() {
        let row = [state.time_s, state.x_m, state.v_m_per_s, state.force_n];
        file.write_record(row.map(|value| value.to_string()))?;
    }
    Ok(())
}

fn overview<W: Write>(record: &Record, file: &mut csv::Writer<W>) -> Result<(), csv::Error> {
    file.write_record(OVERVIEW.iter().map(|column| column.name))?;
    let rows = &record.rows;
    for row in rows.iter().step_by(rows.len().div_ceil(MAX_ROWS).max(1)) {
        file.write_record(OVERVIEW.iter().map(|column| (column.value)(row).to_string()))?;
    }
    Ok(())
}
