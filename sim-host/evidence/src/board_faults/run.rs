//! One run: a clone of the driving board, a fault at a random time, and the response.

use std::time::Duration;

use board::{Board, BoardError};
use firmware::board::command::Command;
use firmware::board::start::Start;
use firmware::seam::mode::Mode;
use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::inject::{Draw, inject};
use super::kinds::{Fault, Kind};
use super::limits::{BLOCK_S, Verdict};
use super::snapshot::{Host, Snapshot};
use crate::campaign_error::CampaignError;

/// Wildcard for any reason that the image can report.
pub const ANY_REASON: &[&str] = &["*"];
/// Number of blocks over which the time of the fault is drawn, in steps of a nanosecond.
const SPREAD_BLOCKS: u32 = 64;
/// Time for which a drive that may continue is watched.
const WATCH_TIME: Duration = Duration::from_millis(15);
/// Interval at which the wires are checked: the clock must not change between an edge and the
/// check.
const CHECK_INTERVAL: Duration = Duration::from_nanos(500);
/// Time for which a board is watched after it is off; it contains the watchdog's reset.
const WATCH_TIME_OFF: Duration = Duration::from_millis(12);
/// Time from a restart until the board answers.
const RESTARTS_WITHIN: Duration = Duration::from_millis(8);
/// Timeout of an answer.
const ANSWERS_WITHIN: Duration = Duration::from_millis(12);
/// Number of times that a question is repeated.
const QUESTIONS: u32 = 3;
/// Largest change of the frequency of an unchanged drive, Hz.
const UNCHANGED_HZ: f32 = 5.0;
/// Largest relative change of the tip velocity of an unchanged drive.
const UNCHANGED_VELOCITY_REL: f64 = 0.05;

/// Result of a run.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Description of the random parameters.
    pub drawn: String,
    /// Time from the fault until the amplifier was off or the drive muted, s; `None` if it drives.
    pub off_s: Option<f64>,
    /// Reason that the board reports.
    pub reason: Option<String>,
    /// Number of restarts.
    pub resets: usize,
    /// Reason why the run failed; `None` if the response is the required one.
    pub failed: Option<String>,
}

/// Runs a kind once.
pub fn run(snapshot: &Snapshot, kind: &Kind, seed: u64, number: u32) -> Outcome {
    let place = super::kinds::KINDS.iter().position(|other| other.name == kind.name).unwrap_or(0) as u64;
    let mut draw = Draw(Xoshiro256PlusPlus::seed_from_u64(seed ^ place << 48 ^ u64::from(number) << 16));
    let mut outcome = Outcome::default();
    if let Err(error) = play(snapshot, kind, &mut draw, &mut outcome) {
        outcome.failed = Some(error.to_string());
    }
    outcome
}

fn play(snapshot: &Snapshot, kind: &Kind, draw: &mut Draw, outcome: &mut Outcome) -> Result<(), CampaignError> {
    let mut board = snapshot.board.clone();
    let span_ns = (f64::from(SPREAD_BLOCKS) * BLOCK_S * 1e9) as u32;
    board.run_for(Duration::from_nanos(draw.below(span_ns).into()))?;
    if kind.fault == Fault::LinkStream {
        let mut host = Host::new(board);
        host.ask(Command::TelemetryEvery(50), ANSWERS_WITHIN)?;
        board = host.release()?;
    }
    let before = Watch::new(&board);
    let velocity = board.bench().plant().plant().truth().tip_velocity_m_per_s;
    outcome.drawn = inject(&mut board, kind.fault, draw)?;
    match kind.verdict {
        Verdict::Off(limit) => {
            let longest = Duration::from_secs_f64(2.0 * limit.seconds() + 10e-3);
            outcome.off_s = before.until_off(&mut board, longest)?;
            let found = reason(board, &before, outcome)?;
            outcome.failed = match outcome.off_s {
                None => Some("the amplifier stays on".to_owned()),
                Some(off_s) if off_s > limit.seconds() => Some(format!("off after {:.1} us", 1e6 * off_s)),
                Some(_) => wrong_reason(kind, outcome.reason.as_deref()),
            }
            .or(found);
        }
        Verdict::DrivesOn | Verdict::OffOrDrivesOn => {
            let mut host = Host::new(board);
            let until = host.now() + WATCH_TIME;
            while host.now() < until && host.is_driving(&before) {
                // A missing answer is judged below.
                let _ = host.status(Duration::from_millis(2));
                host.run_for(Duration::from_micros(300))?;
            }
            let is_driving = host.is_driving(&before);
            let report = if is_driving { ask_repeatedly(&mut host, Host::status) } else { None };
            let mut board = host.release()?;
            if is_driving {
                let now = board.bench().plant().plant().truth().tip_velocity_m_per_s;
                outcome.failed = drive_change(snapshot.frequency_hz, report, (now / velocity - 1.0).abs());
                return Ok(());
            }
            outcome.off_s = before.until_off(&mut board, Duration::ZERO)?;
            let found = reason(board, &before, outcome)?;
            let is_off = (kind.verdict == Verdict::DrivesOn).then(|| "the drive has ended".to_owned());
            outcome.failed = is_off.or_else(|| wrong_reason(kind, outcome.reason.as_deref())).or(found);
        }
    }
    Ok(())
}

