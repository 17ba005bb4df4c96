//! Measurement of the admittance circle of a resonance, from which settings are proposed.
//!
//! The board holds a frequency without tracking (`tracking.mode = off`), so that the frequency of a
//! point does not depend on a tracker. A point is measured after it has settled. A sharp resonance
//! settles too slowly for that: its limit follows from two values on the way,
//!
//! ```text
//! Y = (Y2 - r Y1) / (1 - r),   r = exp(-(1 / tau + j 2 pi (f - fs)) (t2 - t1))
//! ```

use std::f64::consts::TAU;

use firmware::board::command::Command;
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::fault::{Fault, Limit};
use firmware::seam::phasor::{Phasor, magnitude};
use firmware::seam::transducer::Transducer;
use firmware::seam::units::Hertz;
use realfft::num_complex::Complex64;

use super::board_settings::BoardSettings;
use super::fit::Point;
use super::limits::Bounds;
use super::probe;
use super::proposal::{Proposal, REDUCTION, USED_CURRENT_REL, settle_s, width_hz};
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// Number of points of a circle.
const POINTS_WIDE: u32 = 17;
/// Number of points of a circle with a narrow bandwidth, for which the bound of 1 Hz is wide.
const POINTS_NARROW: u32 = 9;
/// Bandwidth below which the smaller number is used, Hz.
const NARROW_BANDWIDTH_HZ: f64 = 40.0;
/// Largest offset of a point to either side, bandwidths.
const REACH_BANDWIDTHS: f64 = 2.5;
/// Largest half-width of the window, relative to its middle.
const MAX_WINDOW_REL: f64 = 0.2;
/// Part of the window that is used.
const USED_WINDOW_REL: f64 = 0.95;
/// Offsets of the middle of the window from the resonance, relative, tried if the tone of the
/// board's self-test meets a resonance.
const WINDOW_SHIFTS_REL: [f64; 3] = [0.03, -0.03, 0.06];
/// Standard deviation of a block's voltage and current, codes of the converter.
pub const NOISE_CODES: f64 = 0.4;
/// Error of a fitted circuit without noise, relative to the conductance, due to the images of the
/// DAC.
const MODEL_ERROR_REL: f64 = 5e-4;
/// Change of the admittance from one point to the next, relative to the conductance. A fraction of
/// it has not settled.
const POINT_CHANGE_REL: f64 = 0.3;
/// Time constant above which the limit of a point is predicted, s.
const PREDICTED_TIME_CONSTANT_S: f64 = 5e-3;
/// Times of the two values after a change, time constants.
const PREDICTED_AT: [f64; 2] = [3.5, 4.5];
/// Part of the transient at the second value that a wrong Q or frequency leaves.
const UNPREDICTED_REL: f64 = 0.1;
/// Largest ratio of the voltages of two successive levels.
const MAX_LEVEL_RATIO: f64 = 4.0;
/// Smallest ratio for which another level is worthwhile.
const MIN_LEVEL_RATIO: f64 = 1.1;

/// Measured admittance circle.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Admittance in order of frequency.
    pub points: Vec<Point>,
    /// Peak voltage of the drive, V.
    pub volts: f64,
    /// Largest peak current, A.
    pub amperes: f64,
}

/// Measures the circle of a transducer. Fails if a fault has ended it.
pub fn measured(of: &Transducer, bounds: &Bounds, board: &mut BoardSettings, session: &mut Session) -> Result<Circle, LinkError> {
    measure(&Proposal::new(of, bounds), bounds, board, session)?.map_err(|fault| {
        LinkError::Failed(format!(
            "a resonance was identified at {:.2} Hz, but the admittance around it cannot be measured: {}",
            of.series_resonance_hz,
            words::fault(fault)
        ))
    })
}

