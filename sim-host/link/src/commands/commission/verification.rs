//! The proposed settings, put to the test: lock, a step of the amplitude, and a burst.

use std::time::Duration;

use firmware::board::command::Command;
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::fault::{Fault, Limit};
use firmware::seam::mode::Mode;
use firmware::seam::phasor::magnitude;
use firmware::seam::telemetry::Telemetry;
use firmware::seam::units::Hertz;

use super::board_settings::BoardSettings;
use super::limits::Bounds;
use super::probe;
use super::proposal::{Proposal, bound_hz, settle_s};
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// The smaller amplitude of the step.
const STEP: f64 = 0.7;
/// Least time that a change of a lock has to settle, s.
const SETTLE_S: f64 = 4e-3;
/// Part of the bound that the lock may be off by: the rest is for the identification. To it come so many standard deviations of the mean of the lock.
const AGREES: f64 = 0.9;
const SIGMAS: f64 = 3.0;
/// At the end of the pause of a burst less than this part of the current is left.
const SILENT: f64 = 0.2;
/// How long a measurement of the clamped branch, which takes up to 20 time constants, is waited for: settling times, and beyond, s.
const PROBES: f64 = 5.0;
const PATIENCE_S: f64 = 0.1;
/// Reports that are averaged.
const REPORTS: usize = 16;

/// What the test has measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Verified {
    /// Frequency of the lock, Hz.
    pub locked_hz: f64,
    /// Frequency at the smaller amplitude, Hz, and at full amplitude again, Hz.
    pub stepped_hz: (f64, f64),
    /// Frequency after the burst, Hz.
    pub after_burst_hz: f64,
    /// Peak motional current, A.
    pub motional_a: f64,
    /// Electrical power, W.
    pub power_w: f64,
    /// Time from the order to the lock, ms, as the host has seen it.
    pub lock_ms: f64,
}

/// Why the test has failed.
#[derive(Clone, Debug, PartialEq)]
pub struct Failed {
    /// Why, in words.
    pub why: String,
    /// The drive was too loud for limits or converters.
    pub too_loud: bool,
}