/// Returns the reason why a drive that continues is not unchanged.
fn drive_change(before: f32, report: Option<firmware::seam::telemetry::Telemetry>, velocity: f64) -> Option<String> {
    let Some(report) = report else { return Some("it drives, but does not answer".to_owned()) };
    if report.mode != Mode::Run || report.fault.is_some() {
        return Some(format!("it drives, but reports {:?}, {:?}", report.mode, report.fault));
    }
    if (report.frequency.0 - before).abs() > UNCHANGED_HZ || velocity > UNCHANGED_VELOCITY_REL {
        return Some(format!(
            "the drive has changed: {:.1} Hz instead of {before:.1}, tip velocity {:.0} % off",
            report.frequency.0,
            100.0 * velocity
        ));
    }
    None
}

fn wrong_reason(kind: &Kind, reason: Option<&str>) -> Option<String> {
    match reason {
        None => Some("off, but no reason is reported".to_owned()),
        Some(reason) if kind.reasons == ANY_REASON || kind.reasons.contains(&reason) => None,
        Some(reason) => Some(format!("off, but the reported reason is {reason}")),
    }
}

/// Repeats a question until there is an answer.
fn ask_repeatedly<T>(host: &mut Host, question: impl Fn(&mut Host, Duration) -> Result<Option<T>, CampaignError>) -> Option<T> {
    (0..QUESTIONS).find_map(|_| question(host, ANSWERS_WITHIN).ok().flatten())
}

/// Lets the board come to rest and asks why it is off. Returns the reason if that fails the run.
fn reason(mut board: Board, before: &Watch, outcome: &mut Outcome) -> Result<Option<String>, CampaignError> {
    let until = board.now() + WATCH_TIME_OFF;
    let mut restarted = board.now();
    let mut resets = board.bench().resets.len();
    while board.now() < until.max(restarted + RESTARTS_WITHIN) && board.bench().resets.len() < before.resets + 10 {
        board.run_block()?;
        if board.bench().resets.len() != resets {
            (resets, restarted) = (board.bench().resets.len(), board.now());
        }
    }
    outcome.resets = resets - before.resets;
    let rises = board.bench().edges[before.edges..].iter().filter(|edge| edge.high).count();
    let mut host = Host::new(board);
    outcome.reason = if outcome.resets > 0 {
        ask_repeatedly(&mut host, Host::faults).map(|log| cause(&log.last_run).to_owned())
    } else {
        let fault = ask_repeatedly(&mut host, Host::status).and_then(|report| report.fault).or_else(|| host.last_telemetry());
        fault.map(|fault| format!("fault {}", fault.code()))
    };
    Ok((rises > 0).then(|| "the amplifier comes on again".to_owned()))
}

/// Returns the cause of the last start, in words.
fn cause(start: &Start) -> &'static str {
    match start {
        Start::PowerOn => "power-on",
        Start::Pin => "the reset pin",
        Start::Ordered => "an order",
        Start::Watchdog => "the watchdog",
        Start::Panic(_) => "a panic",
        Start::HardFault(_) => "a hard fault",
        Start::Unexpected(_) => "an unexpected interrupt",
        Start::StreamLost(_) => "a lost stream",
        Start::DamagedCode(_) => "a damaged word of the code",
        Start::ClockFailed => "the crystal",
        Start::StackOverflow(_) => "a stack overflow",
        Start::SupplyLow => "a low supply",
        Start::RamParity => "the parity of the RAM",
        Start::UnsupportedSilicon(_) => "the silicon revision",
        Start::TripFailed(_) => "a failed test of the trips",
    }
}

/// State of the wires at the time of the fault.
pub struct Watch {
    at_s: f64,
    edges: usize,
    resets: usize,
}

impl Watch {
    fn new(board: &Board) -> Self {
        let chip = &board.machine().chip;
        let at_s = chip.seconds(board.machine().cycle());
        Watch { at_s, edges: board.bench().edges.len(), resets: board.bench().resets.len() }
    }

    /// Returns the time from the fault until the amplifier was switched off or the drive was muted
    /// for a block, s. It is exact until the core clock changes.
    fn off_s(&self, board: &Board) -> Option<f64> {
        let (bench, chip) = (board.bench(), &board.machine().chip);
        let fall = bench.edges[self.edges..].iter().find(|edge| !edge.high).map(|edge| edge.at);
        let sample = (1e-6 * chip.hz() as f64) as u64;
        let block = (BLOCK_S * chip.hz() as f64) as u64;
        let silent = bench.last_driven + sample;
        let muted = (board.machine().cycle() >= silent + block).then_some(silent);
        let off = fall.into_iter().chain(muted).min()?;
        Some((chip.seconds(off) - self.at_s).max(0.0))
    }

    /// Runs until the drive is off, for at most `longest`.
    fn until_off(&self, board: &mut Board, longest: Duration) -> Result<Option<f64>, BoardError> {
        let until = board.now() + longest;
        loop {
            match self.off_s(board) {
                None if board.now() < until => board.run_for(CHECK_INTERVAL)?,
                off_s => return Ok(off_s),
            }
        }
    }
}

impl Host {
    /// Returns `true` if the board still drives.
    fn is_driving(&self, before: &Watch) -> bool {
        before.off_s(&self.board()).is_none()
    }
}
