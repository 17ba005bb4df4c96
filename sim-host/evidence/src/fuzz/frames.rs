//! Traffic for the board: valid frames of a host, and the damage they may suffer on the link.

use std::collections::HashSet;

use firmware::board::capture::{Arm, CaptureVerb, Trigger};
use firmware::board::command::{Command, Verb};
use firmware::board::link::{MAX_FRAME, NO_SESSION, VERSION, encode};
use firmware::board::parameters::PARAMETERS;
use firmware::board::update::UpdateVerb;
use firmware::seam::block::{Amplitude, Gate, Target};
use firmware::seam::units::{Hertz, Turns};
use hal_mock::bench::Setup;
use hal_mock::chance::Chance;

/// Largest number of frames before a block in busy traffic.
const BUSY_FRAMES: u64 = 40;
/// Number of consecutive pieces of traffic that are equally busy.
const PHASE_PIECES: u64 = 60;
/// Size of a frame's header, bytes: version, a sequence number up to 127, and the session.
const HEADER: usize = 6;
/// A frame without content, which the board refuses as damaged.
pub(super) const EMPTY_FRAME: [u8; 2] = [1, 0];
/// Longest run of bytes without a frame.
const FLOOD_BYTES: u64 = 4000;

/// Bytes on the link before each block, and the valid frames in them.
#[derive(Default)]
pub(super) struct Traffic {
    pub(super) sent: Vec<Vec<u8>>,
    pub(super) valid: HashSet<Vec<u8>>,
    /// Session of the valid frames.
    session: u32,
}

impl Traffic {
    /// Generates at least `bytes` bytes for a board in this session.
    pub(super) fn new(chance: &mut Chance, bytes: usize, session: u32) -> Self {
        let (mut traffic, mut sequence, mut count) = (Traffic { session, ..Traffic::default() }, chance.below(1 << 16) as u16, 0);
        let mut frames = 1;
        while count < bytes {
            if (traffic.sent.len() as u64).is_multiple_of(PHASE_PIECES) {
                frames = if chance.strikes(0.5) { 1 } else { BUSY_FRAMES };
            }
            let mut piece = Vec::new();
            for _ in 0..=chance.below(frames) {
                traffic.frame(chance, &mut sequence, &mut piece);
            }
            count += piece.len();
            traffic.sent.push(piece);
        }
        traffic
    }

    /// Adds a frame, valid or damaged.
    fn frame(&mut self, chance: &mut Chance, sequence: &mut u16, piece: &mut Vec<u8>) {
        let mut next = |chance: &mut Chance| {
            *sequence = sequence.wrapping_add(1);
            let frame = encode(*sequence, self.session, session_command(chance)).unwrap_or_default().to_vec();
            self.valid.insert(frame.clone());
            frame
        };
        let one = next(chance);
        piece.extend(match chance.below(15) {
            0..4 => one,
            // Twice, or after its successor.
            4 => [&one[..], &one].concat(),
            5 => [next(chance), one].concat(),
            6 => with_bits_flipped(chance, one),
            // Cut short, so that the next frame runs into it.
            7 => one[..chance.below(one.len() as u64) as usize].to_vec(),
            8 => longer_or_shorter(chance, one),
            // The beginning of one frame with the end of another.
            9 => {
                let other = next(chance);
                let (head, tail) = (chance.below(one.len() as u64), chance.below(other.len() as u64));
                [&one[..head as usize], &other[tail as usize..]].concat()
            }
            // Intact with a valid checksum, but of another version or without meaning.
            10 => meaningless(chance, self.session),
            // Intact, but with more bytes after its body.
            11 => {
                let more: Vec<u8> = (0..=chance.below(4)).map(|_| chance.byte()).collect();
                framed(VERSION, chance.byte() & 0x7F, self.session, &[&body(chance)[..], &more].concat())
            }
            // As long as a frame can be, or a little longer.
            12 => {
                let length = MAX_FRAME as u64 - 8 + chance.below(12);
                (0..length).map(|_| chance.byte().max(1)).chain([0]).collect()
            }
            // Intact, but of another session or without one.
            13 => {
                let session =
                    [self.session ^ (1 << chance.below(32)), chance.below(1 << 32) as u32, NO_SESSION][chance.below(3) as usize];
                encode(*sequence, session, session_command(chance)).unwrap_or_default().to_vec()
            }
            _ => {
                let most = if chance.strikes(0.05) { FLOOD_BYTES } else { 100 };
                (0..chance.below(most)).map(|_| chance.byte()).collect()
            }
        });
    }

