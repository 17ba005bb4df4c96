//! `drive`: drives with an amplitude, optionally for a limited time.

use std::time::Duration;

use clap::Args;
use firmware::board::command::Command;
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::mode::Mode;
use firmware::seam::units::{Hertz, Turns};

use super::lock::{LockArgs, acquire};
use super::{amount, seconds, status};
use crate::answer::Answer;
use crate::link_error::LinkError;
use crate::parameter::{self, parameter};
use crate::session::Session;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct DriveArgs {
    /// Peak drive voltage; without it and --current, the configured amplitude.
    #[arg(long, value_name = "V", value_parser = amount, conflicts_with = "current")]
    volts: Option<f32>,
    /// Peak motional current to hold: tip velocity times force factor.
    #[arg(long, value_name = "A", value_parser = amount)]
    current: Option<f32>,
    /// Duration, after which the drive stops. By default it runs until `stop`, or until the client
    /// leaves.
    #[arg(long = "for", value_name = "S", value_parser = seconds)]
    time: Option<f64>,
    /// Frequency offset from the resonance.
    #[arg(long, value_name = "HZ", allow_hyphen_values = true)]
    detune: Option<f32>,
    /// Phase lead of lanes 1 and 3 over lanes 0 and 2: -0.25 to 0.25 turns.
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true)]
    quadrature: Option<f32>,
}

impl DriveArgs {
    /// Returns `true` if the drive continues after the command.
    pub fn goes_on(&self) -> bool {
        self.time.is_none()
    }
}

/// Drives with the amplitude, frequency offset and quadrature of the arguments.
pub fn run(args: &DriveArgs, session: &mut Session) -> Result<Answer, LinkError> {
    let amplitude = args.volts.map(Amplitude::Volts).or(args.current.map(Amplitude::MotionalCurrent));
    if let Some(volts) = args.volts {
        let limit_v = parameter::report(parameter("limits.voltage_v")?, &mut session.client)?.acts;
        if volts > limit_v {
            session.client.note(&format!(
                "warning: {volts} V exceeds the voltage limit of the board, {limit_v} V, at which it drives \
                 (`settings get limits.voltage_v`)"
            ));
        }
    }
    // Set before the start, so that the drive does not start with another amplitude.
    session.client.order(Command::Amplitude(amplitude))?;
    session.client.order(Command::Detune(Hertz(args.detune.unwrap_or(0.0))))?;
    session.client.order(Command::Quadrature(args.quadrature.map(Turns)))?;
    session.begin_drive()?;
    session.client.order(Command::Gate(Gate::On))?;
    if session.status()?.mode != Mode::Run {
        acquire(&LockArgs::default(), session)?;
    }
    let settled = session
        .watch(Duration::from_secs_f64(args.time.unwrap_or(0.1)), 0, |report| (report.mode == Mode::Fault).then_some(*report))?;
    let report = match settled {
        Some(report) => report,
        None => session.status()?,
    };
    session.check(&report)?;
    let answer = status::in_words(&report, Answer::to("drive"));
    Ok(match args.time {
        Some(time) => {
            session.client.order(Command::Idle)?;
            session.mark_silent();
            answer.line(format!("drove for {time} s; the drive is silent")).field("for_s", time)
        }
        // The caller watches a continuing drive until Ctrl-C, or leaves it on.
        None if session.ends_with_command => answer.line("the drive is on"),
        None => answer.line(format!("the drive is on; {}", session.end_of_drive())),
    })
}
