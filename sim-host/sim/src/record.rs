//! Record of a run: one row per block with command, estimate and truth, and several windows sample
//! by sample.

use firmware::generate::nco::cycles_per_sample;
use firmware::seam::block::SlowSense;
use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;
use firmware::seam::phasor::magnitude;
use firmware::seam::telemetry::FrictionEstimate;
use firmware::seam::telemetry::Telemetry;

use crate::edge_meter::Edges;
use crate::processor::{Load, Memory};
use crate::swing::Swing;
use crate::trace::Tracer;
use plant::dring::crash::Playback;
use plant::energy::Energy;
use plant::truth::{MotorTruth, Sample, Truth};

/// Record of one block: command, estimate, measurement and truth.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Index of the row in its record.
    pub number: u32,
    /// Time at the block's end, s.
    pub time_s: f64,
    /// Mode of the controller after it had measured this block.
    pub mode: Mode,
    /// Fault number of the controller, or zero.
    pub fault: u8,
    /// Limit number of the controller, or zero.
    pub limit: u8,
    /// `true` if the controller reported a lock.
    pub locked: bool,
    /// Command: frequency that played in this block, Hz.
    pub frequency_hz: f64,
    /// Command: peak drive voltage that played, V, times the mean envelope.
    pub drive_v: f64,
    /// Command: mean envelope that played.
    pub envelope: f64,
    /// Command: `true` for a step of a measurement that has been interrupted since.
    pub(crate) probes: bool,
    /// Time at the end of this block that a fault dropped and made silent, s.
    pub dropped_s: f64,
    /// Swing of the codes that played.
    pub swing: Swing,
    /// Estimate: resonance of the transducer, Hz.
    pub resonance_estimate_hz: f64,
    /// Estimate: motional current, A.
    pub motional_current_a: f64,
    /// Estimate: phase that the tracker controls to zero, degrees.
    pub phase_deg: f64,
    /// Estimate: friction, if it is switched.
    pub friction: Option<FrictionEstimate>,
    /// Sensed: admittance, S; only if there was a voltage.
    pub admittance_s: Option<(f64, f64)>,
    /// Sensed: counts of the belt's encoder, if there is one with intact lines.
    pub belt_counts: Option<i32>,
    /// Sensed: force channel, N.
    pub force_n: Option<f64>,
    /// Truth: state of the plant.
    pub truth: Truth,
}

/// Time window that is recorded sample by sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Window {
    /// Contents of the window, as a title.
    pub title: String,
    /// Time of the edge that the window shows, s.
    pub edge_s: f64,
    /// Beginning of the window, s.
    pub from_s: f64,
    /// End of the window, s.
    pub to_s: f64,
    /// Trigger that the window waits for from `from_s` on; its duration is kept.
    pub trigger: Option<Trigger>,
    /// Time of the first sample's end, s.
    pub start_s: f64,
    /// Samples within the window.
    pub samples: Vec<Sample>,
}

/// Trigger at the beginning of a sweep: the first block's frequency, not preceded by the second's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trigger {
    /// Mean frequency of a sweep's first block, Hz.
    pub first_hz: f64,
    /// Mean frequency of a sweep's second block, Hz. A sweep that runs back ends with its second
    /// and first block.
    pub second_hz: f64,
    /// Mean frequency of the block before, Hz.
    pub before_hz: f64,
}

impl Window {
    /// Checks the beginning of a block, s, and its mean frequency, Hz, and opens the window if they
    /// match its trigger.
    pub fn record_frequency(&mut self, begins_s: f64, frequency_hz: f64) {
        let Some(trigger) = &mut self.trigger else { return };
        let near_hz = 0.25 * (trigger.second_hz - trigger.first_hz).abs();
        let near = |hz: f64, other_hz: f64| (hz - other_hz).abs() <= near_hz;
        let begins = near(frequency_hz, trigger.first_hz) && !near(trigger.before_hz, trigger.second_hz);
        trigger.before_hz = frequency_hz;
        // The times of block and window are computed differently and may differ by rounding.
        if begins && begins_s > self.from_s - 1e-9 {
            self.to_s += begins_s - self.from_s;
            (self.from_s, self.trigger) = (begins_s, None);
        }
    }
}

/// Instructions or cycles taken by blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Taken {
    /// Number of blocks counted.
    pub blocks: u64,
    /// Sum over all blocks.
    pub total: u64,
    /// Maximum of a block.
    pub worst: u32,
}

impl Taken {
    /// Counts one more block.
    pub fn add(&mut self, taken: u32) {
        self.blocks += 1;
        self.total += u64::from(taken);
        self.worst = self.worst.max(taken);
    }
}

/// Record of a run.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Duration of one sample, s.
    pub sample_s: f64,
    /// Samples in a block.
    pub block_samples: usize,
    /// Number of blocks per row: one, unless the run is long.
    pub every: u64,
    /// Rows of every block, or of every few blocks.
    pub rows: Vec<Row>,
    /// True state of a motor in each row's block; empty without a motor.
    pub motors: Vec<MotorTruth>,
    /// Windows sample by sample.
    pub windows: Vec<Window>,
    /// Edges of bursts.
    pub edges: Vec<Edges>,
    /// Signals of the scene's `[trace]`.
    pub trace: Option<Tracer>,
    /// Last telemetry of the controller.
    pub last: Telemetry,
    /// Energy budget of the plant.
    pub energy: Energy,
    /// Playback of a crash.
    pub crash: Option<Playback>,
    /// Number of integrated states.
    pub plant_states: usize,
    /// Instructions of all blocks, if counted.
    pub instructions: Option<Taken>,
    /// Cycles of all blocks, if counted.
    pub cycles: Option<Taken>,
    /// Load of the processor, if its part is modelled.
    pub load: Option<Load>,
    /// Memory of the controller's processor, if measured.
    pub memory: Option<Memory>,
    /// Hash of every drive code played.
    pub drive_hash: u64,
    /// `true` if the run was stopped before its end.
    pub interrupted: bool,
    /// Wall time of the simulation itself, s.
    pub wall_s: Option<f64>,
}

