//! Ten thousand frames, most of them damaged, cut short, doubled, out of order, of another version or session, or of no meaning: whatever they do to the
//! link, the board does what the honest frames among them say, and nothing else.

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

const FRAMES: usize = 10_000;
/// Peak codes of the voltage limit, 12 V.
const LIMIT_CODES: u16 = 1200;

/// Something that an honest host may say; often enough that it drives.
fn honest(chance: &mut Chance) -> Command {
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
        // Who asks for another session ends this one: `session.rs`.
        _ => Command::Capture(CaptureVerb::Disarm),
    }
}

/// Bytes on the link before each block, and the honest frames among it.
struct Traffic {
    sent: Vec<Vec<u8>>,
    honest: HashSet<Vec<u8>>,
}

fn traffic(seed: u64, session: u32) -> Traffic {
    let mut chance = Chance::new(seed);
    let (mut sent, mut honest_ones, mut sequence) = (Vec::new(), HashSet::new(), 0);
    for _ in 0..FRAMES {
        let mut next = |chance: &mut Chance| {
            sequence += 1;
            encode(sequence, session, honest(chance)).unwrap().to_vec()
        };
        let one = next(&mut chance);
        let mut bytes = one.clone();
        match chance.below(10) {
            // As it is.
            0 | 1 => {}
            // Twice.
            2 => bytes.extend_from_slice(&one),
            // After its successor.
            3 => {
                let other = next(&mut chance);
                bytes = [&other[..], &one].concat();
                honest_ones.insert(other);
            }
            // Some bits turned, the closing zero's too.
            4 => (0..=chance.below(6)).for_each(|_| {
                let at = chance.below(bytes.len() as u64) as usize;
                bytes[at] ^= 1 << chance.below(8);
            }),
            // Cut short: the next frame runs into it.
            5 => bytes.truncate(chance.below(one.len() as u64) as usize),
            // A byte more, or less.
            6 => {
                let at = chance.below(bytes.len() as u64) as usize;
                let more = if chance.strikes(0.5) { vec![bytes[at], chance.byte()] } else { vec![] };
                bytes.splice(at..=at, more);
            }
            // Whole, and of another session, or of none.
            7 => {
                let other = [session ^ (1 << chance.below(32)), chance.below(1 << 32) as u32, 0][chance.below(3) as usize];
                bytes = encode(sequence, other, honest(&mut chance)).unwrap().to_vec();
            }
            // Of another version, or of no meaning.
            8 => {
                let version = if chance.strikes(0.5) { VERSION } else { [0, 1, 2, 255][chance.below(4) as usize] };
                let mut body: Vec<u8> = (0..chance.below(60)).map(|_| chance.byte()).collect();
                body.insert(0, 60 + chance.below(60) as u8);
                bytes = frame(version, chance.byte() & 0x7F, session, &body);
            }
            _ => bytes = (0..chance.below(400)).map(|_| chance.byte()).collect(),
        }
        honest_ones.insert(one);
        sent.push(bytes);
    }
    Traffic { sent, honest: honest_ones }
}

impl Traffic {
    /// The same, without what is not honest: what stands between two zeros and is a whole honest frame.
    fn purged(&self) -> Vec<Vec<u8>> {
        let mut pending = vec![];
        let purge = |bytes: &Vec<u8>| {
            let mut honest = vec![];
            for &byte in bytes {
                pending.push(byte);
                if byte == 0 {
                    let frame = std::mem::take(&mut pending);
                    if self.honest.contains(&frame) {
                        honest.extend(frame);
                    }
                }
            }
            honest
        };
        self.sent.iter().map(purge).collect()
    }
}

/// What a run has come to.
#[derive(Debug, PartialEq)]
struct Outcome {
    hash: u64,
    answers: Vec<(u16, Reply)>,
    flash: Vec<u8>,
    resets: u32,
}

/// A run of this traffic; with how many refusals of frames, and how many blocks sounded.
fn outcome(sent: &[Vec<u8>]) -> (Outcome, usize, usize) {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    for bytes in sent {
        bench.host.send_bytes(bytes).unwrap();
        // As often as it takes for all answers to leave.
        (0..8).for_each(|_| bench.poll());
        bench.block();
    }
    bench.blocks(4);
    bench.host.receive(usize::MAX);
    assert_eq!((bench.host.spoiled(), bench.errors(), bench.watchdog.bitten()), (&[][..], &[][..], None));
    assert!(peak(&played(&mut bench, 0)) <= LIMIT_CODES);
    let sounding = bench.analog().blocks().filter(|exchange| sounds(exchange)).count();
    let of_frames =
        |reply: &Reply| matches!(reply, Reply::Nak(Refusal::Damaged | Refusal::Version | Refusal::Unknown | Refusal::Session));
    let (refused, answers): (Vec<_>, Vec<_>) =
        bench.host.answers().map(|(sequence, reply)| (sequence, *reply)).partition(|(_, reply)| of_frames(reply));
    let (hash, resets) = (bench.analog().hash(), bench.watchdog.resets());
    let flash = bench.power_off().bytes().to_vec();
    (Outcome { hash, answers, flash, resets }, refused.len(), sounding)
}

#[test]
fn of_ten_thousand_frames_only_honest_ones_have_an_effect() {
    for seed in [1, 2] {
        // The session that each board gives the first host.
        let session = bench(&mut Queues::default(), &Setup::default()).host.session();
        let traffic = traffic(seed, session);
        let purged = traffic.purged();
        let whole: usize = purged.iter().flatten().filter(|&&byte| byte == 0).count();
        let ((with, refused, sounding), (without, none, _)) = (outcome(&traffic.sent), outcome(&purged));
        println!(
            "seed {seed}: {whole} whole, {} answered, {refused} refused; {sounding} of {FRAMES} blocks sounded, {} resets",
            with.answers.len(),
            with.resets
        );
        assert_eq!(none, 0);
        assert_eq!((with.hash, with.resets, with.answers.len()), (without.hash, without.resets, whole));
        assert!(with == without);
        assert!(whole > FRAMES / 3 && refused > FRAMES / 4 && sounding > FRAMES / 10, "{whole} {refused} {sounding}");
    }
}
