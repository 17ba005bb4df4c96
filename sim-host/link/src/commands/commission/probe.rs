//! What the board is ordered to do on the way, with a fault as a result and not as an error.

use std::time::Duration;

use firmware::board::command::{Command, Reply, ResonanceReport};
use firmware::board::fault_log::FaultEntry;
use firmware::seam::block::Amplitude;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::transducer::Transducer;

use crate::client::unexpected;
use crate::commands::scan::is_over;
use crate::link_error::LinkError;
use crate::session::Session;

/// Longest that a scan or a lock may take.
const LONGEST: Duration = Duration::from_secs(10);

/// Parts of its voltage by which a drive ends: each step makes a clamped capacitance draw a peak of current.
const FADING: [f32; 6] = [0.85, 0.7, 0.55, 0.4, 0.25, 0.1];

/// Result of a scan.
#[derive(Clone, Debug, Default)]
pub struct Scanned {
    /// Why it has chosen none.
    pub fault: Option<Fault>,
    /// What it has found all the same.
    pub found: ResonanceReport,
    /// The circuit of the chosen resonance.
    pub transducer: Option<Transducer>,
}

/// Whether a fault is of the self-test, which takes a load for broken whose resonance its tone meets.
pub fn is_of_self_test(fault: Fault) -> bool {
    matches!(fault, Fault::SenseSwapped | Fault::LoadShorted | Fault::LoadOpen | Fault::SensorImplausible)
}

/// Scans the configured window; the board is silent afterwards and has no fault.
pub fn scan(session: &mut Session) -> Result<Scanned, LinkError> {
    let before = session.status()?;
    session.begins_to_drive()?;
    session.client.order(Command::Scan)?;
    let ended = session.watch(LONGEST, 4, |report| is_over(report, &before).then_some(*report))?;
    let report = ended.ok_or_else(|| LinkError::Failed(format!("the scan has not ended within {} s", LONGEST.as_secs())))?;
    let found = match session.client.ask(Command::Resonances)? {
        Reply::Resonances(found) => found,
        reply => return Err(unexpected("scan", &reply)),
    };
    let fault = if report.mode == Mode::Fault { report.fault } else { None };
    quiet(session)?;
    Ok(Scanned { fault, found, transducer: report.transducer.filter(|_| fault.is_none()) })
}

/// Orders a run, and waits until it drives, or until a fault has ended it.
pub fn run(session: &mut Session) -> Result<Result<Telemetry, Fault>, LinkError> {
    session.begins_to_drive()?;
    session.client.order(Command::Run)?;
    let ended = session.watch(LONGEST, 4, |report| {
        let runs = report.mode == Mode::Run && (report.locked || report.transducer.is_none());
        (runs || report.mode == Mode::Fault).then_some(*report)
    })?;
    let report = ended.ok_or_else(|| LinkError::Failed(format!("no lock within {} s", LONGEST.as_secs())))?;
    Ok(match report.fault {
        Some(fault) if report.mode == Mode::Fault => Err(fault),
        _ => Ok(report),
    })
}

/// Waits while a drive runs, and gives the report at the end, or the fault that has ended it.
pub fn driven(time_s: f64, session: &mut Session) -> Result<Result<Telemetry, Fault>, LinkError> {
    session.wait(Duration::from_secs_f64(time_s))?;
    let report = session.status()?;
    Ok(match report.fault {
        Some(fault) if report.mode == Mode::Fault => Err(fault),
        _ => Ok(report),
    })
}

/// Silence, and no fault. A drive becomes quieter step by step before it ends: a clamped capacitance that is cut off at full voltage draws a peak of current.
/// What was ordered as its amplitude is undone.
pub fn quiet(session: &mut Session) -> Result<(), LinkError> {
    let report = session.status()?;
    if report.mode == Mode::Run {
        for part in FADING {
            session.client.order(Command::Amplitude(Some(Amplitude::Volts(part * report.drive.0))))?;
        }
    }
    session.client.order(Command::Idle)?;
    session.client.order(Command::ClearFault)?;
    session.client.order(Command::Amplitude(None))?;
    session.is_silent();
    Ok(())
}

/// The latest fault of the log, with what was measured in its block.
pub fn latest_fault(session: &mut Session) -> Result<Option<FaultEntry>, LinkError> {
    match session.client.ask(Command::Faults(0))? {
        Reply::Faults(report) => Ok(report.entry),
        reply => Err(unexpected("fault log", &reply)),
    }
}
