//! Records exchanged with a processor that runs the controller elsewhere.
//!
//! Host and processor take turns, so that neither ever holds more than one record:
//!
//! ```text
//! host       Config            Question            Question            (none)            (end of stream)
//! processor          Opening             Answer              Answer            Closing
//!
//! record = length: u16, little-endian | body: postcard
//! ```
//!
//! A record without a body asks for the [`Closing`]: what the run has needed of the processor. More questions may follow.
//!
//! Codes travel as raw little-endian bytes: as postcard's variable-length integers they would take more instructions than the
//! controller itself. The records' versions are those of this crate: both ends are built from the same source.

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

use crate::block::{Codes, DriveBlock, MAX_LANES, Orders, SenseBlock, SlowSense};
use crate::telemetry::Telemetry;

/// The longest record, with its length.
pub const MAX_RECORD: usize = 1024;

/// The longest reason for a refusal, in bytes.
pub const MAX_REASON: usize = 192;

/// Room for any record.
pub type Buffer = [u8; MAX_RECORD];

/// An empty buffer.
pub const BUFFER: Buffer = [0; MAX_RECORD];

const LENGTH_BYTES: usize = 2;

/// What the processor says to its configuration.
pub type Opening = Result<Silence, Reason>;

/// Why a configuration is refused, in words.
pub type Reason = String<MAX_REASON>;

/// The controller is built; this plays until it has answered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Silence {
    /// A block of silence.
    #[serde(with = "RawDrive")]
    pub drive: DriveBlock,
}

/// The arguments of [`Controller::process`](crate::controller::Controller::process).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Question {
    /// The latest orders.
    pub orders: Orders,
    /// What the converters saw.
    #[serde(with = "RawSense")]
    pub sense: SenseBlock,
}

/// Its results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The codes to play.
    #[serde(with = "RawDrive")]
    pub drive: DriveBlock,
    /// The report.
    pub telemetry: Telemetry,
    /// Instructions that the call has taken, to within a tick of the processor's timer (about 6); `None` where it cannot count them.
    pub instructions: Option<u32>,
}

/// What a run has needed of the processor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Closing {
    /// The deepest that the stack was until the controller was built, bytes from its top.
    pub stack_power_up_bytes: u32,
    /// The deepest that it was since then, bytes from its top.
    pub stack_blocks_bytes: u32,
}

/// The record that asks for the [`Closing`].
pub const CLOSE: [u8; LENGTH_BYTES] = [0; LENGTH_BYTES];

/// A record that does not fit into [`MAX_RECORD`], or is not of the expected form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadRecord;

/// Writes a record into `buffer`, and returns the bytes to send.
pub fn encode<'a, T: Serialize>(record: &T, buffer: &'a mut Buffer) -> Result<&'a [u8], BadRecord> {
    let (length, body) = buffer.split_at_mut(LENGTH_BYTES);
    let size = postcard::to_slice(record, body).map_err(|_| BadRecord)?.len();
    length.copy_from_slice(&(size as u16).to_le_bytes());
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

/// The record in what [`receive`] has returned.
pub fn decode<'a, T: Deserialize<'a>>(body: &'a [u8]) -> Result<T, BadRecord> {
    match postcard::take_from_bytes(body) {
        Ok((record, [])) => Ok(record),
        _ => Err(BadRecord),
    }
}

/// [`SenseBlock`], with raw codes.
#[derive(Serialize, Deserialize)]
#[serde(remote = "SenseBlock")]
struct RawSense {
    #[serde(with = "raw_codes")]
    v: Codes,
    #[serde(with = "raw_codes")]
    i: Codes,
    slow: SlowSense,
}

/// [`DriveBlock`], with raw codes.
#[derive(Serialize, Deserialize)]
#[serde(remote = "DriveBlock")]
struct RawDrive {
    #[serde(with = "raw_lanes")]
    lanes: Vec<Codes, MAX_LANES>,
    listen: u8,
}

/// Codes as little-endian bytes.
mod raw_codes {
    use core::fmt;

    use serde::de::{Deserializer, Error, Visitor};
    use serde::ser::Serializer;

    use crate::block::{Codes, MAX_BLOCK_SAMPLES};

    pub fn serialize<S: Serializer>(codes: &Codes, serializer: S) -> Result<S::Ok, S::Error> {
        let mut bytes = [0; 2 * MAX_BLOCK_SAMPLES];
        for (pair, code) in bytes.chunks_exact_mut(2).zip(codes) {
            pair.copy_from_slice(&code.to_le_bytes());
        }
        serializer.serialize_bytes(&bytes[..2 * codes.len()])
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Codes, D::Error> {
        deserializer.deserialize_bytes(Pairs)
    }

    struct Pairs;

    impl Visitor<'_> for Pairs {
        type Value = Codes;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("pairs of bytes")
        }

        fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Codes, E> {
            match bytes.chunks_exact(2) {
                pairs if pairs.remainder().is_empty() && pairs.len() <= MAX_BLOCK_SAMPLES => {
                    Ok(pairs.map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect())
                }
                _ => Err(E::invalid_length(bytes.len(), &self)),
            }
        }
    }
}

/// Lanes of such codes.
mod raw_lanes {
    use heapless::Vec;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use crate::block::{Codes, MAX_LANES};

    #[derive(Serialize)]
    struct Sent<'a>(#[serde(with = "super::raw_codes")] &'a Codes);

    #[derive(Deserialize)]
    struct Received(#[serde(with = "super::raw_codes")] Codes);

    pub fn serialize<S: Serializer>(lanes: &Vec<Codes, MAX_LANES>, serializer: S) -> Result<S::Ok, S::Error> {
        lanes.iter().map(Sent).collect::<Vec<_, MAX_LANES>>().serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Codes, MAX_LANES>, D::Error> {
        Ok(Vec::<Received, MAX_LANES>::deserialize(deserializer)?.into_iter().map(|lane| lane.0).collect())
    }
}

#[cfg(test)]
mod tests;
