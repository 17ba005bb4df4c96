//! `fault`: shows the present fault, earlier faults and the cause of the board's start.

use clap::{Args, ValueEnum};
use firmware::board::command::{Command, Reply};
use firmware::board::fault_log::FaultReport;
use firmware::seam::phasor::magnitude;
use serde_json::{Value, json};

use crate::answer::{Answer, quantity, short};
use crate::client::unexpected;
use crate::link_error::LinkError;
use crate::parameter::{parameter, report};
use crate::session::Session;
use crate::words;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct FaultArgs {
    /// `clear` clears the fault (the drive stays silent); `log` lists the latest faults, newest
    /// first, and the cause of the start.
    #[arg(value_enum)]
    what: Option<What>,
}

impl FaultArgs {
    /// Returns `true` if the command clears the fault.
    pub fn clears(&self) -> bool {
        self.what == Some(What::Clear)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    Clear,
    Log,
}

/// Shows, lists or clears faults.
pub fn run(args: &FaultArgs, session: &mut Session) -> Result<Answer, LinkError> {
    match args.what {
        None => {
            let fault = session.status()?.fault;
            let answer = Answer::to("fault").line(fault.map_or_else(|| "no fault".into(), words::fault));
            Ok(answer.field("fault", fault.map_or(Value::Null, |fault| fault.code().into())))
        }
        Some(What::Clear) => clear(session),
        Some(What::Log) => log(session),
    }
}

fn clear(session: &mut Session) -> Result<Answer, LinkError> {
    session.client.order(Command::ClearFault)?;
    session.mark_silent();
    match session.status()?.fault {
        None => Ok(Answer::to("fault").line("no fault; the drive is silent").field("fault", Value::Null)),
        Some(fault) => Err(LinkError::Failed(format!("the fault came back at once: {}", words::fault(fault)))),
    }
}

fn log(session: &mut Session) -> Result<Answer, LinkError> {
    let newest = ask(0, session)?;
    let mut answer = Answer::to("fault")
        .line(format!("{} since the board was started: {}", faults(newest.count), start(&newest)))
        .field("count", newest.count)
        .field("last_start", start(&newest));
    let mut entries = Vec::new();
    let mut entry = newest.entry;
    while let Some(at) = entry {
        let name = at.fault.called();
        answer = answer.line(format!(
            "block {:>10}  {:2} {name}, at {} Hz, {} driven, {} and {} measured, in {}",
            at.block,
            at.fault.code(),
            at.frequency.0,
            quantity(at.drive.0.into(), "V"),
            quantity(magnitude(at.v).into(), "V"),
            quantity(magnitude(at.i).into(), "A"),
            words::mode(at.mode)
        ));
        entries.push(json!({
            "block": at.block, "fault": at.fault.code(), "name": name, "mode": words::mode(at.mode),
            "frequency_hz": short(at.frequency.0), "drive_v": short(at.drive.0), "voltage_v": short(magnitude(at.v)),
            "current_a": short(magnitude(at.i)),
        }));
        entry = match u8::try_from(entries.len()) {
            Ok(later) => ask(later, session)?.entry,
            Err(_) => None,
        };
    }
    Ok(answer.field("faults", entries))
}

fn ask(later: u8, session: &mut Session) -> Result<FaultReport, LinkError> {
    match session.client.ask(Command::Faults(later))? {
        Reply::Faults(report) => Ok(report),
        reply => Err(unexpected("fault log", &reply)),
    }
}

fn faults(count: u16) -> String {
    match count {
        0 => "no fault".into(),
        1 => "1 fault".into(),
        count => format!("{count} faults"),
    }
}

fn start(report: &FaultReport) -> String {
    words::start(&report.last_run)
}

/// Requests the cause of the board's start, as text.
pub fn start_in_words(session: &mut Session) -> Result<String, LinkError> {
    Ok(start(&ask(0, session)?))
}

/// Describes the response of the board to a lost host while it drives.
pub fn host_timeout_in_words(session: &mut Session) -> Result<String, LinkError> {
    let timeout_s = report(parameter("link.patience_s")?, &mut session.client)?.acts;
    Ok(if timeout_s == 0.0 {
        "it continues without a host".into()
    } else {
        format!("without a host the board stops it after {timeout_s} s, unless set otherwise (--host-timeout, --stay)")
    })
}
