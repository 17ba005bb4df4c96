//! `burst`: opens and closes the gate of a running drive.
//!
//! With `--on` and `--off` times the host times each edge itself, with an error of a round trip and
//! of the scheduling of this machine. The times are measured by the board's block counter and
//! printed. For bursts with the precision of a sample the board has a schedule in its settings
//! (`burst.period_s`, `burst.duty`), which `--scheduled` follows.

use std::time::Duration;

use clap::Args;
use firmware::board::command::Command;
use firmware::seam::block::Gate;
use firmware::seam::mode::Mode;

use super::seconds;
use crate::answer::Answer;
use crate::link_error::LinkError;
use crate::session::Session;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct BurstArgs {
    /// Open the gate; with a time, close it after that time.
    #[arg(long, value_name = "S", num_args = 0..=1, default_missing_value = "forever", value_parser = span)]
    on: Option<Span>,
    /// Close the gate; with a time, the pause after each ON time.
    #[arg(long, value_name = "S", num_args = 0..=1, default_missing_value = "forever", value_parser = span)]
    off: Option<Span>,
    /// Number of bursts.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "on")]
    count: u32,
    /// Follow the configured schedule.
    #[arg(long, conflicts_with_all = ["on", "off", "brake"])]
    scheduled: bool,
    /// Close the gate, and drive against the residual vibration to stop it.
    #[arg(long, conflicts_with_all = ["on", "off"])]
    brake: bool,
}

/// Duration of a gate state.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Span {
    Forever,
    Seconds(f64),
}

fn span(text: &str) -> Result<Span, String> {
    if text == "forever" { Ok(Span::Forever) } else { seconds(text).map(Span::Seconds) }
}

/// Opens and closes the gate as given by the arguments.
pub fn run(args: &BurstArgs, session: &mut Session) -> Result<Answer, LinkError> {
    let report = session.status()?;
    session.check(&report)?;
    if report.mode != Mode::Run {
        return Err(LinkError::Failed("bursts need a running drive: send `lock` or `drive` first".into()));
    }
    let gate = |session: &mut Session, gate: Gate, line: &str, state: &str| {
        session.client.order(Command::Gate(gate))?;
        Ok(Answer::to("burst").line(line).field("gate", state))
    };
    match (args.on, args.off) {
        (Some(Span::Seconds(on)), off) => {
            let off = if let Some(Span::Seconds(off)) = off { off } else { on };
            let done = timed(on, off, args.count, session);
            if let Err(error) = &done {
                // An interrupted burst ends with a closed gate, too.
                if matches!(error, LinkError::Interrupted) {
                    session.client.ignore_ctrl_c();
                }
                let _ = session.client.order(Command::Gate(Gate::Off));
            }
            done
        }
        (Some(Span::Forever), None) => gate(session, Gate::On, "the gate is open", "on"),
        (None, Some(Span::Forever)) => gate(session, Gate::Off, "the gate is closed; the frequency is held", "off"),
        _ if args.scheduled => gate(session, Gate::Scheduled, "bursts by the configured schedule", "scheduled"),
        _ if args.brake => {
            gate(session, Gate::Brake, "the gate is closed, and the residual vibration is stopped by drive against it", "brake")
        }
        _ => Err(LinkError::Usage("expected --on S --off S --count N, --on, --off, --scheduled or --brake".into())),
    }
}

/// Plays bursts that the host times.
fn timed(on_s: f64, off_s: f64, count: u32, session: &mut Session) -> Result<Answer, LinkError> {
    let block_s = session.scale()?.block_s;
    let mut lengths_ms = Vec::new();
    let mut trip = Duration::ZERO;
    // The gate may have been open. It is closed so that the first burst is complete, too.
    edge(Gate::Off, session, &mut trip)?;
    pause(off_s, trip, session)?;
    for _ in 0..count {
        let opened = edge(Gate::On, session, &mut trip)?;
        pause(on_s, trip, session)?;
        let closed = edge(Gate::Off, session, &mut trip)?;
        lengths_ms.push(1e3 * block_s * f64::from(closed.wrapping_sub(opened)));
        pause(off_s, trip, session)?;
    }
    let report = session.status()?;
    session.check(&report)?;
    let (least, most) = lengths_ms.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &ms| (least.min(ms), most.max(ms)));
    Ok(Answer::to("burst")
        .line(format!(
            "{count} x {on_s} s ON, timed by this host: {least:.2} to {most:.2} ms each by the board's counter. For exact bursts \
             use a schedule (burst.period_s, burst.duty) and --scheduled"
        ))
        .line("the gate is closed; the frequency is held")
        .field("count", count)
        .field("on_s", on_s)
        .field("off_s", off_s)
        .field("shortest_on_ms", if count > 0 { least } else { 0.0 })
        .field("longest_on_ms", most)
        .field("gate", "off"))
}

/// Switches the gate, and returns the block of the next report. Measures the time of both commands.
fn edge(gate: Gate, session: &mut Session, trip: &mut Duration) -> Result<u32, LinkError> {
    let began = session.client.now();
    session.client.order(Command::Gate(gate))?;
    let report = session.status()?;
    session.check(&report)?;
    *trip = session.client.now() - began;
    Ok(report.block)
}

/// Waits for the rest of a span, after the time that the edge has taken.
fn pause(span_s: f64, trip: Duration, session: &mut Session) -> Result<(), LinkError> {
    session.wait(Duration::from_secs_f64(span_s).saturating_sub(trip))
}
