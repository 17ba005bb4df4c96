//! Captures: the raw codes of voltage, current and one lane's drive around a trigger.
//!
//! A host arms a capture, waits for it to fill, and reads it part by part. The block task owns the
//! [memory] while it [records](recorder). It passes the full memory to the background task, which
//! reads it without a deadline. The tasks share only two short queues.
//!
//! ```text
//!               before            SAMPLES - before
//!        |----------------|-----------------------------|
//!   first sample       trigger: first sample of the block whose report showed it
//! ```
//!
//! Sample n of the drive is the code that played while sample n of voltage and current was taken.
//! The drive in a report plays [`LATENCY_BLOCKS`](crate::seam::block::LATENCY_BLOCKS) later; its
//! voltage, current and faults are those of its own block.

pub mod memory;
pub mod recorder;

use serde::{Deserialize, Serialize};

use crate::seam::telemetry::Telemetry;

/// Samples of a capture: 1.024 ms at 1 Msps.
pub const SAMPLES: usize = 1024;
/// Samples of a part of a capture: its codes of three channels, two bytes each, fit into a frame.
pub const PART: usize = 32;
/// Number of parts of a full capture.
pub const PARTS: u16 = (SAMPLES / PART) as u16;

/// Operation on the capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CaptureVerb {
    /// Starts to record, and discards the earlier recording.
    Arm(Arm),
    /// Requests the state of the capture.
    State,
    /// Requests the part with this number of a full capture, from zero.
    Read(u16),
    /// Ends the recording, and discards it.
    Disarm,
}

/// Settings of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Arm {
    /// Event that the capture waits for.
    pub trigger: Trigger,
    /// Number of samples before the trigger, up to [`SAMPLES`]; fewer if the trigger comes early.
    pub before: u16,
    /// Number of the lane whose drive codes are recorded.
    pub lane: u8,
}

/// Event that a capture waits for. All but the first are changes: a condition that already holds
/// when the capture is armed must end first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Trigger {
    /// No event: the capture begins at once.
    #[default]
    Now,
    /// A fault is raised.
    Fault,
    /// The drive is switched on.
    On,
    /// The tracker acquires its lock.
    Locked,
    /// The tracker loses its lock.
    Unlocked,
}

impl Trigger {
    /// Returns `true` if the condition of this trigger holds in a block with this report.
    fn holds_in(self, report: &Telemetry) -> bool {
        match self {
            Trigger::Now => true,
            Trigger::Fault => report.fault.is_some(),
            Trigger::On => report.drive.0 > 0.0 && report.envelope > 0.0,
            Trigger::Locked => report.locked,
            Trigger::Unlocked => !report.locked,
        }
    }
}

/// State of a capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum CaptureState {
    /// The capture is empty and not armed.
    #[default]
    Empty,
    /// The capture waits for its trigger.
    Armed,
    /// The trigger has occurred, and the samples after it are being recorded.
    Triggered,
    /// The capture is complete and can be read.
    Full,
}

/// Report of a capture's progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaptureReport {
    /// State of the capture.
    pub state: CaptureState,
    /// Number of samples recorded so far.
    pub samples: u16,
    /// Number of samples before the trigger.
    pub before: u16,
    /// Number of the block whose first sample is the trigger, once it has occurred.
    pub block: u32,
}

/// Part of a capture, as it is read over the link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Number of this part, from zero.
    pub part: u16,
    /// Codes of the voltage converter.
    #[serde(with = "raw")]
    pub v: [u16; PART],
    /// Codes of the current converter.
    #[serde(with = "raw")]
    pub i: [u16; PART],
    /// Drive codes of the recorded lane.
    #[serde(with = "raw")]
    pub drive: [u16; PART],
}

/// Codes as two bytes each, little-endian: as postcard's variable-length integers they would not
/// fit into a frame.
mod raw {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::PART;

    pub(super) fn serialize<S: Serializer>(codes: &[u16; PART], serializer: S) -> Result<S::Ok, S::Error> {
        codes.map(u16::to_le_bytes).serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[u16; PART], D::Error> {
        <[[u8; 2]; PART]>::deserialize(deserializer).map(|codes| codes.map(u16::from_le_bytes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::fault::Fault;
    use crate::seam::units::Volts;

    #[test]
    fn each_trigger_waits_for_its_own_event() {
        let reports = [
            (Trigger::Fault, Telemetry { fault: Some(Fault::LateBlock), ..Telemetry::default() }),
            (Trigger::On, Telemetry { drive: Volts(1.0), envelope: 0.1, ..Telemetry::default() }),
            (Trigger::Locked, Telemetry { locked: true, ..Telemetry::default() }),
        ];
        for (n, (trigger, _)) in reports.iter().enumerate() {
            for (k, (_, report)) in reports.iter().enumerate() {
                assert_eq!((trigger.holds_in(report), Trigger::Now.holds_in(report)), (n == k, true), "{trigger:?} {k}");
                assert_eq!(Trigger::Unlocked.holds_in(report), !report.locked);
            }
        }
        // A voltage without an envelope, or an envelope without a voltage, is not ON.
        assert!(!Trigger::On.holds_in(&Telemetry { drive: Volts(1.0), ..Telemetry::default() }));
        assert!(!Trigger::On.holds_in(&Telemetry { envelope: 1.0, ..Telemetry::default() }));
    }
}
