//! `monitor`: shows periodic reports of the board.

use std::time::Duration;

use clap::Args;
use firmware::seam::mode::Mode;
use firmware::seam::phasor::magnitude;
use firmware::seam::telemetry::Telemetry;
use serde_json::Value;

use super::status::{fields, power_w};
use super::{fault, seconds};
use crate::answer::{Answer, quantity};
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct MonitorArgs {
    /// Time between reports.
    #[arg(long, value_name = "S", default_value = "0.5", value_parser = seconds)]
    every: f64,
    /// Duration; by default until Ctrl-C.
    #[arg(long = "for", value_name = "S", value_parser = seconds)]
    time: Option<f64>,
}

impl Default for MonitorArgs {
    fn default() -> Self {
        MonitorArgs { every: 0.5, time: None }
    }
}

impl MonitorArgs {
    /// Returns `true` if only Ctrl-C ends it.
    pub fn is_endless(&self) -> bool {
        self.time.is_none()
    }
}

/// Shows reports until the time is over. The answer describes the state of the drive at the end.
pub fn run(args: &MonitorArgs, session: &mut Session) -> Result<Answer, LinkError> {
    let began = session.client.now();
    let until = args.time.map(|time| began + Duration::from_secs_f64(time));
    let mut reports = 0_u32;
    let mut first = None;
    let last = loop {
        let report = session.status()?;
        let first = *first.get_or_insert(report.block);
        reports += 1;
        session.live.report(&line(&report), || {
            Value::Object(fields(&report, Answer::default().field("command", "monitor").field("reports", reports)).fields)
        });
        let left = until.map(|until| until.saturating_sub(session.client.now()));
        if left.is_some_and(|left| left.is_zero()) {
            break (report, report.block.wrapping_sub(first));
        }
        session.wait(left.unwrap_or(Duration::MAX).min(Duration::from_secs_f64(args.every.max(1e-3))))?;
    };
    let (report, blocks) = last;
    let answer = fields(&report, Answer::to("monitor")).field("reports", reports).field("blocks", blocks);
    Ok(answer.line(format!("{reports} reports; {}", what_it_does(&report, session)?)))
}

/// Describes the state of the drive, and the effect of a lost host on it.
pub fn what_it_does(report: &Telemetry, session: &mut Session) -> Result<String, LinkError> {
    Ok(match report.mode {
        Mode::Idle => "the drive is silent".into(),
        Mode::Fault => report
            .fault
            .map_or_else(|| "the drive is muted".into(), |fault| format!("the drive is muted: {}", words::fault(fault))),
        mode => format!("the drive is on ({}); {}", words::mode(mode), fault::host_timeout_in_words(session)?),
    })
}

/// Formats a report as one line.
pub fn line(report: &Telemetry) -> String {
    let mut line = format!(
        "{:10} {:>10.2} Hz {:>10} {:>10} motional {:>10} {:>10} {:+6.2} deg{}",
        words::mode(report.mode),
        report.frequency.0,
        quantity(magnitude(report.v).into(), "V"),
        quantity(magnitude(report.i).into(), "A"),
        quantity(magnitude(report.motional_current).into(), "A"),
        quantity(power_w(report).into(), "W"),
        report.phase.degrees(),
        if report.locked { " locked" } else { "" },
    );
    if let Some(limit) = report.limit {
        line += &format!(" | {}", words::limit(limit));
    }
    if let Some(fault) = report.fault {
        line += &format!(" | fault {}, {}", fault.code(), fault.called());
    }
    line
}
