//! What hangs on the board, by small tones before anything is scanned: how much current they draw, with which phase, and how loud they may become.
//!
//! The board holds a frequency and tracks nothing (`tracking.mode = off`); the client moves the tone over the middle of the band.

use std::f64::consts::TAU;
use std::time::Duration;

use firmware::board::command::Command;
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::fault::Fault;
use firmware::seam::phasor::magnitude;
use firmware::seam::units::Hertz;
use realfft::num_complex::Complex64;

use super::band::Band;
use super::board_settings::BoardSettings;
use super::limits::Bounds;
use super::probe;
use crate::answer::quantity;
use crate::link_error::LinkError;
use crate::session::Session;
use report::statistics::{ascending, quantile};

/// Tones on each level.
const TONES: usize = 11;
/// How far they go to either side of the middle, as a part of it; the window of the settings is a little wider.
const REACH: f64 = 0.15;
const SPAN: f32 = 0.16;
/// Time that a tone has before it is measured, s.
const SETTLE_S: f64 = 1e-3;
/// A current of so many codes is measured well enough.
const CLEAR_CODES: f64 = 60.0;
/// Below so many codes, as the mean of all tones by amount and phase, nothing is there: noise leaves a tenth of one.
const OPEN_CODES: f64 = 0.4;
/// From one level to the next.
const STEP: f64 = 4.0;
/// Part of the current limit that a level may be expected to reach.
const EXPECTED: f64 = 0.25;
/// The least capacitance of a transducer, F, with a margin for the current's noise: the self-test's own bound.
const LEAST_F: f64 = 0.1e-9;
/// Guesses of the capacitance where the board must have one, F: its self-test takes three times less and eight times more.
const GUESSES_F: [f64; 5] = [300e-9, 15e-9, 1e-9, 0.15e-9, 5e-6];
/// Less than this part of the tone's voltage at the load is a short, and so is an impedance below so many ohms.
const SHORT: (f64, f64) = (0.5, 0.1);
/// Phase of an admittance from which on it is that of a capacitance rather than a resistance, degrees.
const CAPACITIVE_DEGREES: f64 = 45.0;
/// Change of the capacitance over the tones that shows a resonance outside the band, relative.
const DISPERSION: f64 = 0.02;

/// What the tones have measured.
#[derive(Clone, Debug, Default)]
pub struct Load {
    /// Frequency, Hz, and admittance, S, of each tone.
    pub tones: Vec<(f64, Complex64)>,
    /// Capacitance that takes the median current, F.
    pub capacitance_f: f64,
    /// Peak voltage of the tones, V.
    pub volts: f64,
}

impl Load {
    /// The load of some tones.
    fn of(tones: Vec<(f64, Complex64)>, volts: f64) -> Self {
        let capacitance_f = median(tones.iter().map(|(hz, y)| y.im / (TAU * hz)));
        Load { tones, capacitance_f, volts }
    }

    /// Size of the mean admittance at the middle frequency, S: what differs from tone to tone in phase is noise.
    fn mean_siemens(&self) -> f64 {
        let capacitances = self.tones.iter().map(|(hz, y)| y / Complex64::new(0.0, TAU * hz));
        let hz = median(self.tones.iter().map(|(hz, _)| *hz));
        (capacitances.sum::<Complex64>() / self.tones.len() as f64).norm() * TAU * hz
    }

    /// By how much the capacitance rises over the tones, relative: the slope of a straight line through them.
    fn rise(&self) -> f64 {
        let number = self.tones.len() as f64;
        let points: Vec<(f64, f64)> = self.tones.iter().map(|(hz, y)| (*hz, y.im / (TAU * hz))).collect();
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / number;
        let (hz, c) = (mean(|point| point.0), mean(|point| point.1));
        let (with, alone) = points.iter().fold((0.0, 0.0), |(with, alone), point| {
            let apart_hz = point.0 - hz;
            (with + apart_hz * (point.1 - c), alone + apart_hz * apart_hz)
        });
        2.0 * REACH * hz * with / alone / c
    }

    /// Median phase of the admittance, degrees: 90 of a capacitance, 0 of a resistance.
    fn degrees(&self) -> f64 {
        median(self.tones.iter().map(|(_, y)| y.arg().to_degrees()))
    }

    /// What a load without a resonance is.
    pub fn without_resonance(&self, band: &Band) -> String {
        let ends = format!("{:.0} to {:.0} Hz", band.low_hz, band.high_hz);
        let rise = self.rise();
        let capacitance = quantity(self.capacitance_f, "F");
        let wider = "Look at the transducer's data sheet, and give a band that has its resonance";
        match self.degrees() {
            degrees if degrees < -CAPACITIVE_DEGREES => format!("{LAGS}. There is no resonance from {ends}"),
            degrees if degrees < CAPACITIVE_DEGREES => {
                let ohm = 1.0 / median(self.tones.iter().map(|(_, y)| y.re));
                format!(
                    "a resistor of {}: no resonance from {ends}, and the current is in phase with the voltage",
                    quantity(ohm, "ohm")
                )
            }
            _ if rise.abs() > DISPERSION => format!(
                "no resonance from {ends}; the capacitance of about {capacitance} changes with the frequency by {:.1} %, as that of a transducer \
                 beside its resonance does: it is outside the band. {wider}",
                100.0 * rise.abs()
            ),
            _ => format!(
                "a capacitor of {capacitance}: no resonance from {ends}. A transducer looks like this far from its resonances. {wider}"
            ),
        }
    }
}

