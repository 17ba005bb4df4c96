//! Frames of the link: postcard with a CRC-32, encoded by COBS, with a zero between frames.
//!
//! ```text
//! COBS( version: u8 | sequence: varint u16 | session: u32, 4 bytes, little-endian | body: postcard | crc-32/iscsi: 4 bytes, little-endian ) 00
//! ```
//!
//! A zero never occurs inside a frame. Therefore a receiver that joins late, or after a damaged
//! frame, is synchronized again at the next zero.

use crc::{CRC_32_ISCSI, Crc, NoTable};
use serde::{Deserialize, Serialize};

/// Version of the protocol. Frames of other versions are refused.
pub const VERSION: u8 = 3;

/// Session number that means "no session": in a request for a session, and in answers to unreadable
/// frames.
pub const NO_SESSION: u32 = 0;

/// Length of the longest frame after COBS encoding, with its zero, bytes.
pub const MAX_FRAME: usize = 256;

/// Length of the longest frame before COBS encoding, bytes: COBS adds one byte in 254, and the zero
/// is not part of it.
const MAX_PLAIN: usize = MAX_FRAME - 3;

// Computed bit by bit: a frame has about 60 bytes, and a table would take a kilobyte.
static CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// Decoded frame of the link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame<T> {
    /// Version of the protocol.
    pub version: u8,
    /// Sequence number of this frame; a reply has that of its command.
    pub sequence: u16,
    /// Number of the session of this frame; the board obeys only frames of the present one. A reply
    /// has the session of its command, so that no host takes the answer to another host for its
    /// own. The answer to [`Identify`](crate::board::command::Command::Identify) has the number
    /// drawn by the host, and telemetry has the present session.
    #[serde(with = "postcard::fixint::le")]
    pub session: u32,
    /// Content of the frame.
    pub body: T,
}

/// Defect of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// The frame is longer than [`MAX_FRAME`].
    TooLong,
    /// The COBS encoding or the checksum is wrong.
    Damaged,
    /// An intact frame of another protocol version, with its sequence number.
    Version(u16),
    /// An intact frame with an unknown body, with its sequence number and its session.
    Unknown(u16, u32),
}

/// Encoded frame, ready to be sent.
pub(crate) type Encoded = heapless::Vec<u8, MAX_FRAME>;

/// Encodes one frame. Fails only if the body does not fit into [`MAX_FRAME`].
pub fn encode<T: Serialize>(sequence: u16, session: u32, body: T) -> Result<Encoded, FrameError> {
    let mut plain = [0; MAX_PLAIN];
    let frame = Frame { version: VERSION, sequence, session, body };
    let plain = checked(&frame, &mut plain).ok_or(FrameError::TooLong)?;
    let mut stuffed = Encoded::new();
    stuffed.resize(cobs::max_encoding_length(plain.len()), 0).map_err(|_| FrameError::TooLong)?;
    let length = cobs::encode(plain, &mut stuffed);
    stuffed.truncate(length);
    stuffed.push(0).map_err(|_| FrameError::TooLong)?;
    Ok(stuffed)
}

/// Serializes a frame and appends its checksum, before COBS encoding.
fn checked<'a, T: Serialize>(frame: &Frame<T>, plain: &'a mut [u8]) -> Option<&'a [u8]> {
    let length = postcard::to_slice(frame, plain).ok()?.len();
    let checksum = CRC.checksum(&plain[..length]).to_le_bytes();
    let end = length + checksum.len();
    plain.get_mut(length..end)?.copy_from_slice(&checksum);
    Some(&plain[..end])
}

/// Assembler of frames from single bytes.
#[derive(Clone, Debug, Default)]
pub struct Receiver {
    bytes: heapless::Vec<u8, MAX_FRAME>,
    too_long: bool,
}

impl Receiver {
    /// Takes one byte. Returns a frame, or its defect, at the closing zero. Skips empty frames.
    pub fn take<T: for<'a> Deserialize<'a>>(&mut self, byte: u8) -> Option<Result<Frame<T>, FrameError>> {
        if byte != 0 {
            self.too_long |= self.bytes.push(byte).is_err();
            return None;
        }
        let (empty, too_long) = (self.bytes.is_empty(), core::mem::take(&mut self.too_long));
        let frame = if too_long { Err(FrameError::TooLong) } else { decode(&mut self.bytes) };
        self.bytes.clear();
        (!empty).then_some(frame)
    }
}

