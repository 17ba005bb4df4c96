//! Captures: the raw codes of voltage, current and one lane's drive around a trigger.
//!
//! A host arms a capture, waits for it to fill, and reads it part by part. The [memory] changes hands: the block task has it while it
//! [records](recorder), and hands it to the background task when it is full, which reads it without a deadline. Nothing is shared but two short queues.
//!
//! ```text
//!               before            SAMPLES - before
//!        |----------------|-----------------------------|
//!   first sample       trigger: first sample of the block whose report showed it
//! ```
//!
//! Sample n of the drive is the code that played while sample n of voltage and current was taken. What a report says of the drive plays
//! [`LATENCY_BLOCKS`](crate::seam::block::LATENCY_BLOCKS) later; what it says of voltage, current and faults was seen in its own block.

pub mod memory;
pub mod recorder;

use serde::{Deserialize, Serialize};

use crate::seam::telemetry::Telemetry;

/// Samples of a capture: 1.024 ms at 1 Msps.
pub const SAMPLES: usize = 1024;
/// Samples of a part of a capture. Three times as many codes of two bytes fit into a frame.
pub const PART: usize = 32;
/// Number of parts of a full capture.
pub const PARTS: u16 = (SAMPLES / PART) as u16;

/// Operation on the capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CaptureVerb {
    /// Starts to record, and discards what was recorded.
    Arm(Arm),
    /// Asks for the state of the capture.
    State,
    /// Asks for the part with this number of a full capture, from zero.
    Read(u16),
    /// Discards what was recorded, and ends the recording.
    Disarm,
}

/// Settings of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Arm {
    /// The event that the capture waits for.
    pub trigger: Trigger,
    /// Samples of the capture that precede the trigger, up to [`SAMPLES`]; fewer where the trigger comes early.
    pub before: u16,
    /// Number of the lane whose drive codes are recorded.
    pub lane: u8,
}

/// Event that a capture waits for. All but the first are changes: a condition that holds already when the capture is armed must end first.
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
    /// Whether the condition of this trigger holds in a block with this report.
    fn is_so(self, report: &Telemetry) -> bool {
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
    /// The trigger has come, and the samples after it are being recorded.
    Triggered,
    /// The capture is complete and can be read.
    Full,
}

/// Report of a capture's progress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaptureReport {
    /// State of the capture.
    pub state: CaptureState,
    /// Samples of the capture that are recorded so far.
    pub samples: u16,
    /// Samples of the capture that precede the trigger.
    pub before: u16,
    /// Number of the block whose first sample is the trigger, once it has come.
    pub block: u32,
}

/// A part of a capture, as it is read over the link.
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

/// Codes as two bytes each, little-endian: as postcard's variable-length integers they would not fit into a frame.
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
    fn each_trigger_waits_for_its_own() {
        let reports = [
            (Trigger::Fault, Telemetry { fault: Some(Fault::LateBlock), ..Telemetry::default() }),
            (Trigger::On, Telemetry { drive: Volts(1.0), envelope: 0.1, ..Telemetry::default() }),
            (Trigger::Locked, Telemetry { locked: true, ..Telemetry::default() }),
        ];
        for (n, (trigger, _)) in reports.iter().enumerate() {
            for (k, (_, report)) in reports.iter().enumerate() {
                assert_eq!((trigger.is_so(report), Trigger::Now.is_so(report)), (n == k, true), "{trigger:?} {k}");
                assert_eq!(Trigger::Unlocked.is_so(report), !report.locked);
            }
        }
        // A voltage without an envelope, or an envelope without a voltage, is not ON.
        assert!(!Trigger::On.is_so(&Telemetry { drive: Volts(1.0), ..Telemetry::default() }));
        assert!(!Trigger::On.is_so(&Telemetry { envelope: 1.0, ..Telemetry::default() }));
    }
}
