//! Traffic for the board: frames that an honest host may send, and what can become of them on the way.

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

/// Frames that come before a block where there is much traffic.
const BUSY: u64 = 40;
/// Pieces of traffic that are alike in that.
const PHASE: u64 = 60;
/// Version, a sequence number up to 127, and the session, bytes.
const HEADER: usize = 6;
/// A frame without a byte in it, which is answered as damaged.
pub(super) const NOTHING: [u8; 2] = [1, 0];
/// The longest flood without a frame, bytes.
const FLOOD: u64 = 4000;

/// Bytes on the link before each block, and the honest frames among it.
#[derive(Default)]
pub(super) struct Traffic {
    pub(super) sent: Vec<Vec<u8>>,
    pub(super) honest: HashSet<Vec<u8>>,
    /// The session of the honest frames.
    session: u32,
}

impl Traffic {
    /// At least so many bytes, for a board that is in this session.
    pub(super) fn of(chance: &mut Chance, bytes: usize, session: u32) -> Self {
        let (mut traffic, mut sequence, mut count) = (Traffic { session, ..Traffic::default() }, chance.below(1 << 16) as u16, 0);
        let mut frames = 1;
        while count < bytes {
            if (traffic.sent.len() as u64).is_multiple_of(PHASE) {
                frames = if chance.strikes(0.5) { 1 } else { BUSY };
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

    /// One frame more, as it is or as it has become.
    fn frame(&mut self, chance: &mut Chance, sequence: &mut u16, piece: &mut Vec<u8>) {
        let mut next = |chance: &mut Chance| {
            *sequence = sequence.wrapping_add(1);
            let frame = encode(*sequence, self.session, of_session(chance)).unwrap_or_default().to_vec();
            self.honest.insert(frame.clone());
            frame
        };
        let one = next(chance);
        piece.extend(match chance.below(15) {
            0..4 => one,
            // Twice; after its successor.
            4 => [&one[..], &one].concat(),
            5 => [next(chance), one].concat(),
            6 => turned(chance, one),
            // Cut short: the next frame runs into it.
            7 => one[..chance.below(one.len() as u64) as usize].to_vec(),
            8 => longer_or_shorter(chance, one),
            // The head of one with the tail of another.
            9 => {
                let other = next(chance);
                let (head, tail) = (chance.below(one.len() as u64), chance.below(other.len() as u64));
                [&one[..head as usize], &other[tail as usize..]].concat()
            }
            // Whole, with a checksum that is right, of another version or of no meaning.
            10 => meaningless(chance, self.session),
            // Whole, and with something behind its body.
            11 => {
                let more: Vec<u8> = (0..=chance.below(4)).map(|_| chance.byte()).collect();
                framed(VERSION, chance.byte() & 0x7F, self.session, &[&body(chance)[..], &more].concat())
            }
            // As long as a frame can be, and a little longer.
            12 => {
                let length = MAX_FRAME as u64 - 8 + chance.below(12);
                (0..length).map(|_| chance.byte().max(1)).chain([0]).collect()
            }
            // Whole, and of another session, or of none.
            13 => {
                let session =
                    [self.session ^ (1 << chance.below(32)), chance.below(1 << 32) as u32, NO_SESSION][chance.below(3) as usize];
                encode(*sequence, session, of_session(chance)).unwrap_or_default().to_vec()
            }
            _ => {
                let most = if chance.strikes(0.05) { FLOOD } else { 100 };
                (0..chance.below(most)).map(|_| chance.byte()).collect()
            }
        });
    }

    /// A part of it, with something else in place of each frame that is not honest: what stands between two zeros is one frame.
    pub(super) fn purged(&self, sent: &[Vec<u8>], instead: &[u8]) -> Vec<Vec<u8>> {
        let mut pending = vec![];
        let purge = |bytes: &Vec<u8>| {
            let mut purged = vec![];
            for &byte in bytes {
                pending.push(byte);
                if byte == 0 {
                    // An empty frame has no answer.
                    let stands = if self.honest.contains(&pending) { &pending } else { instead };
                    purged.extend_from_slice(if pending.len() > 1 { stands } else { &[] });
                    pending.clear();
                }
            }
            purged
        };
        sent.iter().map(purge).collect()
    }
}

/// Some bits turned, the closing zero's too.
fn turned(chance: &mut Chance, mut bytes: Vec<u8>) -> Vec<u8> {
    for _ in 0..=chance.below(6) {
        let at = chance.below(bytes.len() as u64) as usize;
        bytes[at] ^= 1 << chance.below(8);
    }
    bytes
}

/// A byte more, or less.
fn longer_or_shorter(chance: &mut Chance, mut bytes: Vec<u8>) -> Vec<u8> {
    let at = chance.below(bytes.len() as u64) as usize;
    let more = if chance.strikes(0.5) { vec![bytes[at], chance.byte()] } else { vec![] };
    bytes.splice(at..=at, more);
    bytes
}

/// A whole frame that says nothing: of another version, of no known command, or with a body that ends too early.
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

/// The body of an honest frame.
fn body(chance: &mut Chance) -> Vec<u8> {
    let frame = encode(1, NO_SESSION, of_session(chance)).unwrap_or_default();
    let plain = unstuffed(&frame);
    // Behind the header, before the checksum.
    plain[HEADER..plain.len() - 4].to_vec()
}

/// The bytes of a frame before they were stuffed: a code says how many of them follow it, and stands for the zero behind those.
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

/// A frame of these bytes with a checksum that is right. It is written here again, so that it does not share its mistakes.
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

/// A number that a field may have, or should not.
pub(super) fn number(chance: &mut Chance) -> f32 {
    const ODD: [f32; 12] =
        [0.0, -0.0, 1.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN_POSITIVE, 1e-45, 1e9, 0.5];
    match chance.below(4) {
        0 => ODD[chance.below(ODD.len() as u64) as usize],
        1 => f32::from_bits(chance.below(1 << 32) as u32),
        _ => 0.01 * chance.below(2000) as f32,
    }
}

/// A value that the parameter with this key may have, an edge of its range, or any number.
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

/// A key, mostly of a parameter.
pub(super) fn key(chance: &mut Chance) -> u8 {
    match chance.below(12) {
        0 => chance.byte(),
        // Limits, and what they are measured by.
        1..4 => 8 + chance.below(7) as u8,
        4 => 1 + chance.below(3) as u8,
        _ => PARAMETERS[chance.below(PARAMETERS.len() as u64) as usize].key,
    }
}

/// Something that an honest host may say in its session.
fn of_session(chance: &mut Chance) -> Command {
    loop {
        let command = honest(chance);
        if !matches!(command, Command::Identify(_)) {
            return command;
        }
    }
}

/// Something that an honest host may say; often enough that it drives.
pub(super) fn honest(chance: &mut Chance) -> Command {
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
    fn what_is_framed_here_is_what_the_board_frames() {
        let mut chance = Chance::new(1);
        for _ in 0..2000 {
            let session = chance.below(1 << 32) as u32;
            let frame = encode(1, session, honest(&mut chance)).unwrap();
            let plain = unstuffed(&frame);
            assert_eq!(framed(VERSION, 1, session, &plain[HEADER..plain.len() - 4]), frame[..]);
        }
    }
}
