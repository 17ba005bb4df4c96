//! `lock`: finds the resonance, locks to it and runs; reports frequency and time of the lock.

use std::time::Duration;

use clap::Args;
use firmware::board::command::Command;
use firmware::seam::block::Gate;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::units::Hertz;

use super::{circuit, scan, seconds, status};
use crate::answer::{Answer, short};
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct LockArgs {
    /// Maximum time for the lock.
    #[arg(long, value_name = "S", default_value = "5", value_parser = seconds)]
    within: f64,
}

impl Default for LockArgs {
    fn default() -> Self {
        LockArgs { within: 5.0 }
    }
}

/// Lock as observed by the host.
pub struct Locked {
    /// First report of the lock.
    pub report: Telemetry,
    /// Number of blocks from the acknowledged order to that report.
    pub blocks: u32,
    /// Number of blocks from the preceding report to that one. The lock may be earlier by this
    /// much.
    pub gap_blocks: u32,
    /// `true` if the board had already locked before the command.
    pub already: bool,
}

/// Locks, if the board is not running already, and drives as configured.
pub fn run(args: &LockArgs, session: &mut Session) -> Result<Answer, LinkError> {
    // Cancels the orders of earlier commands.
    let configured =
        [Command::Gate(Gate::Scheduled), Command::Amplitude(None), Command::Detune(Hertz(0.0)), Command::Quadrature(None)];
    configured.into_iter().try_for_each(|command| session.client.order(command))?;
    let locked = acquire(args, session)?;
    let report = locked.report;
    let block_s = session.scale()?.block_s;
    let (time_ms, gap_ms) = (1e3 * block_s * f64::from(locked.blocks), 1e3 * block_s * f64::from(locked.gap_blocks));
    let answer = Answer::to("lock");
    let answer = if locked.already {
        answer.line(format!("already running, at {:.2} Hz", report.frequency.0))
    } else if report.locked {
        answer.line(format!(
            "locked at {:.2} Hz, {time_ms:.1} ms after the order (time of the first report; the one before came {gap_ms:.1} ms \
             earlier)",
            report.frequency.0
        ))
    } else {
        answer.line(format!("running at {:.2} Hz, {time_ms:.1} ms after the order; no resonance is tracked", report.frequency.0))
    };
    let answer = scan::alternatives(&report, session, circuit::quality(&report, circuit::in_words(&report, answer)))?
        .field("locked", report.locked)
        .field("frequency_hz", short(report.frequency.0))
        .field("resonance_hz", short(report.resonance.0))
        .field("lock_time_ms", time_ms)
        .field("lock_time_gap_ms", gap_ms);
    let answer = if report.mode == Mode::Run && report.envelope == 0.0 {
        answer.line(format!("the amplifier is {}", status::amplifier(&report)))
    } else {
        answer
    };
    Ok(answer.line(format!("driving by the configured schedule and amplitude; {}", session.end_of_drive())))
}

/// Orders a run and waits until it has locked.
pub fn acquire(args: &LockArgs, session: &mut Session) -> Result<Locked, LinkError> {
    let before = session.status()?;
    session.check(&before)?;
    session.begin_drive()?;
    if has_locked(&before) {
        return Ok(Locked { report: before, blocks: 0, gap_blocks: 0, already: true });
    }
    session.client.order(Command::Run)?;
    let mut last_block = before.block;
    let mut gap_blocks = 0;
    let mut stage = None;
    let live = session.live;
    let seen = session.watch(Duration::from_secs_f64(args.within), 1, |report| {
        gap_blocks = report.block.wrapping_sub(last_block);
        last_block = report.block;
        if stage != Some(report.mode) {
            stage = Some(report.mode);
            live.stage(&words::mode(report.mode));
        }
        (has_locked(report) || report.mode == Mode::Fault).then_some(*report)
    })?;
    let Some(report) = seen else {
        let now = session.status()?;
        return Err(LinkError::Failed(format!(
            "no lock within {} s: the board is in mode `{}`",
            args.within,
            words::mode(now.mode)
        )));
    };
    session.check(&report)?;
    Ok(Locked { report, blocks: report.block.wrapping_sub(before.block), gap_blocks, already: false })
}

/// Returns `true` for a run that has reached its frequency. A run at the fixed nominal frequency
/// has no transducer and tracks nothing.
fn has_locked(report: &Telemetry) -> bool {
    report.mode == Mode::Run && (report.locked || report.transducer.is_none())
}
