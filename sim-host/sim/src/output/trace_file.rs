//! `trace.csv`. Units are in the column names.
//!
//! Of a driven run: what the scene's `[trace]` asked for, at the sample rate; or, without one, a table of the whole run, one row for
//! every few blocks. Of a contact study: the last periods, step by step.

use std::path::Path;

use crate::record::Record;
use crate::study::contact::Solved;
use crate::study::{Outcome, Study};
use crate::trace::Tracer;
use scene::Signal;

/// Most rows of the table of a whole run.
const ROWS: usize = 3000;

/// The name of a signal, as scenes and columns spell it.
fn name(signal: Signal) -> String {
    match serde_json::to_value(signal) {
        Ok(serde_json::Value::String(name)) => name,
        _ => format!("{signal:?}"),
    }
}

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
    file.write_record(std::iter::once("time_s".to_owned()).chain(tracer.signals().iter().map(|&signal| name(signal))))?;
    for row in tracer.rows() {
        file.write_record(row.iter().map(f64::to_string))?;
    }
    Ok(())
}

fn last_periods(solved: &Solved, file: &mut csv::Writer<std::fs::File>) -> Result<(), csv::Error> {
    file.write_record(["time_s", "displacement_m", "velocity_m_per_s", "friction_n"])?;
    for state in solved.film.last_periods() {
        let row = [state.time_s, state.x_m, state.v_m_per_s, state.force_n];
        file.write_record(row.map(|value| value.to_string()))?;
    }
    Ok(())
}

fn overview(record: &Record, file: &mut csv::Writer<std::fs::File>) -> Result<(), csv::Error> {
    file.write_record([
        "time_s",
        "mode",
        "fault_code",
        "limit_code",
        "frequency_command_hz",
        "resonance_estimate_hz",
        "series_resonance_true_hz",
        "drive_v",
        "envelope",
        "motional_current_estimate_a",
        "tip_velocity_true_m_per_s",
        "friction_true_n",
        "load_cell_n",
        "power_true_w",
    ])?;
    let rows = &record.rows;
    for row in rows.iter().step_by(rows.len().div_ceil(ROWS).max(1)) {
        let numbers = [
            row.frequency_hz,
            row.resonance_estimate_hz,
            row.truth.series_resonance_hz,
            row.drive_v,
            row.envelope,
            row.motional_current_a,
            row.truth.tip_velocity_m_per_s,
            row.truth.friction_mean_n,
            row.truth.load_cell_n,
            row.truth.power_w,
        ];
        let head = [row.time_s.to_string(), format!("{:?}", row.mode), row.fault.to_string(), row.limit.to_string()];
        file.write_record(head.into_iter().chain(numbers.map(|x| x.to_string())))?;
    }
    Ok(())
}
