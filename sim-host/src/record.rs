//! What a run leaves behind: one row a block, three ways (command, estimate, truth), and a few windows sample by sample.

use firmware::nco::cycles_per_sample;
use firmware::phasor::magnitude;
use firmware::supervisor::Mode;
use firmware::telemetry::Telemetry;

use crate::plant::energy::Energy;
use crate::plant::truth::{Sample, Truth};
use crate::trace::Tracer;

/// One block.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Time at the block's end, s.
    pub time_s: f64,
    /// What the controller was doing when it had heard this block.
    pub mode: Mode,
    /// Its fault number, or zero.
    pub fault: u8,
    /// Its limit number, or zero.
    pub limit: u8,
    /// Whether it called itself locked.
    pub locked: bool,
    /// Command: frequency that was playing in this block, Hz.
    pub frequency_hz: f64,
    /// Command: peak drive voltage that was playing, V; times the mean envelope.
    pub drive_v: f64,
    /// Command: mean envelope that was playing.
    pub envelope: f64,
    /// Estimate: resonance, Hz.
    pub resonance_estimate_hz: f64,
    /// Estimate: motional current, A.
    pub motional_current_a: f64,
    /// Estimate: phase that the tracker drives to zero, degrees.
    pub phase_deg: f64,
    /// Sensed: admittance, S; only where there was a voltage.
    pub admittance_s: Option<(f64, f64)>,
    /// Truth.
    pub truth: Truth,
}

/// A stretch of time kept sample by sample.
#[derive(Clone, Debug, Default)]
pub struct Window {
    /// What it shows.
    pub title: String,
    /// The moment it is about, s.
    pub edge_s: f64,
    /// From, s.
    pub from_s: f64,
    /// To, s.
    pub to_s: f64,
    /// Time of the first sample's end, s.
    pub start_s: f64,
    /// Samples.
    pub samples: Vec<Sample>,
}

/// The record of a run.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Duration of one sample, s.
    pub sample_s: f64,
    /// Samples in a block.
    pub block_samples: usize,
    /// Blocks from one row to the next: one, unless the run is long.
    pub every: u64,
    /// Every block, or every few.
    pub rows: Vec<Row>,
    /// Windows sample by sample.
    pub windows: Vec<Window>,
    /// What the scene's `[trace]` asks for.
    pub trace: Option<Tracer>,
    /// The last telemetry.
    pub last: Telemetry,
    /// The energy budget.
    pub energy: Energy,
    /// States that were integrated.
    pub plant_states: usize,
    /// The most instructions that a block has taken, where they are counted.
    pub worst_block_instructions: Option<u32>,
    /// Hash of every drive code played.
    pub drive_hash: u64,
    /// Whether the run was stopped before its end.
    pub interrupted: bool,
    /// Wall time of the simulation itself, s.
    pub wall_s: f64,
}

/// What was commanded for a block, until it plays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Command {
    word: u64,
    drive_v: f64,
    envelope: f64,
}

impl Command {
    /// Frequency, Hz.
    pub fn frequency_hz(&self, sample_hz: f64) -> f64 {
        cycles_per_sample(self.word) * sample_hz
    }

    /// What a report says of the codes that came with it.
    pub fn of(telemetry: &Telemetry) -> Self {
        Command { word: telemetry.tuning_word, drive_v: telemetry.drive.0.into(), envelope: telemetry.envelope.into() }
    }
}

impl Row {
    /// The row of a block in which `command` played.
    pub fn new(time_s: f64, sample_hz: f64, command: &Command, telemetry: &Telemetry, truth: &Truth) -> Self {
        let voltage = magnitude(telemetry.v);
        let admittance = || {
            let y = telemetry.i / telemetry.v;
            (y.re.into(), y.im.into())
        };
        Row {
            time_s,
            mode: telemetry.mode,
            fault: telemetry.fault.map_or(0, |fault| fault as u8),
            limit: telemetry.limit.map_or(0, |limit| limit as u8),
            locked: telemetry.locked,
            frequency_hz: command.frequency_hz(sample_hz),
            drive_v: command.drive_v * command.envelope,
            envelope: command.envelope,
            resonance_estimate_hz: telemetry.resonance.0.into(),
            motional_current_a: magnitude(telemetry.motional_current).into(),
            phase_deg: telemetry.phase.degrees().into(),
            admittance_s: (command.drive_v * command.envelope > 0.0 && voltage > 0.0).then(admittance),
            truth: *truth,
        }
    }
}

/// The hash of a text, by the same function as the drive's: identifies an input.
pub fn text_hash(text: &str) -> u64 {
    crc::Crc::<u64>::new(&crc::CRC_64_XZ).checksum(text.as_bytes())
}
