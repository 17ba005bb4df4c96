//! The link: whatever comes over it, the board does what the honest frames of its session say, and nothing else.
//!
//! Two boards are fed, one by all bytes and one by the honest frames alone: converters, answers, enable pin, flash and resets must be the same to the
//! last bit; or, where an honest order was refused as busy, the same as with a frame that is nothing for each of the others. Both go through several
//! lives: what one has stored the next is started with.

use firmware::board::command::Reply;
use firmware::board::link::{NO_SESSION, encode};
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Bench, Queues, Setup};
use hal_mock::chance::Chance;
use hal_mock::flash::Flash;
use hal_mock::loop_back::LoopBack;
use hal_mock::tracer::Tracer;

use super::corpus;
use super::frames::{NOTHING, Traffic};
use super::target::{Seen, Target};

pub(super) const TARGET: Target = Target {
    name: "link",
    what: "bytes to the board: decoder, background task, block task",
    seeds_per_million: 10,
    feed,
    corpus: of_corpus,
};

/// Bytes of each seed, at least.
const BYTES: usize = 100_000;
/// Lives of a board.
const LIVES: usize = 2;
/// Blocks between two pieces of traffic are one, or sometimes so many: what is ordered then has its time.
const LULL: u64 = 200;
/// Peak codes of the voltage limit that is built in, 12 V: no setting lets more pass.
const LIMIT_CODES: u16 = 1200;

fn feed(seed: u64, seen: &mut Seen) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    let mut setup = Setup::default();
    setup.config.lanes = [1, 2, 4][chance.below(3) as usize];
    setup.config.link.patience_s = [0.0, 0.01, 1.0][chance.below(3) as usize];
    let traffic = Traffic::of(&mut chance, BYTES, session(&setup)?);
    let lulls: Vec<u64> = traffic.sent.iter().map(|_| if chance.strikes(0.02) { LULL } else { 1 }).collect();
    judge(&setup, &traffic, &lulls, seen)
}

/// The session that a board gives the host of a bench before its first block: the same in each of its lives, and on each board.
fn session(setup: &Setup) -> Result<u32, String> {
    let mut queues = Queues::default();
    let bench = Bench::new(&mut queues, setup, LoopBack::of(&setup.config));
    Ok(bench.map_err(|error| format!("the board does not start: {error}"))?.connect())
}

/// Each of the corpus: lines of hexadecimal digits, honest frames after a plus.
fn of_corpus(seen: &mut Seen) -> Result<(), String> {
    for (name, text) in corpus::LINK {
        let mut traffic = Traffic::default();
        for line in text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
            let (honest, digits) = (line.starts_with('+'), line.trim_start_matches(['+', '-', ' ']));
            let byte = |pair: &str| u8::from_str_radix(pair, 16).map_err(|error| format!("{name}: {pair}: {error}"));
            let bytes = digits.split_whitespace().map(byte).collect::<Result<Vec<u8>, String>>()?;
            if honest {
                traffic.honest.insert(bytes.clone());
            }
            traffic.sent.push(bytes);
        }
        let lulls = vec![LULL; traffic.sent.len()];
        judge(&Setup::default(), &traffic, &lulls, seen).map_err(|failure| format!("{name}: {failure}"))?;
    }
    Ok(())
}

/// Feeds two boards, and compares them.
fn judge(setup: &Setup, traffic: &Traffic, lulls: &[u64], seen: &mut Seen) -> Result<(), String> {
    let life = traffic.sent.len().div_ceil(LIVES);
    let mut flashes = [setup.flash.clone(), setup.flash.clone()];
    for (sent, lulls) in traffic.sent.chunks(life).zip(lulls.chunks(life)) {
        let [with, without] = flashes;
        let (mut other, with) = (
            live(setup, without.clone(), &traffic.purged(sent, &[]), lulls, None)?,
            live(setup, with, sent, lulls, Some(&mut *seen))?,
        );
        if other.refused > 0 {
            return Err(format!("{} honest frames are refused as damaged or of another session", other.refused));
        }
        if with.life != other.life && with.busy > other.busy {
            // Answers to damaged frames take places and turns, so an order of the honest may find its queue full: beside as many answers it does, too.
            other = live(setup, without, &traffic.purged(sent, &NOTHING), lulls, None)?;
        }
        if with.life != other.life {
            return Err(differ(&with.life, &other.life));
        }
        flashes = [with.flash, other.flash];
    }
    seen.inputs += traffic.sent.len() as u64;
    seen.bytes += traffic.sent.iter().map(|bytes| bytes.len() as u64).sum::<u64>();
    Ok(())
}