fn decode<T: for<'a> Deserialize<'a>>(stuffed: &mut [u8]) -> Result<Frame<T>, FrameError> {
    let length = cobs::decode_in_place(stuffed).map_err(|_| FrameError::Damaged)?;
    // The checksum first, because it is the same in every version; then the version; then the body.
    let (plain, checksum) = stuffed[..length].split_last_chunk().ok_or(FrameError::Damaged)?;
    if CRC.checksum(plain) != u32::from_le_bytes(*checksum) {
        return Err(FrameError::Damaged);
    }
    let ((version, sequence), body): ((u8, u16), &[u8]) = postcard::take_from_bytes(plain).map_err(|_| FrameError::Damaged)?;
    if version != VERSION {
        return Err(FrameError::Version(sequence));
    }
    let (session, body) = body.split_first_chunk().ok_or(FrameError::Unknown(sequence, NO_SESSION))?;
    let session = u32::from_le_bytes(*session);
    match postcard::take_from_bytes(body) {
        Ok((body, [])) => Ok(Frame { version, sequence, session, body }),
        _ => Err(FrameError::Unknown(sequence, session)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::capture::{Arm, CaptureReport, CaptureState, CaptureVerb, Part, Trigger};
    use crate::board::command::{Command, Reply, ResonanceReport, TrimReport, Verb};
    use crate::board::fault_log::{FaultEntry, FaultReport};
    use crate::board::parameters::ParameterReport;
    use crate::board::start::{FileName, NAME, Place, Start};
    use crate::board::stored_state::StoredState;
    use crate::seam::block::{Amplitude, Gate};
    use crate::seam::fault::{Fault, Limit};
    use crate::seam::mode::Mode;
    use crate::seam::phasor::Phasor;
    use crate::seam::refusal::Refusal;
    use crate::seam::telemetry::Telemetry;
    use crate::seam::units::{Hertz, Volts};

    fn receive<T: for<'a> Deserialize<'a>>(bytes: &[u8]) -> std::vec::Vec<Result<Frame<T>, FrameError>> {
        let mut receiver = Receiver::default();
        bytes.iter().filter_map(|&byte| receiver.take(byte)).collect()
    }

    #[test]
    fn commands_round_trip() {
        for (n, command) in
            [Command::Run, Command::Gate(Gate::Off), Command::Amplitude(Some(Amplitude::Volts(3.0)))].into_iter().enumerate()
        {
            let sequence = 300 + n as u16;
            for session in [NO_SESSION, 1, 0x0100_0001, u32::MAX] {
                let frames = receive(&encode(sequence, session, command).unwrap());
                assert_eq!(frames, [Ok(Frame { version: VERSION, sequence, session, body: command })]);
            }
        }
    }

    /// Returns the length of a reply's frame with the longest sequence number, bytes.
    fn bytes_of(reply: Reply) -> usize {
        let frame = encode(u16::MAX, u32::MAX, reply).unwrap();
        let received = receive::<Reply>(&frame);
        assert_eq!(received, [Ok(Frame { version: VERSION, sequence: u16::MAX, session: u32::MAX, body: reply })]);
        frame.len()
    }

    #[test]
    fn every_report_fits_into_a_frame_with_room_to_grow() {
        let full = Telemetry {
            block: u32::MAX,
            orders_sequence: u32::MAX,
            fault: Some(Fault::HostLost),
            limit: Some(Limit::Derated),
            tuning_word: u64::MAX,
            transducer: Some(Default::default()),
            listed: Some(Default::default()),
            friction: Some(crate::seam::telemetry::FrictionEstimate { force_ratio: Some(1.0), ..Default::default() }),
            ..Default::default()
        };
        let found = [Some(Default::default()); 4];
        let parameter = ParameterReport {
            key: 255,
            acts: 1.0,
            next: 2.0,
            built_in: 3.0,
            min: 4.0,
            max: 5.0,
            stored: StoredState::Version(255),
        };
        let place = Place { file: FileName::of(&"x".repeat(NAME)), line: u32::MAX };
        let entry = FaultEntry {
            block: u32::MAX,
            fault: Fault::HostLost,
            mode: Mode::Clamped,
            locked: true,
            frequency: Hertz(4e4),
            drive: Volts(3.0),
            envelope: 1.0,
            v: Phasor::new(1.0, 2.0),
            i: Phasor::new(3.0, 4.0),
            motional_current: Phasor::new(5.0, 6.0),
        };
        let part = Part { part: u16::MAX, v: [u16::MAX; 32], i: [0; 32], drive: core::array::from_fn(|n| n as u16) };
        let capture = CaptureReport { state: CaptureState::Full, samples: u16::MAX, before: u16::MAX, block: u32::MAX };
        // The longest replies, and their lengths in bytes.
        let rows = [
            (Reply::Telemetry(full), 206),
            (Reply::Status(Some(full)), 207),
            (Reply::Resonances(ResonanceReport { chosen: Some(3), found }), 85),
            (Reply::Settings(TrimReport { stored: StoredState::Version(255), points: 5, point: Some(Default::default()) }), 55),
            (Reply::Parameter(parameter), 38),
            (Reply::Capture(capture), 27),
            (Reply::Captured(part), 210),
            (Reply::Faults(FaultReport { count: u16::MAX, entry: Some(entry), last_run: Start::Panic(place) }), 110),
            (Reply::Nak(Refusal::NotCaptured), 16),
        ];
        let taken = rows.map(|(reply, _)| bytes_of(reply));
        assert_eq!(taken, rows.map(|(_, bytes)| bytes));
        assert!(taken.iter().all(|&bytes| bytes <= MAX_FRAME - 40), "{taken:?}");
    }

    #[test]
    fn the_longest_commands_are_short() {
        let arm = Arm { trigger: Trigger::Unlocked, before: u16::MAX, lane: 255 };
        for command in [Command::Capture(CaptureVerb::Arm(arm)), Command::Settings(Verb::Set(255, 1.0)), Command::Patience(1.0)] {
            assert!(encode(u16::MAX, u32::MAX, command).unwrap().len() <= 24, "{command:?}");
        }
    }

    #[test]
    fn every_flipped_bit_is_detected_and_the_next_frame_is_intact() {
        let good = encode(7, u32::MAX, Command::Amplitude(Some(Amplitude::Volts(3.0)))).unwrap();
        for bit in 0..8 * (good.len() - 1) {
            let mut bytes = good.to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes.extend_from_slice(&good);
            let frames = receive::<Command>(&bytes);
            let damaged = |frame: &Result<_, _>| matches!(frame, Err(FrameError::Damaged));
            assert!(frames[..frames.len() - 1].iter().all(damaged), "bit {bit}: {frames:?}");
            assert!(frames.last().is_some_and(Result::is_ok));
        }
    }

    #[test]
    fn another_version_is_reported() {
        let mut plain = [0; 64];
        let frame = Frame { version: VERSION + 1, sequence: 9, session: 5, body: 0xFFu8 };
        let plain = checked(&frame, &mut plain).unwrap();
        let mut stuffed = [0; 64];
        let length = cobs::encode(plain, &mut stuffed);
        stuffed[length] = 0;
        assert_eq!(receive::<Command>(&stuffed[..=length]), [Err(FrameError::Version(9))]);
    }

    #[test]
    fn an_unknown_body_keeps_its_session_number() {
        let receive_plain = |plain: &[u8]| {
            let mut whole = plain.to_vec();
            whole.extend(CRC.checksum(plain).to_le_bytes());
            let mut stuffed = [0; 64];
            let length = cobs::encode(&whole, &mut stuffed);
            receive::<Command>(&stuffed[..=length])
        };
        assert_eq!(receive_plain(&[VERSION, 9, 4, 3, 2, 1, 99]), [Err(FrameError::Unknown(9, 0x0102_0304))]);
        for missing in [&[VERSION, 9][..], &[VERSION, 9, 4, 3, 2]] {
            assert_eq!(receive_plain(missing), [Err(FrameError::Unknown(9, NO_SESSION))]);
        }
    }

    #[test]
    fn input_without_a_zero_is_bounded() {
        let mut bytes = std::vec![0x55; 10 * MAX_FRAME];
        bytes.push(0);
        assert_eq!(receive::<Command>(&bytes), [Err(FrameError::TooLong)]);
    }
}