impl Record {
    /// Returns simulated time over wall time, if the run was timed.
    pub fn simulated_s_per_wall_s(&self) -> Option<f64> {
        let simulated_s = self.rows.last().map_or(0.0, |row| row.time_s);
        self.wall_s.map(|wall_s| simulated_s / wall_s)
    }
}

/// Smallest relative difference between a frequency off resonance on purpose and the resonance, for
/// Q below 7500.
const MIN_STEP_REL: f64 = 1e-5;

/// Command of a block, until it plays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Command {
    word: u64,
    drive_v: f64,
    envelope: f64,
    probes: bool,
    /// Time at the end of the block that was dropped, s.
    pub dropped_s: f64,
}

impl Command {
    /// Returns the frequency of the command, Hz.
    pub fn frequency_hz(&self, sample_hz: f64) -> f64 {
        cycles_per_sample(self.word) * sample_hz
    }

    /// Extracts the command from the telemetry that accompanied its codes.
    pub fn from_telemetry(telemetry: &Telemetry) -> Self {
        let (drive_v, envelope) = (telemetry.drive.0.into(), telemetry.envelope.into());
        let probes = telemetry.limit == Some(Limit::Probing);
        Command { word: telemetry.tuning_word, drive_v, envelope, probes, dropped_s: 0.0 }
    }
}

impl Row {
    /// Returns `true` if the controller drives off resonance on purpose, to measure the clamped
    /// branch, or if a step of an interrupted measurement still plays.
    pub fn probes(&self) -> bool {
        self.probes || self.limit == Limit::Probing as u8
    }

    /// Creates the row of a block in which `command` played.
    pub fn new(
        number: u32,
        (time_s, sample_hz): (f64, f64),
        command: &Command,
        telemetry: &Telemetry,
        (swing, slow, truth): (Swing, SlowSense, &Truth),
    ) -> Self {
        let voltage = magnitude(telemetry.v);
        let admittance = || {
            let y = telemetry.i / telemetry.v;
            (y.re.into(), y.im.into())
        };
        Row {
            number,
            time_s,
            mode: telemetry.mode,
            fault: telemetry.fault.map_or(0, |fault| fault as u8),
            limit: telemetry.limit.map_or(0, |limit| limit as u8),
            locked: telemetry.locked,
            frequency_hz: command.frequency_hz(sample_hz),
            drive_v: command.drive_v * command.envelope,
            envelope: command.envelope,
            probes: command.probes && (command.word as f64 / telemetry.tuning_word as f64 - 1.0).abs() > MIN_STEP_REL,
            dropped_s: command.dropped_s,
            swing,
            resonance_estimate_hz: telemetry.resonance.0.into(),
            motional_current_a: magnitude(telemetry.motional_current).into(),
            phase_deg: telemetry.phase.degrees().into(),
            friction: telemetry.friction,
            admittance_s: (command.drive_v * command.envelope > 0.0 && voltage > 0.0).then(admittance),
            belt_counts: slow.belt.filter(|belt| !belt.broken).map(|belt| belt.counts),
            force_n: slow.force.map(f64::from),
            truth: *truth,
        }
    }
}

/// Returns the hash of a text, by the same function as the drive's; it identifies an input.
pub fn text_hash(text: &str) -> u64 {
    crc::Crc::<u64>::new(&crc::CRC_64_XZ).checksum(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The window opens at the first block of an upward sweep from any previous frequency; the
    /// sweep has 1 kHz per block from 20 kHz.
    #[test]
    fn window_opens_at_the_beginning_of_a_sweep() {
        let trigger = Trigger { first_hz: 20.5e3, second_hz: 21.5e3, before_hz: 0.0 };
        let opens = |frequencies: &[f64]| {
            let mut window = Window { from_s: 2.0, to_s: 5.0, trigger: Some(trigger), ..Window::default() };
            frequencies.iter().enumerate().for_each(|(block, &hz)| window.record_frequency(block as f64, hz));
            (window.trigger.is_none()).then_some((window.from_s, window.to_s))
        };
        let repeated = [20.5e3, 21.5e3, 22.5e3, 20.5e3, 21.5e3];
        let back_and_forth = [20.5e3, 21.5e3, 22.5e3, 22.5e3, 21.5e3, 20.5e3, 20.5e3, 21.5e3];
        assert_eq!(opens(&repeated), Some((3.0, 6.0)));
        assert_eq!(opens(&back_and_forth), Some((6.0, 9.0)));
        assert_eq!(opens(&[40e3, 40e3, 40e3, 20.5e3]), Some((3.0, 6.0)));
        assert_eq!(opens(&[20.5e3, 21.5e3, 22.5e3, 40e3]), None);
    }
}
