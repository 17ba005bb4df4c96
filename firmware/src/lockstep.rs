//! Records exchanged with a processor that runs the controller elsewhere.
//!
//! Host and processor take turns, so that neither ever holds more than one record:
//!
//! ```text
//! host       Config            Question            Question            (end of stream)
//! processor          Opening             Answer              Answer
//!
//! record = length: u16, little-endian | body: postcard
//! ```
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
mod tests {
    use super::*;
    use crate::block::{Amplitude, Gate, MAX_BLOCK_SAMPLES, Request, Trips};
    use crate::config::*;
    use crate::identify::Transducer;
    use crate::supervisor::{Fault, Limit, Mode};
    use crate::units::{Hertz, Turns};

    /// Sends `record` in pieces of `piece` bytes, and checks that it comes back.
    fn comes_back<T>(record: &T, piece: usize)
    where
        T: Serialize + for<'a> Deserialize<'a> + PartialEq + core::fmt::Debug,
    {
        let mut sent = BUFFER;
        let mut rest = encode(record, &mut sent).expect("it fits");
        let mut received = BUFFER;
        let read = |bytes: &mut [u8]| {
            let (now, later) = rest.split_at(piece.min(rest.len()));
            bytes[..now.len()].copy_from_slice(now);
            rest = later;
            Ok::<_, ()>(now.len())
        };
        let body = receive(&mut received, read).unwrap().expect("a whole record");
        assert_eq!(decode::<T>(body).as_ref(), Ok(record));
    }

    fn codes() -> Codes {
        (0..MAX_BLOCK_SAMPLES as u16).map(|n| 0xffff - n).collect()
    }

    fn longest_question() -> Question {
        let orders = Orders {
            sequence: u32::MAX,
            request: Request::Run,
            attempt: u32::MAX,
            gate: Gate::Off,
            amplitude: Some(Amplitude::MotionalCurrent(1.0)),
            detune: Hertz(1.0),
            quadrature: Some(Turns(0.1)),
            emergency_stop: true,
            clear_fault: true,
        };
        let slow = SlowSense {
            belt: Some(1.0),
            temperature: Some(1.0),
            force: Some(1.0),
            trips: Some(Trips { over_current: true }),
            missed_blocks: Some(u32::MAX),
        };
        Question { orders, sense: SenseBlock { v: codes(), i: codes(), slow } }
    }

    fn longest_answer() -> Answer {
        let telemetry = Telemetry {
            block: u32::MAX,
            orders_sequence: u32::MAX,
            mode: Mode::Fault,
            fault: Some(Fault::BeltStopped),
            limit: Some(Limit::FrequencyWindow),
            tuning_word: u64::MAX,
            transducer: Some(Transducer::default()),
            ..Telemetry::default()
        };
        let drive = DriveBlock { lanes: core::iter::repeat_n(codes(), MAX_LANES).collect(), listen: 3 };
        Answer { drive, telemetry, instructions: Some(u32::MAX) }
    }

    fn longest_config() -> Config {
        let most = |x: f32| core::iter::repeat_n(x, MAX_LANES).collect();
        Config {
            sample_hz: 1e6,
            block_samples: u16::MAX,
            lanes: 4,
            front_end: FrontEnd {
                volt_per_lsb: 1.0,
                ampere_per_lsb: 1.0,
                sense_mid_code: u16::MAX,
                sense_max_code: u16::MAX,
                drive_volt_per_lsb: 1.0,
                drive_mid_code: u16::MAX,
                drive_max_code: u16::MAX,
                drive_lanes: u8::MAX,
            },
            drive: Drive {
                frequency_hz: 40e3,
                amplitude: Amplitude::Volts(1.0),
                scan_volts: 1.0,
                shape: ShapeKind::Noise,
                noise_band_hz: (1.0, 2.0),
                dither: true,
                seed: u64::MAX,
            },
            sweep: Sweep::Chirp(Chirp {
                kind: ChirpKind::Exponential,
                start_hz: 1.0,
                stop_hz: 2.0,
                time_s: 1.0,
                then: Then::UpDown,
                around: Around::Resonance,
            }),
            phasing: Phasing {
                direction: Direction::Reverse,
                phase_trim_turns: most(0.0),
                gain_trim: most(1.0),
                calibration: core::iter::repeat_n(TrimPoint::default(), MAX_TRIM_POINTS).collect(),
            },
            burst: Burst {
                schedule: Schedule::Windows(core::iter::repeat_n((0.0, 1.0), MAX_WINDOWS).collect()),
                edge: Edge::Soft { cycles: 1.0 },
            },
            tracking: Tracking { mode: TrackingMode::Off, span: 1.0, bandwidth_hz: 1.0, nominal_q: 1.0, nominal_c0_f: 1.0 },
            limits: Limits { voltage_v: 1.0, current_a: 1.0, belt_moving_m_per_s: 1.0, belt_stop_ms: 1.0 },
        }
    }

    #[test]
    fn the_longest_records_come_back_whole_or_in_pieces() {
        for piece in [1, 7, MAX_RECORD] {
            comes_back(&longest_config(), piece);
            comes_back(&longest_question(), piece);
            comes_back(&longest_answer(), piece);
            comes_back(&Opening::Ok(Silence { drive: longest_answer().drive }), piece);
            comes_back(&Opening::Err("x".repeat(MAX_REASON).as_str().try_into().unwrap()), piece);
        }
    }

    #[test]
    fn an_end_inside_a_record_is_an_end() {
        let mut pieces = [3usize, 0].into_iter();
        let read = |bytes: &mut [u8]| {
            bytes[..3].copy_from_slice(&[9, 0, 1]);
            pieces.next().ok_or(())
        };
        assert_eq!(receive(&mut BUFFER.clone(), read), Ok(None));
    }

    #[test]
    fn codes_that_are_no_pairs_or_too_many_are_refused() {
        #[derive(Serialize)]
        struct Bytes<'a>(&'a [u8]);
        #[derive(Debug, PartialEq, Deserialize)]
        struct Read(#[serde(with = "raw_codes")] Codes);
        let mut buffer = BUFFER;
        for (length, fits) in [(128, true), (127, false), (130, false)] {
            let bytes = encode(&Bytes(&BUFFER[..length]), &mut buffer).unwrap();
            assert_eq!(decode::<Read>(&bytes[LENGTH_BYTES..]).is_ok(), fits, "{length} bytes");
        }
    }
}
