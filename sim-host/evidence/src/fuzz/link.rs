//! The link: for any received bytes, the board obeys the valid frames of its session and nothing
//! else.
//!
//! Two boards are fed, one with all bytes and one with only the valid frames. Converters, answers,
//! enable pin, flash and resets must be equal to the last bit. If a valid order was refused as
//! busy, they must equal those of a board with an empty frame instead of each invalid one. Both
//! boards go through several lives: each life starts with the settings stored in the one before.

use firmware::board::command::Reply;
use firmware::board::link::{NO_SESSION, encode};
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Bench, Queues, Setup};
use hal_mock::chance::Chance;
use hal_mock::flash::Flash;
use hal_mock::loop_back::LoopBack;
use hal_mock::tracer::Tracer;

use super::corpus;
use super::frames::{EMPTY_FRAME, Traffic};
use super::target::{Tally, Target};

pub(super) const TARGET: Target = Target {
    name: "link",
    what: "bytes to the board: decoder, background task, block task",
    seeds_per_million: 10,
    feed,
    corpus: of_corpus,
};

/// Smallest number of bytes of each seed.
const MIN_BYTES: usize = 100_000;
/// Number of lives of a board.
const LIVES: usize = 2;
/// Number of blocks in an occasional lull between two pieces of traffic, in which orders take
/// effect; otherwise there is one block.
const LULL_BLOCKS: u64 = 200;
/// Peak codes of the built-in voltage limit, 12 V, which no setting may exceed.
const LIMIT_CODES: u16 = 1200;

fn feed(seed: u64, tally: &mut Tally) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    let mut setup = Setup::default();
    setup.config.lanes = [1, 2, 4][chance.below(3) as usize];
    setup.config.link.patience_s = [0.0, 0.01, 1.0][chance.below(3) as usize];
    let traffic = Traffic::new(&mut chance, MIN_BYTES, session(&setup)?);
    let lulls: Vec<u64> = traffic.sent.iter().map(|_| if chance.strikes(0.02) { LULL_BLOCKS } else { 1 }).collect();
    judge(&setup, &traffic, &lulls, tally)
}

/// Returns the session that a board gives the host of a bench before its first block. It is the
/// same in each life, and on each board.
fn session(setup: &Setup) -> Result<u32, String> {
    let mut queues = Queues::default();
    let bench = Bench::new(&mut queues, setup, LoopBack::of(&setup.config));
    Ok(bench.map_err(|error| format!("the board does not start: {error}"))?.connect())
}

/// Feeds each file of the corpus: lines of hexadecimal digits, valid frames after a plus.
fn of_corpus(tally: &mut Tally) -> Result<(), String> {
    for (name, text) in corpus::LINK {
        let mut traffic = Traffic::default();
        for line in text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
            let (valid, digits) = (line.starts_with('+'), line.trim_start_matches(['+', '-', ' ']));
            let byte = |pair: &str| u8::from_str_radix(pair, 16).map_err(|error| format!("{name}: {pair}: {error}"));
            let bytes = digits.split_whitespace().map(byte).collect::<Result<Vec<u8>, String>>()?;
            if valid {
                traffic.valid.insert(bytes.clone());
            }
            traffic.sent.push(bytes);
        }
        let lulls = vec![LULL_BLOCKS; traffic.sent.len()];
        judge(&Setup::default(), &traffic, &lulls, tally).map_err(|failure| format!("{name}: {failure}"))?;
    }
    Ok(())
}

/// Feeds two boards, and compares them.
fn judge(setup: &Setup, traffic: &Traffic, lulls: &[u64], tally: &mut Tally) -> Result<(), String> {
    let life = traffic.sent.len().div_ceil(LIVES);
    let mut flashes = [setup.flash.clone(), setup.flash.clone()];
    for (sent, lulls) in traffic.sent.chunks(life).zip(lulls.chunks(life)) {
        let [with, without] = flashes;
        let (mut other, with) = (
            live(setup, without.clone(), &traffic.purged(sent, &[]), lulls, None)?,
            live(setup, with, sent, lulls, Some(&mut *tally))?,
        );
        if other.refused > 0 {
            return Err(format!("{} valid frames are refused as damaged or of another session", other.refused));
        }
        if with.life != other.life && with.busy > other.busy {
            // Answers to damaged frames take time and places in queues, so a valid order may find
            // its queue full. With as many answers the other board does so too.
            other = live(setup, without, &traffic.purged(sent, &EMPTY_FRAME), lulls, None)?;
        }
        if with.life != other.life {
            return Err(differ(&with.life, &other.life));
        }
        flashes = [with.flash, other.flash];
    }
    tally.inputs += traffic.sent.len() as u64;
    tally.bytes += traffic.sent.iter().map(|bytes| bytes.len() as u64).sum::<u64>();
    Ok(())
}

/// Observable behaviour of a board.
#[derive(PartialEq)]
struct Life {
    hash: u64,
    /// Answers, as bytes, so that NaN equals itself.
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

/// Runs a board from its start to its end.
fn live(setup: &Setup, flash: Flash, sent: &[Vec<u8>], lulls: &[u64], mut tally: Option<&mut Tally>) -> Result<Lived, String> {
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
        // Until all answers have left: there is at most one for each zero.
        let frames = bytes.iter().filter(|&&byte| byte == 0).count();
        (0..frames + 2).for_each(|_| bench.poll());
        for _ in 0..blocks {
            bench.block();
            enabled.push(bench.enable.is_high());
            let loudest = bench.analog().blocks().flat_map(|exchange| exchange.drive.lanes.iter().flatten());
            let loudest = loudest.map(|code| code.abs_diff(mid_code)).max().unwrap_or(0);
            if loudest > LIMIT_CODES {
                return Err(format!("{loudest} codes in block {}, but the limit is {LIMIT_CODES}", bench.played()));
            }
        }
        if let Some(tally) = &mut tally {
            tally.outcome(&format!("mode {:?}", bench.mode()));
            if let Some(fault) = bench.fault() {
                tally.outcome(&format!("fault {fault:?}"));
            }
        }
    }
    bench.blocks(4);
    bench.host.receive(usize::MAX);
    if !bench.host.frame_errors().is_empty() || !bench.errors().is_empty() || bench.watchdog.bitten().is_some() {
        return Err(format!("{:?}, {:?}, {:?}", bench.host.frame_errors(), bench.errors(), bench.watchdog.bitten()));
    }
    let of_frames =
        |reply: &Reply| matches!(reply, Reply::Nak(Refusal::Damaged | Refusal::Version | Refusal::Unknown | Refusal::Session));
    let (mut answers, mut refused, mut busy) = (Vec::new(), 0, 0);
    for (sequence, reply) in bench.host.answers() {
        if let Some(tally) = &mut tally {
            tally.outcome(&kind(reply));
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

/// Returns the kind of an answer: its name, and that of a refusal.
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

/// Describes the differences between the two boards.
fn differ(with: &Life, without: &Life) -> String {
    let first = with.answers.iter().zip(&without.answers).position(|(one, other)| one != other);
    format!(
        "damage has an effect: equal drive {}, equal flash {}, equal enable pin {}; resets {} and {}; answers {} and {}, the \
         first that differs {first:?}",
        with.hash == without.hash,
        with.flash == without.flash,
        with.enabled == without.enabled,
        with.resets,
        without.resets,
        with.answers.len(),
        without.answers.len(),
    )
}
