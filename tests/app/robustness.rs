//! Ten thousand frames, most of them damaged, cut short, doubled, out of order, of another version
//! or session, or meaningless. The board obeys the valid frames among them, and nothing else.

use std::collections::HashSet;

use firmware::board::capture::{Arm, CaptureVerb, Trigger};
use firmware::board::command::{Command, Reply, Verb};
use firmware::board::link::{VERSION, encode};
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::refusal::Refusal;
use firmware::seam::units::{Hertz, Turns};
use hal_mock::bench::{Queues, Setup};
use hal_mock::chance::Chance;

use super::frame::frame;
use super::*;

/// Number of frames in a run.
const FRAMES: usize = 10_000;
/// Voltage limit of 12 V, peak codes.
const LIMIT_CODES: u16 = 1200;

/// Returns a random valid command; often one that starts the drive.
fn valid_command(chance: &mut Chance) -> Command {
    let number = chance.below(1000) as f32;
    match chance.below(28) {
        0..6 => Command::Run,
        6 => Command::Idle,
        7 => Command::Scan,
        8 => Command::Gate([Gate::On, Gate::Off, Gate::Scheduled, Gate::Brake][chance.below(4) as usize]),
        9 => Command::Amplitude(Some(Amplitude::Volts(0.02 * number))),
        10 => Command::Amplitude(Some(Amplitude::Volts(f32::NAN))),
        11 => Command::Amplitude(None),
        12 => Command::ClearFault,
        13 => Command::TelemetryEvery(chance.below(40) as u32),
        14 => Command::Detune(Hertz(number - 500.0)),
        15 => Command::Quadrature(Some(Turns(0.0003 * number))),
        16 => Command::Settings(Verb::Get(chance.below(30) as u8)),
        17 => Command::Settings(Verb::Set(chance.below(30) as u8, 0.01 * number)),
        18 => Command::Settings([Verb::Store, Verb::Clear, Verb::Defaults, Verb::Trims(1)][chance.below(4) as usize]),
        19 => Command::Status,
        20 => Command::Faults(chance.below(10) as u8),
        21 => Command::Patience([0.0, 2e-3, 1.0, -1.0, 1e9][chance.below(5) as usize]),
        22 => Command::Capture(CaptureVerb::Arm(Arm { trigger: Trigger::Now, before: chance.below(1100) as u16, lane: 0 })),
        23 => Command::Capture(CaptureVerb::Read(chance.below(40) as u16)),
        24 => Command::Capture(CaptureVerb::State),
        25 => Command::Reset,
        26 => Command::Resonances,
        // A request for another session ends this one: see `session.rs`.
        _ => Command::Capture(CaptureVerb::Disarm),
    }
}

/// Bytes on the link before each block, and the valid frames among them.
struct Traffic {
    sent: Vec<Vec<u8>>,
    valid_command: HashSet<Vec<u8>>,
}

fn traffic(seed: u64, session: u32) -> Traffic {
    let mut chance = Chance::new(seed);
    let (mut sent, mut valid_frames, mut sequence) = (Vec::new(), HashSet::new(), 0);
    for _ in 0..FRAMES {
        let mut next = |chance: &mut Chance| {
            sequence += 1;
            encode(sequence, session, valid_command(chance)).unwrap().to_vec()
        };
        let one = next(&mut chance);
        let mut bytes = one.clone();
        match chance.below(10) {
            // Unchanged.
            0 | 1 => {}
            // Doubled.
            2 => bytes.extend_from_slice(&one),
            // Sent after its successor.
            3 => {
                let other = next(&mut chance);
                bytes = [&other[..], &one].concat();
                valid_frames.insert(other);
            }
            // Some bits flipped, also in the closing zero.
            4 => (0..=chance.below(6)).for_each(|_| {
                let at = chance.below(bytes.len() as u64) as usize;
                bytes[at] ^= 1 << chance.below(8);
            }),
            // Cut short: the next frame is appended to it.
            5 => bytes.truncate(chance.below(one.len() as u64) as usize),
            // One byte inserted or removed.
            6 => {
                let at = chance.below(bytes.len() as u64) as usize;
                let more = if chance.strikes(0.5) { vec![bytes[at], chance.byte()] } else { vec![] };
                bytes.splice(at..=at, more);
            }
            // Valid, but of another session or without one.
            7 => {
                let other = [session ^ (1 << chance.below(32)), chance.below(1 << 32) as u32, 0][chance.below(3) as usize];
                bytes = encode(sequence, other, valid_command(&mut chance)).unwrap().to_vec();
            }
            // Of another version, or meaningless.
            8 => {
                let version = if chance.strikes(0.5) { VERSION } else { [0, 1, 2, 255][chance.below(4) as usize] };
                let mut body: Vec<u8> = (0..chance.below(60)).map(|_| chance.byte()).collect();
                body.insert(0, 60 + chance.below(60) as u8);
                bytes = frame(version, chance.byte() & 0x7F, session, &body);
            }
            _ => bytes = (0..chance.below(400)).map(|_| chance.byte()).collect(),
        }
        valid_frames.insert(one);
        sent.push(bytes);
    }
    Traffic { sent, valid_command: valid_frames }
}