/// Locks with the proposed settings, and tries them; why they fail, if they do.
pub fn verify(
    proposal: &Proposal,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Result<Verified, Failed>, LinkError> {
    let mut settings = bounds.settings();
    settings.extend(proposal.settings());
    // Of two the later one counts: the limit with its margin, until it is done.
    settings.retain(|(name, _)| *name != "limits.current_a");
    settings.push(("limits.current_a", bounds.amperes as f32));
    board.apply(&settings, session)?;
    let tried = tried(proposal, session);
    probe::quiet(session)?;
    session.client.order(Command::Gate(Gate::Scheduled))?;
    tried
}

fn tried(proposal: &Proposal, session: &mut Session) -> Result<Result<Verified, Failed>, LinkError> {
    let it = &proposal.transducer;
    let hz = f64::from(it.series_resonance_hz);
    let settle_s = settle_s(it).max(SETTLE_S);
    let bound_hz = AGREES * bound_hz(it);
    session.client.order(Command::Gate(Gate::On))?;
    session.client.order(Command::Detune(Hertz(0.0)))?;
    session.client.order(Command::Amplitude(None))?;
    let began = session.client.now();
    if let Err(fault) = probe::run(session)? {
        return Ok(Err(named("the lock", fault)));
    }
    let mut verified = Verified { lock_ms: 1e3 * (session.client.now() - began).as_secs_f64(), ..Verified::default() };
    // An amplitude of volts, lower and back.
    let levels = [("the lock", 1.0), ("the step of the amplitude", STEP), ("the step back", 1.0)];
    let mut seen = [0.0; 3];
    let mut before = 1.0;
    for ((what, part), seen) in levels.into_iter().zip(&mut seen) {
        // In two steps, for a clamped capacitance draws a peak of current with each.
        for part in [0.5 * (before + part), part] {
            session.client.order(Command::Amplitude(Some(Amplitude::Volts((part * proposal.volts) as f32))))?;
        }
        before = part;
        let report = match steady(settle_s, session)? {
            Ok(report) => report,
            Err(fault) => return Ok(Err(named(what, fault))),
        };
        *seen = report.hz;
        if let Some(why) = apart(what, &report, hz, bound_hz) {
            return Ok(Err(because(why)));
        }
        if part == 1.0 {
            verified.motional_a = magnitude(report.report.motional_current).into();
            verified.power_w = crate::commands::status::power_w(&report.report).into();
        }
    }
    (verified.locked_hz, verified.stepped_hz) = (seen[0], (seen[1], seen[2]));
    session.client.order(Command::Gate(Gate::Off))?;
    let off = match probe::driven(settle_s, session)? {
        Ok(report) => report,
        Err(fault) => return Ok(Err(named("the pause of the burst", fault))),
    };
    if f64::from(magnitude(off.i)) > SILENT * proposal.amperes {
        return Ok(Err(because("current flows in the pause of the burst, while the gate is closed".into())));
    }
    session.client.order(Command::Gate(Gate::On))?;
    let report = match steady(settle_s, session)? {
        Ok(report) => report,
        Err(fault) => return Ok(Err(named("the burst", fault))),
    };
    verified.after_burst_hz = report.hz;
    if let Some(why) = apart("the burst", &report, hz, bound_hz) {
        return Ok(Err(because(why)));
    }
    Ok(Ok(verified))
}

fn named(what: &str, fault: Fault) -> Failed {
    let too_loud = matches!(fault, Fault::OverCurrent | Fault::SenseSaturated);
    Failed { why: format!("{what} ends in {}", words::fault(fault)), too_loud }
}

fn because(why: String) -> Failed {
    Failed { why, too_loud: false }
}

/// A steady lock.
struct Steady {
    /// Mean frequency, Hz, and its standard deviation, Hz.
    hz: f64,
    deviation_hz: f64,
    /// The last report.
    report: Telemetry,
}

/// The lock after it has settled.
fn steady(settle_s: f64, session: &mut Session) -> Result<Result<Steady, Fault>, LinkError> {
    if let Err(fault) = probe::driven(settle_s, session)? {
        return Ok(Err(fault));
    }
    let until = session.client.now() + Duration::from_secs_f64(PROBES * settle_s + PATIENCE_S);
    let mut frequencies = Vec::new();
    loop {
        let report = match probe::driven(0.0, session)? {
            Ok(report) => report,
            Err(fault) => return Ok(Err(fault)),
        };
        // Beside the resonance on purpose, until the board has measured the clamped branch; again and again where noise hides the branch.
        if report.limit == Some(Limit::Probing) {
            if session.client.now() <= until {
                continue;
            }
            frequencies.push(f64::from(report.resonance.0));
        } else {
            frequencies.push(f64::from(report.frequency.0));
        }
        if frequencies.len() >= REPORTS {
            let number = frequencies.len() as f64;
            let hz = frequencies.iter().sum::<f64>() / number;
            let squares: f64 = frequencies.iter().map(|at| (at - hz).powi(2)).sum();
            return Ok(Ok(Steady { hz, deviation_hz: squares.sqrt() / number, report }));
        }
    }
}

/// Why this is no lock to the identified resonance.
fn apart(what: &str, steady: &Steady, hz: f64, bound_hz: f64) -> Option<String> {
    let Steady { hz: locked_hz, deviation_hz, report } = steady;
    let bound_hz = bound_hz + SIGMAS * deviation_hz;
    if report.mode != Mode::Run || !report.locked {
        return Some(format!("after {what} the drive is not locked: the board is at `{}`", words::mode(report.mode)));
    }
    if let Some(limit @ (Limit::FrequencyWindow | Limit::NotTracking | Limit::LockUncertain)) = report.limit {
        return Some(format!("after {what}: {}", words::limit(limit)));
    }
    ((locked_hz - hz).abs() > bound_hz).then(|| {
        format!(
            "after {what} the drive is at {locked_hz:.2} Hz, and the scan has identified {hz:.2} Hz: {:.2} Hz apart, where {bound_hz:.2} Hz \
             are allowed",
            locked_hz - hz
        )
    })
}
