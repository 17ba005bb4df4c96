//! Test of the proposed settings: a lock, a step of the amplitude, and a burst.

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
use super::proposal::{Proposal, bound_hz, permitted_hz, settle_s};
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// Smaller amplitude of the step, relative to the larger one.
const STEP_REL: f64 = 0.7;
/// Smallest and largest number of steps in which the amplitude changes.
const MIN_STEPS: f64 = 2.0;
const MAX_STEPS: f64 = 50.0;
/// Settling time of a lock, relative to that of a fixed frequency: the observer follows the
/// ring-up.
const SETTLE_REL: f64 = 0.5;
/// Minimum settling time of a lock after a change, s.
const MIN_SETTLE_S: f64 = 4e-3;
/// Number of standard deviations of the mean frequency that is added to the largest error.
const ERROR_SIGMAS: f64 = 3.0;
/// Largest current at the end of the pause of a burst, relative to the driven current.
const MAX_PAUSE_CURRENT_REL: f64 = 0.2;
/// Time to wait for a measurement of the clamped branch, settling times. The measurement takes up
/// to 20 time constants.
const PROBE_SETTLING_TIMES: f64 = 10.0;
/// Additional time to wait for it, s.
const PROBE_EXTRA_S: f64 = 0.1;
/// Additional time to wait for a lock that the board seeks again, s.
const RELOCK_S: f64 = 1.0;
/// Smallest number of averaged reports.
const AVERAGED_REPORTS: usize = 16;
/// Largest error of their mean, relative to the bound.
const MEAN_ERROR_REL: f64 = 0.1;

/// Results of the test.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Verified {
    /// Frequency of the lock, Hz.
    pub locked_hz: f64,
    /// Frequencies at the smaller amplitude and at full amplitude afterwards, Hz.
    pub stepped_hz: (f64, f64),
    /// Frequency after the burst, Hz.
    pub after_burst_hz: f64,
    /// Peak motional current, A.
    pub motional_a: f64,
    /// Electrical power, W.
    pub power_w: f64,
    /// Time from the order to the lock, ms, as observed by the host.
    pub lock_ms: f64,
}

/// Failure of the test.
#[derive(Clone, Debug, PartialEq)]
pub struct TestFailure {
    /// Reason, as text.
    pub why: String,
    /// `true` if the voltage was too high for limits or converters.
    pub voltage_too_high: bool,
}