    /// Returns a part of the traffic with each invalid frame replaced. The bytes between two zeros
    /// are one frame.
    pub(super) fn purged(&self, sent: &[Vec<u8>], instead: &[u8]) -> Vec<Vec<u8>> {
        let mut pending = vec![];
        let purge = |bytes: &Vec<u8>| {
            let mut purged = vec![];
            for &byte in bytes {
                pending.push(byte);
                if byte == 0 {
                    // An empty frame has no answer.
                    let stands = if self.valid.contains(&pending) { &pending } else { instead };
                    purged.extend_from_slice(if pending.len() > 1 { stands } else { &[] });
                    pending.clear();
                }
            }
            purged
        };
        sent.iter().map(purge).collect()
    }
}

/// Flips some bits, possibly those of the closing zero.
fn with_bits_flipped(chance: &mut Chance, mut bytes: Vec<u8>) -> Vec<u8> {
    for _ in 0..=chance.below(6) {
        let at = chance.below(bytes.len() as u64) as usize;
        bytes[at] ^= 1 << chance.below(8);
    }
    bytes
}

/// Inserts or removes a byte.
fn longer_or_shorter(chance: &mut Chance, mut bytes: Vec<u8>) -> Vec<u8> {
    let at = chance.below(bytes.len() as u64) as usize;
    let more = if chance.strikes(0.5) { vec![bytes[at], chance.byte()] } else { vec![] };
    bytes.splice(at..=at, more);
    bytes
}

/// Returns an intact frame without meaning: another version, an unknown command, or a truncated
/// body.
fn meaningless(chance: &mut Chance, session: u32) -> Vec<u8> {
    let sequence = chance.byte() & 0x7F;
    match chance.below(3) {
        0 => framed([0, 1, 2, 255][chance.below(4) as usize], sequence, session, &body(chance)),
        1 => {
            let mut unknown: Vec<u8> = (0..chance.below(60)).map(|_| chance.byte()).collect();
            unknown.insert(0, 60 + chance.below(60) as u8);
            framed(VERSION, sequence, session, &unknown)
        }
        _ => {
            let body = body(chance);
            framed(VERSION, sequence, session, &body[..body.len() - 1])
        }
    }
}

/// Returns the body of a valid frame.
fn body(chance: &mut Chance) -> Vec<u8> {
    let frame = encode(1, NO_SESSION, session_command(chance)).unwrap_or_default();
    let plain = unstuffed(&frame);
    // After the header, before the checksum.
    plain[HEADER..plain.len() - 4].to_vec()
}

/// Undoes the byte stuffing of a frame: a code gives the distance to the next code, which replaces
/// a zero.
fn unstuffed(frame: &[u8]) -> Vec<u8> {
    let (mut plain, mut at) = (Vec::new(), 0);
    while let Some(&code) = frame.get(at).filter(|&&code| code > 0) {
        let end = (at + usize::from(code)).min(frame.len());
        plain.extend_from_slice(&frame[at + 1..end]);
        at = end;
        if code < 255 && frame.get(at).is_some_and(|&next| next > 0) {
            plain.push(0);
        }
    }
    plain
}

/// Returns a frame of these bytes with a valid checksum. The encoding is written here again, so
/// that it does not share errors with that of the board.
pub(super) fn framed(version: u8, sequence: u8, session: u32, body: &[u8]) -> Vec<u8> {
    let mut plain = [&[version, sequence], &session.to_le_bytes()[..], body].concat();
    let checksum = plain
        .iter()
        .fold(u32::MAX, |sum, &byte| (0..8).fold(sum ^ u32::from(byte), |sum, _| (sum >> 1) ^ ((sum & 1) * 0x82F6_3B78)));
    plain.extend((!checksum).to_le_bytes());
    let (mut stuffed, mut code) = (vec![1_u8], 0);
    for byte in plain {
        if byte == 0 || stuffed[code] == 255 {
            code = stuffed.len();
            stuffed.push(1);
        }
        if byte != 0 {
            stuffed.push(byte);
            stuffed[code] += 1;
        }
    }
    stuffed.push(0);
    stuffed
}

/// Draws a number, valid or invalid for a field.
pub(super) fn number(chance: &mut Chance) -> f32 {
    const ODD: [f32; 12] =
        [0.0, -0.0, 1.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE, 1e-45, 1e9, 0.5];
    match chance.below(4) {
        0 => ODD[chance.below(ODD.len() as u64) as usize],
        1 => f32::from_bits(chance.below(1 << 32) as u32),
        _ => 0.01 * chance.below(2000) as f32,
    }
}

