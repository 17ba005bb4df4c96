//! Captures: the raw codes of voltage, current and one lane's drive around a trigger.
//!
//! A host arms a capture, waits for it to fill, and reads it part by part. The [memory] changes hands: the block task has it while it
//! [records](recorder), and gives it to the slow side when it is full, which reads it at leisure. Nothing is shared but two short queues.
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
/// Samples of a part. Three times as many codes of two bytes fit into a frame.
pub const PART: usize = 32;
/// Parts of a capture.
pub const PARTS: u16 = (SAMPLES / PART) as u16;

/// What to do with the capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CaptureVerb {
    /// Begin to record, and forget what was recorded.
    Arm(Arm),
    /// How far is it?
    State,
    /// Give this part of a full capture, from zero.
    Read(u16),
    /// Forget what was recorded, and record no more.
    Disarm,
}

/// What to record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Arm {
    /// What ends the wait.
    pub trigger: Trigger,
    /// Samples to keep from before the trigger, up to [`SAMPLES`]; fewer where it comes early.
    pub before: u16,
    /// The lane whose drive to record.
    pub lane: u8,
}

/// What a capture waits for. All but the first are changes: what is so already when it is armed must end first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Trigger {
    /// Nothing.
    #[default]
    Now,
    /// A fault.
    Fault,
    /// The drive goes on.
    On,
    /// The tracker locks.
    Locked,
    /// The tracker is not locked any more.
    Unlocked,
}

impl Trigger {
    /// Whether what it waits for is so.
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

/// How far a capture is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum CaptureState {
    /// Nothing is recorded.
    #[default]
    Empty,
    /// It waits for its trigger.
    Armed,
    /// It has met it, and records what follows.
    Triggered,
    /// It can be read.
    Full,
}

/// How far a capture is, with what it has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaptureReport {
    /// How far it is.
    pub state: CaptureState,
    /// Samples recorded so far that belong to it.
    pub samples: u16,
    /// How many of them stand before the trigger.
    pub before: u16,
    /// The block whose first sample follows those, once it is triggered.
    pub block: u32,
}

/// A part of a capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Its number.
    pub part: u16,
    /// Voltage codes.
    #[serde(with = "raw")]
    pub v: [u16; PART],
    /// Current codes.
    #[serde(with = "raw")]
    pub i: [u16; PART],
    /// Codes of the lane's drive.
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
