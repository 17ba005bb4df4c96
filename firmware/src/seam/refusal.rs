//! Why the board does not do what it is asked.

use serde::{Deserialize, Serialize};

/// Why a command is not obeyed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The frame was damaged: too long, badly stuffed, or with a wrong checksum.
    Damaged,
    /// The frame is of another protocol version.
    Version,
    /// The frame is whole, but not a command that is known here.
    Unknown,
    /// A number in it is not a number, or negative where it must not be.
    NotPlausible,
    /// Earlier orders have not been taken yet: the block stream stands still.
    Busy,
    /// Only while the drive is silent.
    Driving,
    /// The flash does not do it.
    Flash,
    /// A number in it is beyond its range: of a parameter, or of what a capture has.
    OutOfRange,
    /// No parameter has this key.
    NoSuchKey,
    /// The capture is not full.
    NotCaptured,
    /// Nothing here is configured that it could be for.
    NotConfigured,
    /// It is for a part of the controller that this image leaves out.
    LeftOut,
    /// It would drive at the D-ring of a belt, and the length of a count of the belt's encoder is not set.
    NoBeltScale,
    /// It would drive, and a limit that was stored may not act: the stored settings could not be read when the board started, or nothing here judges it.
    LimitsUnsure,
    /// The settings that are to be stored do not fit together. The key of the parameter that is out of what the others leave it; zero where it is none
    /// alone.
    DoesNotBuild(u8),
    /// The frame is of another session than the present one: another host has connected since, or the board was reset.
    Session,
}
