//! `lock`: scan, pull in, run; and when and where that was.

use std::time::Duration;

use clap::Args;
use firmware::board::command::Command;
use firmware::seam::block::Gate;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::units::Hertz;

use super::{circuit, seconds};
use crate::answer::{Answer, short};
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct LockArgs {
    /// How long it may take.
    #[arg(long, value_name = "S", default_value = "5", value_parser = seconds)]
    within: f64,
}

impl Default for LockArgs {
    fn default() -> Self {
        LockArgs { within: 5.0 }
    }
}

/// A lock, as the host has seen it.
pub struct Locked {
    /// The first report that says so.
    pub report: Telemetry,
    /// From the acknowledged order to that report, blocks.
    pub blocks: u32,
    /// From the report before to that one, blocks: what it may have been earlier.
    pub gap_blocks: u32,
    /// Whether the board had already locked when the command came.
    pub already: bool,
}

/// Locks, if the board does not run already.
pub fn run(args: &LockArgs, session: &mut Session) -> Result<Answer, LinkError> {
    // As configured, whatever an earlier command has ordered.
    let configured =
        [Command::Gate(Gate::Scheduled), Command::Amplitude(None), Command::Detune(Hertz(0.0)), Command::Quadrature(None)];
    configured.into_iter().try_for_each(|command| session.client.order(command))?;
    let locked = acquire(args, session)?;
    let report = locked.report;
    let block_s = session.scale()?.block_s;
    let (time_ms, gap_ms) = (1e3 * block_s * f64::from(locked.blocks), 1e3 * block_s * f64::from(locked.gap_blocks));
    let answer = Answer::to("lock");
    let answer = if locked.already {
        answer.line(format!("it runs already, at {:.2} Hz", report.frequency.0))
    } else if report.locked {
        answer.line(format!(
            "locked at {:.2} Hz, {time_ms:.1} ms after the order (seen by a report; the one before came {gap_ms:.1} ms earlier)",
            report.frequency.0
        ))
    } else {
        answer.line(format!("runs at {:.2} Hz, {time_ms:.1} ms after the order; nothing is tracked", report.frequency.0))
    };
    let answer = circuit::in_words(&report, answer)
        .field("locked", report.locked)
        .field("frequency_hz", short(report.frequency.0))
        .field("resonance_hz", short(report.resonance.0))
        .field("lock_time_ms", time_ms)
        .field("lock_time_gap_ms", gap_ms);
    Ok(answer.line(format!("it drives by the configured schedule and amplitude; {}", session.what_becomes_of_it())))
}

/// Orders a run and waits until it is one.
pub fn acquire(args: &LockArgs, session: &mut Session) -> Result<Locked, LinkError> {
    let before = session.status()?;
    session.check(&before)?;
    session.begins_to_drive()?;
    if is_it(&before) {
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
        (is_it(report) || report.mode == Mode::Fault).then_some(*report)
    })?;
    let Some(report) = seen else {
        let now = session.status()?;
        return Err(LinkError::Failed(format!("no lock within {} s: the board is at `{}`", args.within, words::mode(now.mode))));
    };
    session.check(&report)?;
    Ok(Locked { report, blocks: report.block.wrapping_sub(before.block), gap_blocks, already: false })
}

/// Whether this is a run that has come to its frequency. One that only holds the nominal frequency has no transducer, and tracks nothing.
fn is_it(report: &Telemetry) -> bool {
    report.mode == Mode::Run && (report.locked || report.transducer.is_none())
}
