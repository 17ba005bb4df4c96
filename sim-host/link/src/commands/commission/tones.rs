//! Identification of the connected load by small tones before any scan: the magnitude and phase of
//! its current, and the permitted voltage.
//!
//! The board holds a frequency without tracking (`tracking.mode = off`). The client moves the tone
//! over the middle of the band, from both ends to the middle. A sharp resonance that a tone has
//! excited still rings during the following tones, so that they show it but do not measure it.

use std::f64::consts::TAU;
use std::time::Duration;

use firmware::board::command::Command;
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::fault::Fault;
use firmware::seam::phasor::{Phasor, magnitude};
use firmware::seam::units::Hertz;
use realfft::num_complex::Complex64;

use super::band::Band;
use super::board_settings::BoardSettings;
use super::limits::Bounds;
use super::load::{CAPACITIVE_DEGREES, LAGGING_CURRENT, Load, Tone, median};
use super::probe;
use crate::answer::quantity;
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;

/// Number of tones per level.
const TONES: usize = 11;
/// Largest offset of a tone from the middle, relative.
pub const REACH_REL: f64 = 0.15;
/// Half-width of the window in the settings, relative, a little more than the largest offset.
const SPAN_REL: f32 = 0.16;
/// Settling time of a tone before it is measured, s.
const SETTLE_S: f64 = 1e-3;
/// Current that is measured accurately enough, codes.
const CLEAR_CODES: f64 = 60.0;
/// Current below which no load is connected, codes, as the complex mean of all tones. Noise leaves
/// 0.1 codes.
const OPEN_CODES: f64 = 0.4;
/// Ratio of the voltages of two successive levels.
const LEVEL_RATIO: f64 = 4.0;
/// Expected current of a level, relative to the limit.
const EXPECTED_CURRENT_REL: f64 = 0.25;
/// Smallest capacitance of a transducer, F, with a margin for the noise of the current: the bound
/// of the self-test.
const MIN_CAPACITANCE_F: f64 = 0.1e-9;
/// Guesses of the capacitance, F, for a board that needs a value.
const CAPACITANCE_GUESSES_F: [f64; 5] = [300e-9, 15e-9, 1e-9, 0.15e-9, 5e-6];
/// Smallest and largest capacitance that the self-test accepts, relative to the guess.
const ACCEPTED_REL: (f64, f64) = (1.0 / 3.0, 8.0);
/// Offsets of the middle of the tones, relative, tried one after the other, because the tone of the
/// self-test may meet a resonance.
const SHIFTS_REL: [f64; 4] = [0.0, 0.06, -0.06, 0.12];
/// Voltage at the load, relative to the tone, below which the load is a short circuit.
const SHORT_VOLTAGE_REL: f64 = 0.5;
/// Impedance below which the load is a short circuit, ohm.
const SHORT_OHM: f64 = 0.1;
/// Plays the tones with rising voltage until the current is clear. Fails if the load cannot be a
/// transducer, and names the load.
pub fn measure(band: &Band, bounds: &Bounds, board: &mut BoardSettings, session: &mut Session) -> Result<Load, LinkError> {
    let mut last = Fault::LoadOpen;
    for shift in SHIFTS_REL {
        match measure_at(band.middle_hz() * (1.0 + shift), bounds, board, session)? {
            Ok(load) => return checked(load, bounds),
            Err(fault) => last = fault,
        }
    }
    let short =
        "a short: even at the smallest voltage the load draws more current than any transducer. Check the stack and the cable";
    Err(LinkError::Failed(match last {
        Fault::LoadOpen => open(bounds.volts),
        Fault::SenseSwapped => LAGGING_CURRENT.into(),
        Fault::LoadShorted | Fault::OverCurrent | Fault::SenseSaturated => short.into(),
        Fault::SensorImplausible if is_short(session)? => short.into(),
        fault => format!("the tones end with {}", words::fault(fault)),
    }))
}

