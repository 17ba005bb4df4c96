//! Records exchanged between a host and a processor that runs the controller.
//!
//! Host and processor take turns, so that neither ever holds more than one record:
//!
//! ```text
//! the controller alone
//! host       Config            Question            Question            (none)            (end of stream)
//! processor          Opening             Answer              Answer            Closing
//!
//! all of a board's program, with the block task and the background task
//! host       Config            Beat            Beat                              Config
//! processor          Opening         Played          Played (it resets itself)           Opening
//!
//! record = length: u16, little-endian | body
//! codes  = count: u8 | codes: u16 each, little-endian
//! ```
//!
//! A body is postcard, but for the codes, which stand before it as they are: as postcard's variable-length integers they would take more
//! instructions than the controller itself, and as part of a larger value they would be copied on its stack. A record without a body asks
//! for the [`Closing`]: the stack that the run has used. More questions may follow. The records' versions are those of this crate:
//! both ends are built from the same source.

mod wire;

use heapless::String;
use serde::{Deserialize, Serialize};

use crate::seam::block::{DriveBlock, Orders, SenseBlock};
use crate::seam::config::Config;
use crate::seam::telemetry::Telemetry;
use wire::{put, put_drive, put_sense, take, take_drive, take_sense};

/// The longest record, with its length.
pub const MAX_RECORD: usize = 1024;

/// The longest reason for a refusal, in bytes.
pub(crate) const MAX_REASON: usize = 192;

/// Room for any record.
pub type Buffer = [u8; MAX_RECORD];

/// An empty buffer for any record.
pub const BUFFER: Buffer = [0; MAX_RECORD];

const LENGTH_BYTES: usize = 2;

/// The record that asks for the [`Closing`].
pub const CLOSE: [u8; LENGTH_BYTES] = [0; LENGTH_BYTES];

/// A value that can be sent as a record.
pub trait Record {
    /// Writes the record to the beginning of `room`, and returns the rest; `None` if it does not fit.
    fn put<'a>(&self, room: &'a mut [u8]) -> Option<&'a mut [u8]>;

    /// Reads the record from the beginning of `bytes`, and returns the rest; `None` if the bytes are no such record, which must not be used then.
    fn take<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]>;
}

/// Records that are postcard as a whole.
macro_rules! plain {
    ($($record:ty),+) => {
        $(impl Record for $record {
            fn put<'a>(&self, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
                put(self, room)
            }

            fn take<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]> {
                take(self, bytes)
            }
        })+
    };
}

plain!(Config, Closing);

/// Answer of the processor to its configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Whether the controller was built, or why not.
    pub built: Result<(), Reason>,
    /// A block of silence, which plays until the first answer.
    pub silence: DriveBlock,
}

/// The reason for which a configuration is refused, in words.
pub type Reason = String<MAX_REASON>;

impl Default for Opening {
    fn default() -> Self {
        Opening { built: Ok(()), silence: DriveBlock::default() }
    }
}

impl Record for Opening {
    fn put<'a>(&self, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
        put(&self.built, put_drive(&self.silence, room)?)
    }

    fn take<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        take(&mut self.built, take_drive(&mut self.silence, bytes)?)
    }
}

/// The arguments of [`Controller::process`](crate::controller::Controller::process).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Question {
    /// The latest orders of the host.
    pub orders: Orders,
    /// Codes that the converters sampled.
    pub sense: SenseBlock,
}

impl Record for Question {
    fn put<'a>(&self, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
        put(&self.orders, put_sense(&self.sense, room)?)
    }

    fn take<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        take(&mut self.orders, take_sense(&mut self.sense, bytes)?)
    }
}

/// The results of [`Controller::process`](crate::controller::Controller::process).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Answer {
    /// The codes to play.
    pub drive: DriveBlock,
    /// The report of the block.
    pub telemetry: Telemetry,
    /// Instructions that the call has taken, to within a tick of the processor's timer (about 6); `None` where it cannot count them.
    pub instructions: Option<u32>,
}