/// What a board has done that others see.
#[derive(PartialEq)]
struct Life {
    hash: u64,
    /// Answers, as bytes: a number that is none is no reason to differ.
    answers: Vec<Vec<u8>>,
    flash: Vec<u8>,
    resets: u32,
    /// The enable pin after each block.
    enabled: Vec<bool>,
}

struct Lived {
    life: Life,
    flash: Flash,
    refused: usize,
    busy: usize,
}

/// A board from its start to its end.
fn live(setup: &Setup, flash: Flash, sent: &[Vec<u8>], lulls: &[u64], mut seen: Option<&mut Seen>) -> Result<Lived, String> {
    let setup = Setup { flash, ..setup.clone() };
    let mut queues = Queues::default();
    let load = Tracer::new(LoopBack::of(&setup.config), 1);
    let mut bench = Bench::new(&mut queues, &setup, load).map_err(|error| format!("the board does not start: {error}"))?;
    bench.connect();
    bench.host.forget();
    let mut enabled = Vec::new();
    let mid_code = setup.config.front_end.drive_mid_code;
    for (bytes, &blocks) in sent.iter().zip(lulls) {
        bench.host.send_bytes(bytes).map_err(|error| error.to_string())?;
        // As often as it takes for all answers to leave: there is one for each zero at most.
        let frames = bytes.iter().filter(|&&byte| byte == 0).count();
        (0..frames + 2).for_each(|_| bench.poll());
        for _ in 0..blocks {
            bench.block();
            enabled.push(bench.enable.is_high());
            let loudest = bench.analog().blocks().flat_map(|exchange| exchange.drive.lanes.iter().flatten());
            let loudest = loudest.map(|code| code.abs_diff(mid_code)).max().unwrap_or(0);
            if loudest > LIMIT_CODES {
                return Err(format!("{loudest} codes in block {}, and the limit is {LIMIT_CODES}", bench.played()));
            }
        }
        if let Some(seen) = &mut seen {
            seen.outcome(&format!("mode {:?}", bench.mode()));
            if let Some(fault) = bench.fault() {
                seen.outcome(&format!("fault {fault:?}"));
            }
        }
    }
    bench.blocks(4);
    bench.host.receive(usize::MAX);
    if !bench.host.spoiled().is_empty() || !bench.errors().is_empty() || bench.watchdog.bitten().is_some() {
        return Err(format!("{:?}, {:?}, {:?}", bench.host.spoiled(), bench.errors(), bench.watchdog.bitten()));
    }
    let of_frames =
        |reply: &Reply| matches!(reply, Reply::Nak(Refusal::Damaged | Refusal::Version | Refusal::Unknown | Refusal::Session));
    let (mut answers, mut refused, mut busy) = (Vec::new(), 0, 0);
    for (sequence, reply) in bench.host.answers() {
        if let Some(seen) = &mut seen {
            seen.outcome(&kind(reply));
        }
        busy += usize::from(matches!(reply, Reply::Nak(Refusal::Busy)));
        if of_frames(reply) {
            refused += 1;
        } else {
            answers.push(encode(sequence, NO_SESSION, reply).map_err(|error| format!("{error:?}"))?.to_vec());
        }
    }
    let (hash, resets) = (bench.analog().hash(), bench.watchdog.resets());
    let flash = bench.power_off();
    Ok(Lived { life: Life { hash, answers, flash: flash.bytes().to_vec(), resets, enabled }, flash, refused, busy })
}

/// The kind of an answer: its name, and that of a refusal.
fn kind(reply: &Reply) -> String {
    match reply {
        Reply::Nak(refusal) => format!("refused: {refusal:?}"),
        Reply::Update(report) => format!("update: {:?}", report.state),
        reply => {
            let text = format!("{reply:?}");
            text.split(['(', ' ']).next().unwrap_or_default().to_owned()
        }
    }
}

/// In what the two boards differ.
fn differ(with: &Life, without: &Life) -> String {
    let first = with.answers.iter().zip(&without.answers).position(|(one, other)| one != other);
    format!(
        "damage has an effect: the same drive {}, flash {}, enable pin {}; resets {} and {}; answers {} and {}, the first that differs {first:?}",
        with.hash == without.hash,
        with.flash == without.flash,
        with.enabled == without.enabled,
        with.resets,
        without.resets,
        with.answers.len(),
        without.answers.len(),
    )
}