/// Locks with the proposed settings and tests them. Returns the reason if they fail.
pub fn verify(
    proposal: &Proposal,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Result<Verified, TestFailure>, LinkError> {
    let mut settings = bounds.settings();
    settings.extend(proposal.settings());
    // The limit with its margin applies until the commissioning is finished.
    settings.retain(|(name, _)| *name != "limits.current_a");
    settings.push(("limits.current_a", bounds.amperes as f32));
    board.apply(&settings, session)?;
    let tried = run_test(proposal, bounds, session);
    probe::quiet(session)?;
    session.client.order(Command::Gate(Gate::Scheduled))?;
    tried
}

fn run_test(proposal: &Proposal, bounds: &Bounds, session: &mut Session) -> Result<Result<Verified, TestFailure>, LinkError> {
    let it = &proposal.transducer;
    let hz = f64::from(it.series_resonance_hz);
    let settle_s = (SETTLE_REL * settle_s(it)).max(MIN_SETTLE_S);
    let (bound_hz, permitted_hz) = (bound_hz(it), permitted_hz(it));
    session.client.order(Command::Gate(Gate::On))?;
    session.client.order(Command::Detune(Hertz(0.0)))?;
    session.client.order(Command::Amplitude(None))?;
    let began = session.client.now();
    if let Err(fault) = probe::run(session)? {
        return Ok(Err(ended_by("the lock", fault)));
    }
    let mut verified = Verified { lock_ms: 1e3 * (session.client.now() - began).as_secs_f64(), ..Verified::default() };
    // The amplitude as a voltage, reduced and restored.
    let levels = [("the lock", 1.0), ("the step of the amplitude", STEP_REL), ("the step back", 1.0)];
    let mut seen = [0.0; 3];
    let mut before = 1.0;
    for ((what, part), seen) in levels.into_iter().zip(&mut seen) {
        // Each step charges the clamped capacitance, within a sample in the worst case.
        let peak_a = f64::from(it.c0_f) * (part - before).abs() * proposal.volts / bounds.sample_s;
        let steps = peak_a / (bounds.amperes - proposal.amperes).max(f64::MIN_POSITIVE);
        let steps = if steps < MAX_STEPS { steps.ceil().max(MIN_STEPS) } else { MAX_STEPS } as u32;
        for step in 1..=steps {
            let part = before + (part - before) * f64::from(step) / f64::from(steps);
            session.client.order(Command::Amplitude(Some(Amplitude::Volts((part * proposal.volts) as f32))))?;
        }
        before = part;
        let report = match steady(settle_s, bound_hz, session)? {
            Ok(report) => report,
            Err(fault) => return Ok(Err(ended_by(what, fault))),
        };
        *seen = report.hz;
        if let Some(why) = lock_error(what, &report, hz, permitted_hz) {
            return Ok(Err(failure(why)));
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
        Err(fault) => return Ok(Err(ended_by("the pause of the burst", fault))),
    };
    if f64::from(magnitude(off.i)) > MAX_PAUSE_CURRENT_REL * proposal.amperes {
        return Ok(Err(failure("current flows in the pause of the burst, while the gate is closed".into())));
    }
    session.client.order(Command::Gate(Gate::On))?;
    let report = match steady(settle_s, bound_hz, session)? {
        Ok(report) => report,
        Err(fault) => return Ok(Err(ended_by("the burst", fault))),
    };
    verified.after_burst_hz = report.hz;
    if let Some(why) = lock_error("the burst", &report, hz, permitted_hz) {
        return Ok(Err(failure(why)));
    }
    Ok(Ok(verified))
}

fn ended_by(what: &str, fault: Fault) -> TestFailure {
    let voltage_too_high = matches!(fault, Fault::OverCurrent | Fault::SenseSaturated);
    TestFailure { why: format!("{what} ends with {}", words::fault(fault)), voltage_too_high }
}

fn failure(why: String) -> TestFailure {
    TestFailure { why, voltage_too_high: false }
}

/// Settled lock.
struct Steady {
    /// Mean frequency, Hz.
    hz: f64,
    /// Standard deviation of the mean frequency, Hz.
    deviation_hz: f64,
    /// The last report.
    report: Telemetry,
}

/// Waits until the lock has settled, and averages its frequency, until the mean is known well
/// compared with `bound_hz`.
fn steady(settle_s: f64, bound_hz: f64, session: &mut Session) -> Result<Result<Steady, Fault>, LinkError> {
    if let Err(fault) = probe::driven(settle_s, session)? {
        return Ok(Err(fault));
    }
    let began = session.client.now();
    let is_over = |s: f64, session: &Session| session.client.now() > began + Duration::from_secs_f64(s);
    let probe_s = PROBE_SETTLING_TIMES * settle_s + PROBE_EXTRA_S;
    let mut frequencies = Vec::new();
    loop {
        let report = match probe::driven(0.0, session)? {
            Ok(report) => report,
            Err(fault) => return Ok(Err(fault)),
        };
        if !is_locked(&report) {
            // The tones of another scan are not the frequency of a lock.
            frequencies.clear();
            if is_over(probe_s + RELOCK_S, session) {
                return Ok(Ok(Steady { hz: f64::NAN, deviation_hz: 0.0, report }));
            }
            continue;
        }
        // The drive is off resonance while the board measures the clamped branch. It repeats this
        // if noise hides the branch.
        if report.limit == Some(Limit::Probing) {
            if !is_over(probe_s, session) {
                continue;
            }
            frequencies.push(f64::from(report.resonance.0));
        } else {
            frequencies.push(f64::from(report.frequency.0));
        }
        let number = frequencies.len() as f64;
        let hz = frequencies.iter().sum::<f64>() / number;
        let squares: f64 = frequencies.iter().map(|at| (at - hz).powi(2)).sum();
        let deviation_hz = squares.sqrt() / number;
        let is_known = ERROR_SIGMAS * deviation_hz <= MEAN_ERROR_REL * bound_hz || is_over(probe_s, session);
        if frequencies.len() >= AVERAGED_REPORTS && is_known {
            return Ok(Ok(Steady { hz, deviation_hz, report }));
        }
    }
}

/// Returns `true` if the board reports a lock.
fn is_locked(report: &Telemetry) -> bool {
    report.mode == Mode::Run && report.locked
}

/// Returns the reason if the drive is not locked to the identified resonance.
fn lock_error(what: &str, steady: &Steady, hz: f64, permitted_hz: f64) -> Option<String> {
    let Steady { hz: locked_hz, deviation_hz, report } = steady;
    let permitted_hz = permitted_hz + ERROR_SIGMAS * deviation_hz;
    if !is_locked(report) {
        return Some(format!("after {what} the drive is not locked: the board is in mode `{}`", words::mode(report.mode)));
    }
    if let Some(limit @ (Limit::FrequencyWindow | Limit::NotTracking | Limit::LockUncertain)) = report.limit {
        return Some(format!("after {what}: {}", words::limit(limit)));
    }
    ((locked_hz - hz).abs() > permitted_hz).then(|| {
        format!(
            "after {what} the drive is at {locked_hz:.2} Hz, but the scan has identified {hz:.2} Hz. The difference of {:.2} Hz \
             exceeds the permitted {permitted_hz:.2} Hz",
            locked_hz - hz
        )
    })
}