impl Record for Answer {
    fn put<'a>(&self, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
        put(&self.instructions, put(&self.telemetry, put_drive(&self.drive, room)?)?)
    }

    fn take<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        take(&mut self.instructions, take(&mut self.telemetry, take_drive(&mut self.drive, bytes)?)?)
    }
}

/// Use of the processor's stack in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Closing {
    /// Largest depth of the stack until the controller was built, bytes from its top.
    pub stack_power_up_bytes: u32,
    /// Largest depth of the stack since then, bytes from its top.
    pub stack_blocks_bytes: u32,
}

/// Inputs of a whole board in one block.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Beat {
    /// Codes that the converters sampled.
    pub sense: SenseBlock,
    /// The other inputs of the board.
    pub pins: Pins,
}

/// Inputs of a board in one block, other than those of its converters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pins {
    /// Bytes that were sent to the board's serial port since it was started. The board receives all of them before it goes on.
    pub sent: u32,
    /// Whether the emergency stop is pressed.
    pub stop: bool,
}

impl Record for Beat {
    fn put<'a>(&self, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
        put(&self.pins, put_sense(&self.sense, room)?)
    }

    fn take<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        take(&mut self.pins, take_sense(&mut self.sense, bytes)?)
    }
}

/// Outputs of a whole board in one block.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Played {
    /// The codes to play.
    pub drive: DriveBlock,
    /// The other outputs of the board.
    pub board: Board,
}

/// Outputs of a board after a block, other than those of its converters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Board {
    /// Whether the amplifier is enabled.
    pub enable: bool,
    /// Number of times the watchdog was fed so far.
    pub fed: u32,
    /// Whether a pin or the link has failed.
    pub failed: bool,
    /// Whether the board resets itself now, and then waits for a configuration.
    pub resets: bool,
}

impl Record for Played {
    fn put<'a>(&self, room: &'a mut [u8]) -> Option<&'a mut [u8]> {
        put(&self.board, put_drive(&self.drive, room)?)
    }

    fn take<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        take(&mut self.board, take_drive(&mut self.drive, bytes)?)
    }
}

/// A record that does not fit into [`MAX_RECORD`], or is not of the expected form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadRecord;

/// Writes a record into `buffer`, and returns the bytes to send.
pub fn encode<'a>(record: &impl Record, buffer: &'a mut Buffer) -> Result<&'a [u8], BadRecord> {
    let left = record.put(&mut buffer[LENGTH_BYTES..]).ok_or(BadRecord)?.len();
    let size = MAX_RECORD - LENGTH_BYTES - left;
    buffer[..LENGTH_BYTES].copy_from_slice(&(size as u16).to_le_bytes());
    Ok(&buffer[..LENGTH_BYTES + size])
}

/// Reads one record by calls of `read`, which returns how many bytes it has put at the beginning of its argument, and zero at the
/// end of the stream. `None`: the stream has ended, or what comes is longer than any record.
pub fn receive<E>(buffer: &mut Buffer, mut read: impl FnMut(&mut [u8]) -> Result<usize, E>) -> Result<Option<&[u8]>, E> {
    let mut filled = 0;
    loop {
        if let [low, high, body @ ..] = &buffer[..filled]
            && body.len() >= usize::from(u16::from_le_bytes([*low, *high]))
        {
            return Ok(Some(&buffer[LENGTH_BYTES..filled]));
        }
        match read(&mut buffer[filled..])? {
            0 => return Ok(None),
            count => filled += count,
        }
    }
}

/// Reads the body that [`receive`] has returned into `record`.
pub fn decode(body: &[u8], record: &mut impl Record) -> Result<(), BadRecord> {
    match record.take(body) {
        Some([]) => Ok(()),
        _ => Err(BadRecord),
    }
}

/// Reads the configuration in the body that [`receive`] has returned: the one record that has no default.
pub fn configuration(body: &[u8]) -> Result<Config, BadRecord> {
    match postcard::take_from_bytes(body) {
        Ok((config, [])) => Ok(config),
        _ => Err(BadRecord),
    }
}

#[cfg(test)]
mod tests;
