//! Records exchanged between a host and a processor that runs the controller.
//!
//! Host and processor take turns, so that neither ever holds more than one record:
//!
//! ```text
//! the controller alone
//! host       Config            Question            Question            (none)            (end of stream)
//! processor          Opening             Answer              Answer            Closing
//!
//! a whole board program: block task and background task
//! host       Config            Beat            Beat                              Config
//! processor          Opening         Played          Played (it resets itself)           Opening
//!
//! record = length: u16, little-endian | body
//! codes  = count: u8 | codes: u16 each, little-endian
//! ```
//!
//! A body is postcard, preceded by raw codes. Encoded as postcard's variable-length integers, the
//! codes would take more instructions than the controller itself. As part of a larger value they
//! would be copied on its stack.
//!
//! A record without a body requests the [`Closing`], which reports the stack used by the run. More
//! questions may follow. Records carry no version, because both ends are built from the same
//! source.

mod wire;

use heapless::String;
use serde::{Deserialize, Serialize};

use crate::seam::block::{DriveBlock, Orders, SenseBlock};
use crate::seam::config::Config;
use crate::seam::telemetry::Telemetry;
use wire::{put, put_drive, put_sense, take, take_drive, take_sense};

/// Length of the longest record, including its length field, bytes.
pub const MAX_RECORD: usize = 1024;

/// Length of the longest reason for a refusal, bytes.
pub(crate) const MAX_REASON_BYTES: usize = 192;

/// Buffer that holds any record.
pub type Buffer = [u8; MAX_RECORD];

/// Empty [`Buffer`].
pub const BUFFER: Buffer = [0; MAX_RECORD];

const LENGTH_BYTES: usize = 2;

/// Record that requests the [`Closing`].
pub const CLOSE: [u8; LENGTH_BYTES] = [0; LENGTH_BYTES];

/// A value that can be sent as a record.
pub trait Record {
    /// Writes the record to the beginning of `room`, and returns the rest; `None` if it does not
    /// fit.
    fn put<'a>(&self, room: &'a mut [u8]) -> Option<&'a mut [u8]>;

    /// Reads the record from the beginning of `bytes`, and returns the rest; `None` if the bytes
    /// are not such a record. The value must not be used then.
    fn take<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]>;
}

/// Implements [`Record`] for types that are encoded entirely as postcard.
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
    /// `Ok` if the controller was built, otherwise the reason for the refusal.
    pub built: Result<(), Reason>,
    /// Silent block that plays until the first answer.
    pub silence: DriveBlock,
}

/// Reason for the refusal of a configuration, as text.
pub type Reason = String<MAX_REASON_BYTES>;

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
    /// Instructions executed by the call, to within a tick of the processor's timer (about 6);
    /// `None` if the processor cannot count them.
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
    /// Largest depth of the stack after the controller was built, bytes from its top.
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
    /// Number of bytes sent to the board's serial port since its start. The board receives all of
    /// them before it continues.
    pub sent: u32,
    /// `true` if the emergency stop is pressed.
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
    /// `true` if the amplifier is enabled.
    pub enable: bool,
    /// Number of times the watchdog has been fed.
    pub fed: u32,
    /// `true` if a pin or the link has failed.
    pub failed: bool,
    /// `true` if the board resets now and then waits for a configuration.
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

/// Error: a record does not fit into [`MAX_RECORD`], or is not of the expected form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadRecord;

/// Writes a record into `buffer`, and returns the bytes to send.
pub fn encode<'a>(record: &impl Record, buffer: &'a mut Buffer) -> Result<&'a [u8], BadRecord> {
    let left = record.put(&mut buffer[LENGTH_BYTES..]).ok_or(BadRecord)?.len();
    let size = MAX_RECORD - LENGTH_BYTES - left;
    buffer[..LENGTH_BYTES].copy_from_slice(&(size as u16).to_le_bytes());
    Ok(&buffer[..LENGTH_BYTES + size])
}

/// Reads one record with `read`, which returns the number of bytes written to the beginning of its
/// argument, and zero at the end of the stream. Returns `None` if the stream ends, or if the record
/// is longer than [`MAX_RECORD`].
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

/// Decodes the body returned by [`receive`] into `record`.
pub fn decode(body: &[u8], record: &mut impl Record) -> Result<(), BadRecord> {
    match record.take(body) {
        Some([]) => Ok(()),
        _ => Err(BadRecord),
    }
}

/// Decodes a configuration, the only record without a default, from the body returned by
/// [`receive`].
pub fn configuration(body: &[u8]) -> Result<Config, BadRecord> {
    match postcard::take_from_bytes(body) {
        Ok((config, [])) => Ok(config),
        _ => Err(BadRecord),
    }
}

#[cfg(test)]
mod tests;