impl Traffic {
    /// Returns the same traffic with only its valid frames: whole ones between two zeros.
    fn purged(&self) -> Vec<Vec<u8>> {
        let mut pending = vec![];
        let purge = |bytes: &Vec<u8>| {
            let mut valid_command = vec![];
            for &byte in bytes {
                pending.push(byte);
                if byte == 0 {
                    let frame = std::mem::take(&mut pending);
                    if self.valid_command.contains(&frame) {
                        valid_command.extend(frame);
                    }
                }
            }
            valid_command
        };
        self.sent.iter().map(purge).collect()
    }
}

/// Result of a run.
#[derive(Debug, PartialEq)]
struct Outcome {
    hash: u64,
    answers: Vec<(u16, Reply)>,
    flash: Vec<u8>,
    resets: u32,
}

/// Runs this traffic. Returns the result, the number of refused frames, and the number of blocks
/// that were not silent.
fn outcome(sent: &[Vec<u8>]) -> (Outcome, usize, usize) {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    for bytes in sent {
        bench.host.send_bytes(bytes).unwrap();
        // Often enough for all answers to be sent.
        (0..8).for_each(|_| bench.poll());
        bench.block();
    }
    bench.blocks(4);
    bench.host.receive(usize::MAX);
    assert_eq!((bench.host.frame_errors(), bench.errors(), bench.watchdog.bitten()), (&[][..], &[][..], None));
    assert!(peak(&played(&mut bench, 0)) <= LIMIT_CODES);
    let sounding = bench.analog().blocks().filter(|exchange| is_driven(exchange)).count();
    let of_frames =
        |reply: &Reply| matches!(reply, Reply::Nak(Refusal::Damaged | Refusal::Version | Refusal::Unknown | Refusal::Session));
    let (refused, answers): (Vec<_>, Vec<_>) =
        bench.host.answers().map(|(sequence, reply)| (sequence, *reply)).partition(|(_, reply)| of_frames(reply));
    let (hash, resets) = (bench.analog().hash(), bench.watchdog.resets());
    let flash = bench.power_off().bytes().to_vec();
    (Outcome { hash, answers, flash, resets }, refused.len(), sounding)
}

#[test]
fn only_valid_frames_have_an_effect() {
    for seed in [1, 2] {
        // Every board gives its first host this session.
        let session = bench(&mut Queues::default(), &Setup::default()).host.session();
        let traffic = traffic(seed, session);
        let purged = traffic.purged();
        let whole: usize = purged.iter().flatten().filter(|&&byte| byte == 0).count();
        let ((with, refused, sounding), (without, none, _)) = (outcome(&traffic.sent), outcome(&purged));
        println!(
            "seed {seed}: {whole} whole, {} answered, {refused} refused; {sounding} of {FRAMES} blocks not silent, {} resets",
            with.answers.len(),
            with.resets
        );
        assert_eq!(none, 0);
        assert_eq!((with.hash, with.resets, with.answers.len()), (without.hash, without.resets, whole));
        assert!(with == without);
        assert!(whole > FRAMES / 3 && refused > FRAMES / 4 && sounding > FRAMES / 10, "{whole} {refused} {sounding}");
    }
}
