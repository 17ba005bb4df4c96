//! Reasons for which the board refuses a command.

use serde::{Deserialize, Serialize};

/// Reason for which a command is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The frame was damaged: too long, badly stuffed, or with a wrong checksum.
    Damaged,
    /// The frame is of another protocol version.
    Version,
    /// The frame is intact, but the command is unknown here.
    Unknown,
    /// A value is not a number, or is negative and must not be.
    NotPlausible,
    /// Earlier orders have not been taken yet: the block stream has stopped.
    Busy,
    /// The command is allowed only while the drive is silent.
    Driving,
    /// The flash has failed.
    Flash,
    /// A value is out of range: that of a parameter, or the length of a capture.
    OutOfRange,
    /// No parameter has this key.
    NoSuchKey,
    /// The capture is not full.
    NotCaptured,
    /// The part that the command is for is not configured.
    NotConfigured,
    /// The part that the command is for is not in this image.
    LeftOut,
    /// The command would drive at the D-ring of a belt, but the length of a count of the belt's
    /// encoder is not set.
    NoBeltScale,
    /// The command would drive, but a stored limit may not act: the stored settings could not be
    /// read at start-up, or no part of this image checks that limit.
    LimitsUnsure,
    /// The settings to be stored are inconsistent. Key of the parameter that the others exclude;
    /// zero if it is not a single one.
    DoesNotBuild(u8),
    /// The frame is of an earlier session: another host has connected since, or the board was
    /// reset.
    Session,
}
