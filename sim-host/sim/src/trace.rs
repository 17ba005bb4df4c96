//! The signals that a scene's `[trace]` asks for, as they are played and heard.

use firmware::seam::block::{DriveBlock, SenseBlock};

use plant::truth::Sample;
use scene::{Signal, Trace};

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

    /// The signals, in the order of the columns after the time.
    pub fn signals(&self) -> &[Signal] {
        &self.signals
    }

    /// What was kept: time, s, then the signals.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
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
