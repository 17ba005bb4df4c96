//! `drive`: drives with an amplitude, optionally for a limited time.

use std::time::Duration;

use clap::Args;
use firmware::board::command::Command;
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::mode::Mode;
use firmware::seam::units::{Hertz, Turns};

use super::lock::{LockArgs, acquire};
use super::{amperes, seconds, status, volts};
use crate::answer::Answer;
use crate::link_error::LinkError;
use crate::number_with_unit::{number_in, split};
use crate::parameter::{self, parameter};
use crate::session::Session;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct DriveArgs {
    /// Peak drive voltage, such as `2V`, or peak motional current to hold, such as `0.3A`; the same
    /// as --volts and --current.
    #[arg(value_name = "AMPLITUDE", value_parser = amplitude, conflicts_with_all = ["volts", "current"])]
    amplitude: Option<Amplitude>,
    /// Peak drive voltage; without it and --current, the configured amplitude.
    #[arg(long, value_name = "V", value_parser = volts, conflicts_with = "current")]
    volts: Option<f32>,
    /// Peak motional current to hold: tip velocity times force factor.
    #[arg(long, value_name = "A", value_parser = amperes)]
    current: Option<f32>,
    /// Duration, after which the drive stops. By default it runs until `stop`, or until the client
    /// leaves.
    #[arg(long = "for", value_name = "S", value_parser = seconds)]
    time: Option<f64>,
    /// Frequency offset from the resonance.
    #[arg(long, value_name = "HZ", allow_hyphen_values = true, value_parser = offset)]
    detune: Option<f32>,
    /// Phase lead of lanes 1 and 3 over lanes 0 and 2: -0.25 to 0.25 turns.
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true, value_parser = turns)]
    quadrature: Option<f32>,
}

impl DriveArgs {
    /// Returns `true` if the drive continues after the command.
    pub fn goes_on(&self) -> bool {
        self.time.is_none()
    }
}

/// Reads an amplitude, whose unit selects the quantity.
fn amplitude(text: &str) -> Result<Amplitude, String> {
    let (number, unit) = split(text).ok_or("expected an amplitude with its unit, such as 2V, 500mV or 0.3A")?;
    if unit.is_empty() {
        return Err(format!(
            "the unit is missing: type `drive {number}V` for a voltage, or `drive {number}A` for a motional current"
        ));
    }
    match volts(text) {
        Ok(volts) => Ok(Amplitude::Volts(volts)),
        Err(why) => amperes(text).map(Amplitude::MotionalCurrent).map_err(|_| why),
    }
}

fn offset(text: &str) -> Result<f32, String> {
    number_in(text, "Hz").map(|hertz| hertz as f32)
}

fn turns(text: &str) -> Result<f32, String> {
    number_in(text, "turns").map(|turns| turns as f32)
}

/// Drives with the amplitude, frequency offset and quadrature of the arguments.
pub fn run(args: &DriveArgs, session: &mut Session) -> Result<Answer, LinkError> {
    let named = args.volts.map(Amplitude::Volts).or(args.current.map(Amplitude::MotionalCurrent));
    let amplitude = args.amplitude.or(named);
    if let Some(Amplitude::Volts(volts)) = amplitude {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_an_amplitude_selects_the_quantity() {
        assert_eq!(amplitude("2V"), Ok(Amplitude::Volts(2.0)));
        assert_eq!(amplitude("500 mV"), Ok(Amplitude::Volts(0.5)));
        assert_eq!(amplitude("300mA"), Ok(Amplitude::MotionalCurrent(0.3)));
        assert!(amplitude("2").unwrap_err().contains("type `drive 2V`"));
        assert!(amplitude("2s").unwrap_err().contains("expected volts"));
        assert!(amplitude("-2V").is_err() && amplitude("hard").unwrap_err().contains("with its unit"));
    }
}
