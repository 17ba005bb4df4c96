//! The admittance round the circle of a resonance, each point settled, before settings for it are proposed.
//!
//! The board holds a frequency and tracks nothing (`tracking.mode = off`), so that no tracker decides where a point is.

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
use super::proposal::{LESS, Proposal, USED, settle_s, width_hz};
use crate::link_error::LinkError;
use crate::session::Session;

/// Points on the circle; fewer where the bandwidth is less than so many hertz, which is less precise than the bound of 1 Hz asks for.
const POINTS: (u32, u32, f64) = (17, 9, 40.0);
/// How far they go to either side, bandwidths.
const REACH: f64 = 2.5;
/// Widest window to each side, relative, and the part of it that is used.
const WINDOW: (f64, f64) = (0.2, 0.95);
/// How far beside the resonance the window's middle is, relative, where the tone of the board's self-test meets a resonance.
const SHIFTS: [f64; 3] = [0.03, -0.03, 0.06];
/// Noise of a block's voltage and current, codes of the converter.
const NOISE_CODES: f64 = 0.4;
/// What a circuit of resonances leaves of an admittance without noise, in parts of its conductance: the images of the DAC; and how much of it a step from
/// one point to the next changes, of which a part has not settled.
const MODEL: (f64, f64) = (5e-4, 0.3);
/// From one level to the next, at most; and by how much more voltage is not worth another level.
const STEP: (f64, f64) = (4.0, 1.1);

/// The circle as measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Admittance at rising frequencies.
    pub points: Vec<Point>,
    /// Peak voltage of the drive, V.
    pub volts: f64,
    /// Largest peak current, A.
    pub amperes: f64,
}

/// Measures the circle as loud as the bounds allow; the board is silent afterwards. The fault that has ended it, if one has.
pub fn measure(
    of: &Proposal,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Result<Circle, Fault>, LinkError> {
    let swell = swell(&of.transducer);
    let mut used = USED / swell;
    let mut of = of.as_loud_as(of.volts, swell * of.amperes, bounds);
    let hz = f64::from(of.transducer.series_resonance_hz);
    let mut base_hz = hz;
    let mut shifts = SHIFTS.into_iter();
    loop {
        let q = f64::from(of.transducer.q);
        let reach = REACH.min(WINDOW.0 * WINDOW.1 * q);
        let mut settings = bounds.settings();
        settings.extend(of.settings().into_iter().filter(|(name, _)| !name.starts_with("limits.")));
        // Of two the later one counts.
        let window = ((reach / q + (base_hz / hz - 1.0).abs()) / WINDOW.1).max(of.span).min(WINDOW.0);
        settings.extend([("drive.frequency_hz", base_hz as f32), ("tracking.mode", 3.0), ("tracking.span", window as f32)]);
        board.apply(&settings, session)?;
        let measured = points(&of, (reach, base_hz), used, bounds, session);
        probe::quiet(session)?;
        session.client.order(Command::Detune(Hertz(0.0)))?;
        match measured? {
            Err(Fault::OverCurrent | Fault::SenseSaturated) if of.volts > bounds.quietest_v => {
                (of, used) = (of.quieter(), LESS * used);
            }
            Err(fault) if probe::is_of_self_test(fault) => match shifts.next() {
                Some(shift) => base_hz = hz * (1.0 + shift),
                None => return Ok(Err(fault)),
            },
            measured => return Ok(measured),
        }
    }
}

/// The largest current that can flow while the tone goes from one point to another, over that at the resonance. What still rings at the resonance beats with
/// what the new tone rings up, and with the current of C0, so that for a moment all amounts may add.
fn swell(of: &Transducer) -> f64 {
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
    let volts = match loudest(of, used, bounds, session)? {
        Ok(volts) => volts,
        Err(fault) => return Ok(Err(fault)),
    };
    let scale = session.scale()?;
    let count = if width_hz(it) < POINTS.2 { POINTS.1 } else { POINTS.0 };
    let unsettled = MODEL.1 * (-settle_s(it) / f64::from(it.time_constant_s())).exp();
    let model_s = (MODEL.0 + unsettled) / f64::from(it.rm_ohm);
    let mut circle = Circle { points: Vec::new(), volts, amperes: 0.0 };
    for n in 0..count {
        // From one end to the other, evenly round the circle, so that each step is small.
        let part = 2.0 * f64::from(n) / f64::from(count - 1) - 1.0;
        let at_hz = hz + 0.5 * width_hz(it) * (part * (2.0 * reach).atan()).tan();
        session.client.order(Command::Detune(Hertz((at_hz - base_hz) as f32)))?;
        let report = match probe::driven(settle_s(it), session)? {
            Ok(report) => report,
            Err(fault) => return Ok(Err(fault)),
        };
        let complex = |x: Phasor| Complex64::new(x.re.into(), x.im.into());
        let (v, i) = (complex(report.v), complex(report.i));
        circle.amperes = circle.amperes.max(i.norm());
        if report.limit != Some(Limit::FrequencyWindow) && v.norm() > 0.0 {
            let siemens = i / v;
            let deviation = NOISE_CODES * scale.ampere_per_lsb.hypot(scale.volt_per_lsb * siemens.norm()) / v.norm();
            circle.points.push(Point { hz: report.frequency.0.into(), siemens, deviation: deviation.hypot(model_s) });
        }
    }
    Ok(Ok(circle))
}

/// The largest voltage within the bounds, V, reached step by step at the resonance: an amplifier with a source resistance drives less than its set point.
fn loudest(of: &Proposal, used: f64, bounds: &Bounds, session: &mut Session) -> Result<Result<f64, Fault>, LinkError> {
    let mut volts = of.volts;
    loop {
        let report = match probe::driven(settle_s(&of.transducer), session)? {
            Ok(report) => report,
            Err(fault) => return Ok(Err(fault)),
        };
        let allowed_v = (used * bounds.amperes * volts / f64::from(magnitude(report.i))).min(bounds.volts);
        if allowed_v < STEP.1 * volts {
            return Ok(Ok(volts));
        }
        volts = allowed_v.min(STEP.0 * volts);
        session.client.order(Command::Amplitude(Some(Amplitude::Volts(volts as f32))))?;
    }
}
