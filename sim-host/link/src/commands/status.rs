//! `status`: shows the present state of the board.

use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::phasor::{Phasor, argument, magnitude};
use firmware::seam::telemetry::Telemetry;
use serde_json::Value;

use super::hardware;
use super::scan;
use super::update::ask_keys;
use crate::answer::{Answer, quantity, short};
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// Requests the present state of the board.
pub fn run(session: &mut Session) -> Result<Answer, LinkError> {
    let report = session.status()?;
    let hardware = hardware::ask(session)?;
    let mut answer = scan::alternatives(&report, session, in_words(&report, Answer::to("status")))?;
    if hardware.is_some_and(|hardware| hardware.muted) {
        answer = answer.line("           muted: the enable stays low, also during a drive (`reset` ends this)");
    }
    ask_keys(hardware.into_iter().fold(answer, hardware::in_words), session)
}

/// Adds a report to an answer, as text and fields.
pub fn in_words(report: &Telemetry, answer: Answer) -> Answer {
    let answer = answer
        .line(format!("mode       {}{}", words::mode(report.mode), if report.locked { ", locked" } else { "" }))
        .line(format!("frequency  {:.2} Hz; resonance estimated at {:.2} Hz", report.frequency.0, report.resonance.0))
        .line(format!("drive      {} peak, envelope {:.2}", quantity(report.drive.0.into(), "V"), report.envelope))
        .line(format!("amplifier  {}", amplifier(report)))
        .line(format!(
            "measured   {}, {} at {:+.1} degrees; motional {}, {} of real power",
            quantity(magnitude(report.v).into(), "V"),
            quantity(magnitude(report.i).into(), "A"),
            lead_degrees(report),
            quantity(magnitude(report.motional_current).into(), "A"),
            quantity(power_w(report).into(), "W"),
        ));
    let answer = match report.friction.and_then(|estimate| estimate.force_ratio) {
        Some(ratio) => {
            answer.line(format!("friction   {ratio:.3} of the friction without drive")).field("friction_ratio", short(ratio))
        }
        None => answer,
    };
    let answer = report.limit.into_iter().fold(answer, |answer, limit| answer.line(words::limit(limit)));
    let answer = report.fault.into_iter().fold(answer, |answer, fault| answer.line(words::fault(fault)));
    fields(report, answer)
}

/// Describes the enable of the amplifier, which the background task derives from the mode, and the
/// gate of the drive.
pub fn amplifier(report: &Telemetry) -> &'static str {
    match report.mode {
        Mode::Idle => "off: nothing is ordered (`lock` and `drive` start the drive)",
        Mode::Fault => "off, until the fault is cleared (`fault clear`) and a drive is ordered",
        Mode::Run if report.envelope == 0.0 => {
            "on, but the gate is closed, by the burst schedule or by `burst --off`: nothing is driven now (`burst --on` opens it)"
        }
        _ => "on",
    }
}

/// Adds the numbers of a report to an answer.
pub fn fields(report: &Telemetry, answer: Answer) -> Answer {
    answer
        .field("block", report.block)
        .field("mode", words::mode(report.mode))
        .field("locked", report.locked)
        .field("frequency_hz", short(report.frequency.0))
        .field("resonance_hz", short(report.resonance.0))
        .field("drive_v", short(report.drive.0))
        .field("envelope", short(report.envelope))
        .field("enabled", !matches!(report.mode, Mode::Idle | Mode::Fault))
        .field("voltage_v", short(magnitude(report.v)))
        .field("current_a", short(magnitude(report.i)))
        .field("current_lead_degrees", short(lead_degrees(report)))
        .field("motional_current_a", short(magnitude(report.motional_current)))
        .field("power_w", short(power_w(report)))
        .field("limit", report.limit.map_or(Value::Null, |limit| u8::from(limit).into()))
        .field("fault", report.fault.map_or(Value::Null, |fault: Fault| fault.code().into()))
}

/// Returns the phase by which the current leads the voltage, degrees.
fn lead_degrees(report: &Telemetry) -> f32 {
    argument(report.i * report.v.conj()).degrees()
}

/// Returns the mean electrical power, W: half the real part of `V* I` at peak values.
pub fn power_w(report: &Telemetry) -> f32 {
    let product: Phasor = report.v.conj() * report.i;
    0.5 * product.re
}