/// Draws a valid value of the parameter with this key, an edge of its range, or any number.
pub(super) fn value(chance: &mut Chance, key: u8) -> f32 {
    let Some(parameter) = PARAMETERS.iter().find(|parameter| parameter.key == key) else { return number(chance) };
    let built_in = (parameter.read)(&Setup::default().config);
    let (least, most) = parameter.range.of(built_in);
    let part = 1e-3 * chance.below(1001) as f32;
    let (low, high) = (least.max(1e-12), most.min(1e9));
    match chance.below(8) {
        0 => number(chance),
        1 => [least, most, built_in, 0.5 * least, 2.0 * most][chance.below(5) as usize],
        2..5 => (low.ln() + part * (high / low).ln()).exp().clamp(low, high),
        _ if built_in.is_finite() => 1.5 * part * built_in,
        _ => 100.0 * part,
    }
}

/// Draws a key, mostly that of a parameter.
pub(super) fn key(chance: &mut Chance) -> u8 {
    match chance.below(12) {
        0 => chance.byte(),
        // Limits, and the scales of their measurements.
        1..4 => 8 + chance.below(7) as u8,
        4 => 1 + chance.below(3) as u8,
        _ => PARAMETERS[chance.below(PARAMETERS.len() as u64) as usize].key,
    }
}

/// Draws a valid command within a session.
fn session_command(chance: &mut Chance) -> Command {
    loop {
        let command = valid(chance);
        if !matches!(command, Command::Identify(_)) {
            return command;
        }
    }
}

/// Draws a valid command; `Run` is frequent enough that the board drives.
pub(super) fn valid(chance: &mut Chance) -> Command {
    let some = chance.strikes(0.8);
    match chance.below(36) {
        0..7 => Command::Run,
        7 => Command::Idle,
        8 => Command::Scan,
        9 => Command::Calibrate,
        10 => Command::Gate([Gate::On, Gate::Off, Gate::Scheduled, Gate::Brake][chance.below(4) as usize]),
        11 => Command::Amplitude(some.then(|| Amplitude::Volts(number(chance)))),
        12 => Command::Amplitude(some.then(|| Amplitude::MotionalCurrent(number(chance)))),
        13 | 14 => Command::ClearFault,
        15 => Command::TelemetryEvery(if some { chance.below(40) } else { chance.below(1 << 32) } as u32),
        16 => Command::Detune(Hertz(number(chance))),
        17 => Command::Quadrature(some.then(|| Turns(number(chance)))),
        18 => Command::Settings(Verb::Get(key(chance))),
        19 | 20 => {
            let key = key(chance);
            Command::Settings(Verb::Set(key, value(chance, key)))
        }
        21 => Command::Settings([Verb::Store, Verb::Clear, Verb::Defaults][chance.below(3) as usize]),
        22 => Command::Settings(Verb::Trims(chance.byte())),
        23 => Command::Resonances,
        24 => Command::Friction(some.then(|| Target::Ratio(number(chance)))),
        25 => Command::Friction(some.then(|| Target::Force(number(chance)))),
        26 => Command::Occupant(some.then(|| number(chance))),
        27 => Command::Status,
        28 => Command::Capture(CaptureVerb::Arm(Arm {
            trigger: [Trigger::Now, Trigger::Fault, Trigger::On, Trigger::Locked, Trigger::Unlocked][chance.below(5) as usize],
            before: chance.below(if some { 1100 } else { 1 << 16 }) as u16,
            lane: chance.below(if some { 4 } else { 256 }) as u8,
        })),
        29 => Command::Capture(CaptureVerb::Read(chance.below(if some { 40 } else { 1 << 16 }) as u16)),
        30 => Command::Capture(if some { CaptureVerb::State } else { CaptureVerb::Disarm }),
        31 => Command::Faults(chance.byte()),
        32 => Command::Reset,
        33 => Command::Patience(if some { 2e-3 * chance.below(1000) as f32 } else { number(chance) }),
        34 => Command::Update(match chance.below(5) {
            0 => UpdateVerb::Report,
            1 => UpdateVerb::Begin(chance.below(1 << 32) as u32),
            2 => UpdateVerb::Check,
            3 => UpdateVerb::Install,
            _ => UpdateVerb::Write(chance.below(1 << 20) as u32, std::array::from_fn(|_| [chance.byte(); 32])),
        }),
        _ => Command::Identify(chance.below(1 << 32) as u32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn framing_agrees_with_the_board() {
        let mut chance = Chance::new(1);
        for _ in 0..2000 {
            let session = chance.below(1 << 32) as u32;
            let frame = encode(1, session, valid(&mut chance)).unwrap();
            let plain = unstuffed(&frame);
            assert_eq!(framed(VERSION, 1, session, &plain[HEADER..plain.len() - 4]), frame[..]);
        }
    }
}
