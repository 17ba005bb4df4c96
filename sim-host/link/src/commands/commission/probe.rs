//! Steps of a commissioning at the board. They return a fault as a result instead of an error.

use std::time::Duration;

use firmware::board::command::{Command, Reply, ResonanceReport};
use firmware::board::fault_log::FaultEntry;
use firmware::seam::block::Amplitude;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::transducer::Transducer;

use crate::client::unexpected;
use crate::commands::scan::{self, is_over};
use crate::link_error::LinkError;
use crate::session::Session;

/// Maximum duration of a scan or a lock.
const TIMEOUT: Duration = Duration::from_secs(10);

/// Levels by which a drive ends, relative to its voltage. Each step makes a clamped capacitance
/// draw a current peak.
const FADE_LEVELS_REL: [f32; 6] = [0.85, 0.7, 0.55, 0.4, 0.25, 0.1];

/// Result of a scan.
#[derive(Clone, Debug, Default)]
pub struct Scanned {
    /// Fault because of which no resonance was chosen.
    pub fault: Option<Fault>,
    /// Resonances, found even if none was chosen.
    pub found: ResonanceReport,
    /// Circuit of the chosen resonance.
    pub transducer: Option<Transducer>,
}

/// Returns `true` for a fault of the self-test, which rejects a load with a resonance at its tone.
pub fn is_of_self_test(fault: Fault) -> bool {
    matches!(fault, Fault::SenseSwapped | Fault::LoadShorted | Fault::LoadOpen | Fault::SensorImplausible)
}

/// Scans the configured window. Afterwards the drive is silent and the board has no fault.
pub fn scan(session: &mut Session) -> Result<Scanned, LinkError> {
    let before = session.status()?;
    session.begin_drive()?;
    session.client.order(Command::Scan)?;
    let ended = session.watch(TIMEOUT, 4, |report| is_over(report, &before).then_some(*report))?;
    let report = ended.ok_or_else(|| LinkError::Failed(format!("the scan has not ended within {} s", TIMEOUT.as_secs())))?;
    let found = scan::ask(session)?;
    let fault = if report.mode == Mode::Fault { report.fault } else { None };
    quiet(session)?;
    Ok(Scanned { fault, found, transducer: report.transducer.filter(|_| fault.is_none()) })
}

/// Orders a run, and waits until the board drives, or until a fault has ended it.
pub fn run(session: &mut Session) -> Result<Result<Telemetry, Fault>, LinkError> {
    session.begin_drive()?;
    session.client.order(Command::Run)?;
    let ended = session.watch(TIMEOUT, 4, |report| {
        let runs = report.mode == Mode::Run && (report.locked || report.transducer.is_none());
        (runs || report.mode == Mode::Fault).then_some(*report)
    })?;
    let report = ended.ok_or_else(|| LinkError::Failed(format!("no lock within {} s", TIMEOUT.as_secs())))?;
    Ok(match report.fault {
        Some(fault) if report.mode == Mode::Fault => Err(fault),
        _ => Ok(report),
    })
}

/// Waits during a drive, and returns the report at the end, or the fault that has ended the drive.
pub fn driven(time_s: f64, session: &mut Session) -> Result<Result<Telemetry, Fault>, LinkError> {
    session.wait(Duration::from_secs_f64(time_s))?;
    let report = session.status()?;
    Ok(match report.fault {
        Some(fault) if report.mode == Mode::Fault => Err(fault),
        _ => Ok(report),
    })
}

/// Stops the drive and clears the fault. The voltage is reduced in steps, because a clamped
/// capacitance that is switched off at full voltage draws a current peak. The ordered amplitude is
/// cancelled.
pub fn quiet(session: &mut Session) -> Result<(), LinkError> {
    let report = session.status()?;
    if report.mode == Mode::Run {
        for part in FADE_LEVELS_REL {
            session.client.order(Command::Amplitude(Some(Amplitude::Volts(part * report.drive.0))))?;
        }
    }
    session.client.order(Command::Idle)?;
    session.client.order(Command::ClearFault)?;
    session.client.order(Command::Amplitude(None))?;
    session.mark_silent();
    Ok(())
}

/// Requests the latest fault of the log, with the measured values of its block.
pub fn latest_fault(session: &mut Session) -> Result<Option<FaultEntry>, LinkError> {
    match session.client.ask(Command::Faults(0))? {
        Reply::Faults(report) => Ok(report.entry),
        reply => Err(unexpected("fault log", &reply)),
    }
}