/// Measures the circle at the largest voltage within the bounds; the drive is silent afterwards.
/// Returns the fault that has ended it, if any.
fn measure(
    of: &Proposal,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Result<Circle, Fault>, LinkError> {
    let transient_ratio = transient_ratio(&of.transducer);
    let mut used = USED_CURRENT_REL / transient_ratio;
    let mut of = of.within_limits(of.volts, transient_ratio * of.amperes, bounds);
    let hz = f64::from(of.transducer.series_resonance_hz);
    let mut base_hz = hz;
    let mut shifts = WINDOW_SHIFTS_REL.into_iter();
    loop {
        let q = f64::from(of.transducer.q);
        let reach = REACH_BANDWIDTHS.min(MAX_WINDOW_REL * USED_WINDOW_REL * q);
        let mut settings = bounds.settings();
        settings.extend(of.settings().into_iter().filter(|(name, _)| !name.starts_with("limits.")));
        // The later one of two settings with the same name applies.
        let window = ((reach / q + (base_hz / hz - 1.0).abs()) / USED_WINDOW_REL).max(of.span).min(MAX_WINDOW_REL);
        settings.extend([("drive.frequency_hz", base_hz as f32), ("tracking.mode", 3.0), ("tracking.span", window as f32)]);
        board.apply(&settings, session)?;
        let measured = points(&of, (reach, base_hz), used, bounds, session);
        probe::quiet(session)?;
        session.client.order(Command::Detune(Hertz(0.0)))?;
        match measured? {
            Err(Fault::OverCurrent | Fault::SenseSaturated) if of.volts > bounds.min_v => {
                (of, used) = (of.reduced(), REDUCTION * used);
            }
            Err(fault) if probe::is_of_self_test(fault) => match shifts.next() {
                Some(shift) => base_hz = hz * (1.0 + shift),
                None => return Ok(Err(fault)),
            },
            measured => return Ok(measured),
        }
    }
}

/// Returns the largest current during a change from one point to another, relative to the current
/// at the resonance. The decaying vibration at the resonance beats with the ring-up at the new
/// frequency and with the current of C0, so that all amplitudes may add for a moment.
fn transient_ratio(of: &Transducer) -> f64 {
    let omega = TAU * f64::from(of.series_resonance_hz);
    let (motional, clamped) = (1.0 / f64::from(of.rm_ohm), omega * f64::from(of.c0_f));
    (motional + clamped) / motional.hypot(clamped)
}

fn points(
    of: &Proposal,
    (reach, base_hz): (f64, f64),
    used: f64,
    bounds: &Bounds,
    session: &mut Session,
) -> Result<Result<Circle, Fault>, LinkError> {
    let it = &of.transducer;
    let hz = f64::from(it.series_resonance_hz);
    session.client.order(Command::Gate(Gate::On))?;
    session.client.order(Command::Detune(Hertz((hz - base_hz) as f32)))?;
    session.client.order(Command::Amplitude(Some(Amplitude::Volts(of.volts as f32))))?;
    if let Err(fault) = probe::run(session)? {
        return Ok(Err(fault));
    }
    let volts = match largest_voltage(of, used, bounds, session)? {
        Ok(volts) => volts,
        Err(fault) => return Ok(Err(fault)),
    };
    let scale = session.scale()?;
    let count = if width_hz(it) < NARROW_BANDWIDTH_HZ { POINTS_NARROW } else { POINTS_WIDE };
    let time_constant_s = f64::from(it.time_constant_s());
    let is_predicted = time_constant_s > PREDICTED_TIME_CONSTANT_S;
    let unsettled = POINT_CHANGE_REL
        * if is_predicted { UNPREDICTED_REL * (-PREDICTED_AT[1]).exp() } else { (-settle_s(it) / time_constant_s).exp() };
    let model_s = (MODEL_ERROR_REL + unsettled) / f64::from(it.rm_ohm);
    let mut circle = Circle { points: Vec::new(), volts, amperes: 0.0 };
    for n in 0..count {
        // From one end to the other in equal steps on the circle, so that each change is small.
        let part = 2.0 * f64::from(n) / f64::from(count - 1) - 1.0;
        let at_hz = hz + 0.5 * width_hz(it) * (part * (2.0 * reach).atan()).tan();
        session.client.order(Command::Detune(Hertz((at_hz - base_hz) as f32)))?;
        let first_s = if is_predicted { PREDICTED_AT[0] * time_constant_s } else { settle_s(it) };
        let mut report = match probe::driven(first_s, session)? {
            Ok(report) => report,
            Err(fault) => return Ok(Err(fault)),
        };
        let complex = |x: Phasor| Complex64::new(x.re.into(), x.im.into());
        let mut siemens = complex(report.i) / complex(report.v);
        if is_predicted {
            let before = report;
            report = match probe::driven((PREDICTED_AT[1] - PREDICTED_AT[0]) * time_constant_s, session)? {
                Ok(report) => report,
                Err(fault) => return Ok(Err(fault)),
            };
            let apart_s = scale.block_s * f64::from(report.block.wrapping_sub(before.block));
            let turn = TAU * (f64::from(report.frequency.0) - hz) * apart_s;
            let r = Complex64::from_polar((-apart_s / time_constant_s).exp(), -turn);
            siemens = (complex(report.i) / complex(report.v) - r * siemens) / (1.0 - r);
        }
        let (v, i) = (complex(report.v), complex(report.i));
        circle.amperes = circle.amperes.max(i.norm());
        if report.limit != Some(Limit::FrequencyWindow) && v.norm() > 0.0 {
            let deviation = NOISE_CODES * scale.ampere_per_lsb.hypot(scale.volt_per_lsb * siemens.norm()) / v.norm();
            circle.points.push(Point { hz: report.frequency.0.into(), siemens, deviation: deviation.hypot(model_s) });
        }
    }
    Ok(Ok(circle))
}

/// Returns the largest voltage within the bounds, V. It is approached in steps at the resonance,
/// because an amplifier with a source resistance delivers less than its set point.
fn largest_voltage(of: &Proposal, used: f64, bounds: &Bounds, session: &mut Session) -> Result<Result<f64, Fault>, LinkError> {
    let mut volts = of.volts;
    loop {
        let report = match probe::driven(settle_s(&of.transducer), session)? {
            Ok(report) => report,
            Err(fault) => return Ok(Err(fault)),
        };
        let allowed_v = (used * bounds.amperes * volts / f64::from(magnitude(report.i))).min(bounds.volts);
        if allowed_v < MIN_LEVEL_RATIO * volts {
            return Ok(Ok(volts));
        }
        volts = allowed_v.min(MAX_LEVEL_RATIO * volts);
        session.client.order(Command::Amplitude(Some(Amplitude::Volts(volts as f32))))?;
    }
}