/// Plays the tones, louder until they are measured well; names a load that is none.
pub fn measure(band: &Band, bounds: &Bounds, board: &mut BoardSettings, session: &mut Session) -> Result<Load, LinkError> {
    let middle_hz = band.middle_hz();
    let guesses: &[f64] = if board.can_be_none("tracking.nominal_c0_f") { &[f64::INFINITY] } else { &GUESSES_F };
    let mut volts = bounds.least_v;
    // What was too loud once is not tried again.
    let mut most_v = bounds.volts;
    let mut last = None;
    for &guess_f in guesses {
        loop {
            let mut settings = bounds.settings();
            settings.extend([
                ("drive.frequency_hz", middle_hz as f32),
                ("drive.amplitude_v", volts as f32),
                ("drive.scan_volts", volts as f32),
                ("tracking.mode", 3.0),
                ("tracking.span", SPAN),
                ("tracking.nominal_q", 100.0),
                ("tracking.nominal_c0_f", guess_f as f32),
            ]);
            board.apply(&settings, session)?;
            let played = play(middle_hz, volts, bounds, session);
            probe::quiet(session)?;
            match played? {
                Ok(load) => return checked(load, bounds),
                Err(Fault::LoadOpen) if volts < most_v && guesses.len() == 1 => volts = (STEP * volts).min(most_v),
                Err(Fault::OverCurrent | Fault::SenseSaturated | Fault::SensorImplausible) if volts > bounds.quietest_v => {
                    volts = (volts / STEP).max(bounds.quietest_v);
                    most_v = volts;
                }
                Err(Fault::SenseSwapped) => return Err(LinkError::Failed(LAGS.into())),
                Err(fault) => {
                    last = Some(fault);
                    break;
                }
            }
        }
    }
    let short =
        "a short: the load draws more current than any transducer does, at the smallest voltage already. Look at stack and cable";
    Err(LinkError::Failed(match last {
        Some(Fault::LoadOpen) => open(bounds.volts),
        Some(Fault::LoadShorted | Fault::OverCurrent | Fault::SenseSaturated) => short.into(),
        Some(Fault::SensorImplausible) if session_short(session)? => short.into(),
        Some(fault) => format!("the tones end in {}", crate::words::fault(fault)),
        None => "no tone could be measured".into(),
    }))
}

fn open(volts: f64) -> String {
    format!(
        "no transducer: less current flows at {} than {} would take. Look at cable and plug, and whether the amplifier is on",
        quantity(volts, "V"),
        quantity(LEAST_F, "F")
    )
}

/// Whether the voltage of the last fault was missing under a current that is there.
fn session_short(session: &mut Session) -> Result<bool, LinkError> {
    let Some(entry) = probe::latest_fault(session)? else { return Ok(false) };
    let volts = f64::from(magnitude(entry.v));
    Ok(volts < SHORT.0 * f64::from(entry.drive.0) && f64::from(magnitude(entry.i)) * 2.0 > volts)
}

/// All tones on rising levels, until the current is clear.
fn play(middle_hz: f64, first_v: f64, bounds: &Bounds, session: &mut Session) -> Result<Result<Load, Fault>, LinkError> {
    let code_a = session.scale()?.ampere_per_lsb;
    let mut volts = first_v;
    session.client.order(Command::Gate(Gate::On))?;
    session.client.order(Command::Detune(Hertz(0.0)))?;
    session.client.order(Command::Amplitude(Some(Amplitude::Volts(volts as f32))))?;
    if let Err(fault) = probe::run(session)? {
        return Ok(Err(fault));
    }
    loop {
        session.client.order(Command::Amplitude(Some(Amplitude::Volts(volts as f32))))?;
        let mut tones = Vec::new();
        let mut most_a = 0.0_f64;
        for n in 0..TONES {
            let part = 2.0 * n as f64 / (TONES - 1) as f64 - 1.0;
            let hz = middle_hz * (1.0 + REACH * part);
            session.client.order(Command::Detune(Hertz((hz - middle_hz) as f32)))?;
            let report = match probe::driven(SETTLE_S, session)? {
                Ok(report) => report,
                Err(fault) => return Ok(Err(fault)),
            };
            let complex = |x: firmware::seam::phasor::Phasor| Complex64::new(x.re.into(), x.im.into());
            most_a = most_a.max(complex(report.i).norm());
            tones.push((report.frequency.0.into(), complex(report.i) / complex(report.v)));
        }
        let allowed = volts * EXPECTED * bounds.amperes / most_a.max(code_a);
        if most_a >= CLEAR_CODES * code_a || volts >= bounds.volts || allowed <= volts {
            session.client.order(Command::Idle)?;
            session.wait(Duration::from_secs_f64(SETTLE_S))?;
            let load = Load::of(tones, volts);
            let is_open = load.mean_siemens() * volts < OPEN_CODES * code_a;
            return Ok(if is_open { Err(Fault::LoadOpen) } else { Ok(load) });
        }
        volts = (STEP * volts).min(allowed).min(bounds.volts);
    }
}

/// A load whose current lags.
const LAGS: &str = "the current lags the voltage: an inductance is connected, or the two sense channels are exchanged, or one of them is reversed";

/// The load, if it can be a transducer.
fn checked(load: Load, bounds: &Bounds) -> Result<Load, LinkError> {
    let siemens = median(load.tones.iter().map(|(_, y)| y.norm()));
    if siemens * SHORT.1 > 1.0 && load.degrees().abs() < CAPACITIVE_DEGREES {
        return Err(LinkError::Failed(format!("a short of {}: look at stack and cable", quantity(1.0 / siemens, "ohm"))));
    }
    let hz = median(load.tones.iter().map(|(hz, _)| *hz));
    if load.mean_siemens() < 0.5 * TAU * hz * LEAST_F {
        return Err(LinkError::Failed(open(bounds.volts)));
    }
    Ok(load)
}

/// The middle one of some values; not a number where there are none.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    quantile(&ascending(values.filter(|value| value.is_finite())), 0.5).unwrap_or(f64::NAN)
}
