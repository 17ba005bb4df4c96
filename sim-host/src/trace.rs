//! `trace.csv`: the signals that a scene's `[trace]` asks for, at the sample rate; or a table of the whole run, one row for every
//! few blocks. Units are in the column names.

use std::path::Path;

use firmware::block::{DriveBlock, SenseBlock};

use crate::plant::Sample;
use crate::scene::{Signal, Trace};
use crate::study::Study;

/// Most rows of the table of a whole run.
const ROWS: usize = 3000;

/// Takes blocks as they are played, and keeps what the scene asks for.
#[derive(Clone, Debug)]
pub struct Tracer {
    signals: Vec<Signal>,
    every: u64,
    samples: std::ops::Range<u64>,
    sample_s: f64,
    rows: Vec<Vec<f64>>,
}

/// What there is to know of one block.
pub struct Played<'a> {
    /// Number of its first sample.
    pub first: u64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Drive codes.
    pub drive: &'a DriveBlock,
    /// Sense codes.
    pub sense: &'a SenseBlock,
    /// The truth, sample by sample.
    pub samples: &'a [Sample],
}

impl Tracer {
    /// A tracer for a scene's `[trace]`.
    pub fn new(trace: &Trace, duration_s: f64, sample_s: f64) -> Self {
        let number = |seconds: f64| (seconds / sample_s).round() as u64;
        Tracer {
            signals: trace.signals.clone(),
            every: trace.every.into(),
            samples: number(trace.from_s)..number(trace.to_s.unwrap_or(duration_s)),
            sample_s,
            rows: Vec::new(),
        }
    }

    /// Whether any of `samples` samples from `first` on are wanted.
    pub fn wants(&self, first: u64, samples: u64) -> bool {
        first < self.samples.end && first + samples > self.samples.start
    }

    /// Keeps what is wanted of a block.
    pub fn keep(&mut self, played: &Played) {
        for (n, sample) in played.samples.iter().enumerate() {
            let number = played.first + n as u64;
            if self.samples.contains(&number) && (number - self.samples.start).is_multiple_of(self.every) {
                let time_s = (number + 1) as f64 * self.sample_s;
                let values = self.signals.iter().map(|&signal| value(signal, played, n, sample));
                self.rows.push(std::iter::once(time_s).chain(values).collect());
            }
        }
    }
}

fn value(signal: Signal, played: &Played, n: usize, sample: &Sample) -> f64 {
    let lane = |lane: usize| played.drive.lanes.get(lane).and_then(|codes| codes.get(n)).map_or(f64::NAN, |&code| code.into());
    match signal {
        Signal::DriveCode0 => lane(0),
        Signal::DriveCode1 => lane(1),
        Signal::DriveCode2 => lane(2),
        Signal::DriveCode3 => lane(3),
        Signal::VCode => played.sense.v.get(n).map_or(f64::NAN, |&code| code.into()),
        Signal::ICode => played.sense.i.get(n).map_or(f64::NAN, |&code| code.into()),
        Signal::FrequencyHz => played.frequency_hz,
        Signal::StackVoltageV => sample.voltage_v,
        Signal::MotionalCurrentA => sample.motional_current_a,
        Signal::TipVelocityMPerS => sample.tip_velocity_m_per_s,
        Signal::FrictionN => sample.friction_n,
    }
}

/// The name of a signal, as scenes and columns spell it.
fn name(signal: Signal) -> String {
    match serde_json::to_value(signal) {
        Ok(serde_json::Value::String(name)) => name,
        _ => format!("{signal:?}"),
    }
}

/// Writes the trace of a study.
pub fn write(study: &Study, path: &Path) -> Result<(), csv::Error> {
    let mut file = csv::Writer::from_path(path)?;
    match &study.record.trace {
        Some(tracer) => {
            file.write_record(std::iter::once("time_s".to_owned()).chain(tracer.signals.iter().map(|&signal| name(signal))))?;
            for row in &tracer.rows {
                file.write_record(row.iter().map(f64::to_string))?;
            }
        }
        None => overview(study, &mut file)?,
    }
    file.flush()?;
    Ok(())
}

fn overview(study: &Study, file: &mut csv::Writer<std::fs::File>) -> Result<(), csv::Error> {
    file.write_record([
        "time_s",
        "mode",
        "fault_code",
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
    let rows = &study.record.rows;
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
        let head = [row.time_s.to_string(), format!("{:?}", row.mode), row.fault.to_string()];
        file.write_record(head.into_iter().chain(numbers.map(|x| x.to_string())))?;
    }
    Ok(())
}
