//! Signals of a scene's `[trace]`, as played and measured.

use firmware::seam::block::{DriveBlock, SenseBlock};

use plant::truth::Sample;
use scene::{Signal, Trace};

/// Recorder of the signals of a scene's `[trace]`.
#[derive(Clone, Debug)]
pub struct Tracer {
    signals: Vec<Signal>,
    every: u64,
    samples: std::ops::Range<u64>,
    sample_s: f64,
    rows: Vec<Vec<f64>>,
}

/// Codes and truth of one block.
pub struct Played<'a> {
    /// Number of the block's first sample.
    pub first: u64,
    /// Drive frequency of the block, Hz.
    pub frequency_hz: f64,
    /// Drive codes of all lanes.
    pub drive: &'a DriveBlock,
    /// Sense codes of voltage and current.
    pub sense: &'a SenseBlock,
    /// True values of the plant, sample by sample.
    pub samples: &'a [Sample],
}

impl Tracer {
    /// Creates a tracer for a scene's `[trace]`.
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

    /// Returns the signals, in the order of the columns after the time.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// Returns the recorded rows: time, s, then the signals.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Returns `true` if any of `samples` samples from `first` on must be recorded.
    pub fn records(&self, first: u64, samples: u64) -> bool {
        first < self.samples.end && first + samples > self.samples.start
    }

    /// Records the selected samples of a block.
    pub fn record(&mut self, played: &Played) {
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