/// Plays the tones around a frequency, with one guess of the capacitance after the other. Returns
/// the last fault if none is accepted.
fn measure_at(
    middle_hz: f64,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<Result<Load, Fault>, LinkError> {
    let guesses: &[f64] = if board.can_be_none("tracking.nominal_c0_f") { &[f64::INFINITY] } else { &CAPACITANCE_GUESSES_F };
    let mut volts = bounds.first_v;
    // A voltage that was too high is not tried again.
    let mut most_v = bounds.volts;
    let mut last = Fault::LoadOpen;
    for &guess_f in guesses {
        loop {
            let mut settings = bounds.settings();
            settings.extend([
                ("drive.frequency_hz", middle_hz as f32),
                ("drive.amplitude_v", volts as f32),
                ("drive.scan_volts", volts as f32),
                ("tracking.mode", 3.0),
                ("tracking.span", SPAN_REL),
                ("tracking.nominal_q", 100.0),
                ("tracking.nominal_c0_f", guess_f as f32),
            ]);
            board.apply(&settings, session)?;
            let played = play(middle_hz, volts, bounds, session);
            probe::quiet(session)?;
            match played? {
                Ok(mut load) => {
                    if guess_f.is_finite() && load.ringing().is_some() {
                        load.capacitance_f = load.capacitance_f.clamp(ACCEPTED_REL.0 * guess_f, ACCEPTED_REL.1 * guess_f);
                    }
                    return Ok(Ok(load));
                }
                Err(Fault::LoadOpen) if volts < most_v && guesses.len() == 1 => volts = (LEVEL_RATIO * volts).min(most_v),
                Err(Fault::OverCurrent | Fault::SenseSaturated | Fault::SensorImplausible) if volts > bounds.min_v => {
                    volts = (volts / LEVEL_RATIO).max(bounds.min_v);
                    most_v = volts;
                }
                Err(Fault::SenseSwapped) => return Ok(Err(Fault::SenseSwapped)),
                Err(fault) => {
                    last = fault;
                    break;
                }
            }
        }
    }
    Ok(Err(last))
}

fn open(volts: f64) -> String {
    format!(
        "no transducer: at {} the current is less than that of {}. Check the cable, the plug and the power of the amplifier",
        quantity(volts, "V"),
        quantity(MIN_CAPACITANCE_F, "F")
    )
}

/// Returns `true` if the voltage at the last fault was missing although a current flowed.
fn is_short(session: &mut Session) -> Result<bool, LinkError> {
    let Some(entry) = probe::latest_fault(session)? else { return Ok(false) };
    let volts = f64::from(magnitude(entry.v));
    Ok(volts < SHORT_VOLTAGE_REL * f64::from(entry.drive.0) && f64::from(magnitude(entry.i)) * 2.0 > volts)
}

/// Plays all tones with rising voltage, until the current is clear.
fn play(middle_hz: f64, first_v: f64, bounds: &Bounds, session: &mut Session) -> Result<Result<Load, Fault>, LinkError> {
    let scale = session.scale()?;
    let (code_v, code_a) = (scale.volt_per_lsb, scale.ampere_per_lsb);
    let mut volts = first_v;
    session.client.order(Command::Gate(Gate::On))?;
    session.client.order(Command::Detune(Hertz((middle_hz * offset_rel(0)) as f32)))?;
    session.client.order(Command::Amplitude(Some(Amplitude::Volts(volts as f32))))?;
    if let Err(fault) = probe::run(session)? {
        return Ok(Err(fault));
    }
    loop {
        session.client.order(Command::Amplitude(Some(Amplitude::Volts(volts as f32))))?;
        let mut tones = Vec::new();
        let mut most_a = 0.0_f64;
        for n in 0..TONES {
            session.client.order(Command::Detune(Hertz((middle_hz * offset_rel(n)) as f32)))?;
            let mut siemens = [Complex64::ZERO; 2];
            let mut hz = 0.0;
            for (siemens, wait_s) in siemens.iter_mut().zip([SETTLE_S, 0.0]) {
                let report = match probe::driven(wait_s, session)? {
                    Ok(report) => report,
                    Err(fault) => return Ok(Err(fault)),
                };
                let complex = |x: Phasor| Complex64::new(x.re.into(), x.im.into());
                most_a = most_a.max(complex(report.i).norm());
                *siemens = complex(report.i) / complex(report.v);
                hz = report.frequency.0.into();
            }
            tones.push(Tone { hz, siemens: 0.5 * (siemens[0] + siemens[1]), change: (siemens[0] - siemens[1]).norm() });
        }
        let allowed = volts * EXPECTED_CURRENT_REL * bounds.amperes / most_a.max(code_a);
        if most_a >= CLEAR_CODES * code_a || volts >= bounds.volts || allowed <= volts {
            session.client.order(Command::Idle)?;
            session.wait(Duration::from_secs_f64(SETTLE_S))?;
            let load = Load::from_tones(tones, volts, (code_v, code_a));
            let is_open = load.ringing().is_none() && load.mean_siemens() * volts < OPEN_CODES * code_a;
            return Ok(if is_open { Err(Fault::LoadOpen) } else { Ok(load) });
        }
        volts = (LEVEL_RATIO * volts).min(allowed).min(bounds.volts);
    }
}

/// Returns the offset of a tone from the middle, relative: alternately below and above it, at a
/// falling distance, so that a resonance in the middle of the band is excited last.
fn offset_rel(tone: usize) -> f64 {
    let distance = 1.0 - 2.0 * (tone / 2) as f64 / (TONES - 1) as f64;
    REACH_REL * if tone.is_multiple_of(2) { -distance } else { distance }
}

/// Returns the load if it can be a transducer.
fn checked(load: Load, bounds: &Bounds) -> Result<Load, LinkError> {
    let siemens = median(load.tones.iter().map(|tone| tone.siemens.norm()));
    if siemens * SHORT_OHM > 1.0 && load.degrees().abs() < CAPACITIVE_DEGREES {
        return Err(LinkError::Failed(format!("a short of {}: check the stack and the cable", quantity(1.0 / siemens, "ohm"))));
    }
    if load.ringing().is_none() && load.mean_siemens() < 0.5 * TAU * load.middle_hz() * MIN_CAPACITANCE_F {
        return Err(LinkError::Failed(open(bounds.volts)));
    }
    Ok(load)
}
