//! Identification of the connected load by small tones before any scan: the magnitude and phase of
//! its current, and the permitted voltage.
//!
//! The board holds a frequency without tracking (`tracking.mode = off`). The client moves the tone
//! over the middle of the band.

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

/// Number of tones per level.
const TONES: usize = 11;
/// Largest offset of a tone from the middle, relative.
const REACH_REL: f64 = 0.15;
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
/// Guesses of the capacitance, F, for a board that needs a value. Its self-test accepts a load from
/// a third to eight times the guess.
const CAPACITANCE_GUESSES_F: [f64; 5] = [300e-9, 15e-9, 1e-9, 0.15e-9, 5e-6];
/// Voltage at the load, relative to the tone, below which the load is a short circuit.
const SHORT_VOLTAGE_REL: f64 = 0.5;
/// Impedance below which the load is a short circuit, ohm.
const SHORT_OHM: f64 = 0.1;
/// Phase of an admittance above which the load is a capacitance and not a resistance, degrees.
const CAPACITIVE_DEGREES: f64 = 45.0;
/// Change of the capacitance over the tones that shows a resonance outside the band, relative.
const MIN_DISPERSION_REL: f64 = 0.02;

/// Result of the tones.
#[derive(Clone, Debug, Default)]
pub struct Load {
    /// Frequency, Hz, and admittance, S, of each tone.
    pub tones: Vec<(f64, Complex64)>,
    /// Capacitance that draws the median current, F.
    pub capacitance_f: f64,
    /// Peak voltage of the tones, V.
    pub volts: f64,
}

impl Load {
    /// Creates the load from measured tones.
    fn from_tones(tones: Vec<(f64, Complex64)>, volts: f64) -> Self {
        let capacitance_f = median(tones.iter().map(|(hz, y)| y.im / (TAU * hz)));
        Load { tones, capacitance_f, volts }
    }

    /// Returns the magnitude of the mean admittance at the middle frequency, S. Noise, with a phase
    /// that differs from tone to tone, averages out.
    fn mean_siemens(&self) -> f64 {
        let capacitances = self.tones.iter().map(|(hz, y)| y / Complex64::new(0.0, TAU * hz));
        let hz = median(self.tones.iter().map(|(hz, _)| *hz));
        (capacitances.sum::<Complex64>() / self.tones.len() as f64).norm() * TAU * hz
    }

    /// Returns the relative rise of the capacitance over the tones, by a straight line through
    /// them.
    fn rise(&self) -> f64 {
        let number = self.tones.len() as f64;
        let points: Vec<(f64, f64)> = self.tones.iter().map(|(hz, y)| (*hz, y.im / (TAU * hz))).collect();
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / number;
        let (hz, c) = (mean(|point| point.0), mean(|point| point.1));
        let (with, alone) = points.iter().fold((0.0, 0.0), |(with, alone), point| {
            let apart_hz = point.0 - hz;
            (with + apart_hz * (point.1 - c), alone + apart_hz * apart_hz)
        });
        2.0 * REACH_REL * hz * with / alone / c
    }

    /// Returns the median phase of the admittance, degrees: 90 for a capacitance, 0 for a
    /// resistance.
    fn degrees(&self) -> f64 {
        median(self.tones.iter().map(|(_, y)| y.arg().to_degrees()))
    }

    /// Describes a load without a resonance.
    pub fn without_resonance(&self, band: &Band) -> String {
        let ends = format!("{:.0} to {:.0} Hz", band.low_hz, band.high_hz);
        let rise = self.rise();
        let capacitance = quantity(self.capacitance_f, "F");
        let wider = "Give a band that contains the resonance of the transducer's data sheet";
        match self.degrees() {
            degrees if degrees < -CAPACITIVE_DEGREES => format!("{LAGGING_CURRENT}. There is no resonance from {ends}"),
            degrees if degrees < CAPACITIVE_DEGREES => {
                let ohm = 1.0 / median(self.tones.iter().map(|(_, y)| y.re));
                format!(
                    "a resistor of {}: no resonance from {ends}, and the current is in phase with the voltage",
                    quantity(ohm, "ohm")
                )
            }
            _ if rise.abs() > MIN_DISPERSION_REL => format!(
                "no resonance from {ends}; the capacitance of about {capacitance} changes with the frequency by {:.1} %, as next \
                 to the resonance of a transducer: it is outside the band. {wider}",
                100.0 * rise.abs()
            ),
            _ => format!(
                "a capacitor of {capacitance}: no resonance from {ends}. A transducer behaves like this far from its resonances. \
                 {wider}"
            ),
        }
    }
}

/// Plays the tones with rising voltage until the current is clear. Fails if the load cannot be a
/// transducer, and names the load.
pub fn measure(band: &Band, bounds: &Bounds, board: &mut BoardSettings, session: &mut Session) -> Result<Load, LinkError> {
    let middle_hz = band.middle_hz();
    let guesses: &[f64] = if board.can_be_none("tracking.nominal_c0_f") { &[f64::INFINITY] } else { &CAPACITANCE_GUESSES_F };
    let mut volts = bounds.first_v;
    // A voltage that was too high is not tried again.
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
                ("tracking.span", SPAN_REL),
                ("tracking.nominal_q", 100.0),
                ("tracking.nominal_c0_f", guess_f as f32),
            ]);
            board.apply(&settings, session)?;
            let played = play(middle_hz, volts, bounds, session);
            probe::quiet(session)?;
            match played? {
                Ok(load) => return checked(load, bounds),
                Err(Fault::LoadOpen) if volts < most_v && guesses.len() == 1 => volts = (LEVEL_RATIO * volts).min(most_v),
                Err(Fault::OverCurrent | Fault::SenseSaturated | Fault::SensorImplausible) if volts > bounds.min_v => {
                    volts = (volts / LEVEL_RATIO).max(bounds.min_v);
                    most_v = volts;
                }
                Err(Fault::SenseSwapped) => return Err(LinkError::Failed(LAGGING_CURRENT.into())),
                Err(fault) => {
                    last = Some(fault);
                    break;
                }
            }
        }
    }
    let short =
        "a short: even at the smallest voltage the load draws more current than any transducer. Check the stack and the cable";
    Err(LinkError::Failed(match last {
        Some(Fault::LoadOpen) => open(bounds.volts),
        Some(Fault::LoadShorted | Fault::OverCurrent | Fault::SenseSaturated) => short.into(),
        Some(Fault::SensorImplausible) if is_short(session)? => short.into(),
        Some(fault) => format!("the tones end with {}", crate::words::fault(fault)),
        None => "no tone could be measured".into(),
    }))
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
            let hz = middle_hz * (1.0 + REACH_REL * part);
            session.client.order(Command::Detune(Hertz((hz - middle_hz) as f32)))?;
            let report = match probe::driven(SETTLE_S, session)? {
                Ok(report) => report,
                Err(fault) => return Ok(Err(fault)),
            };
            let complex = |x: firmware::seam::phasor::Phasor| Complex64::new(x.re.into(), x.im.into());
            most_a = most_a.max(complex(report.i).norm());
            tones.push((report.frequency.0.into(), complex(report.i) / complex(report.v)));
        }
        let allowed = volts * EXPECTED_CURRENT_REL * bounds.amperes / most_a.max(code_a);
        if most_a >= CLEAR_CODES * code_a || volts >= bounds.volts || allowed <= volts {
            session.client.order(Command::Idle)?;
            session.wait(Duration::from_secs_f64(SETTLE_S))?;
            let load = Load::from_tones(tones, volts);
            let is_open = load.mean_siemens() * volts < OPEN_CODES * code_a;
            return Ok(if is_open { Err(Fault::LoadOpen) } else { Ok(load) });
        }
        volts = (LEVEL_RATIO * volts).min(allowed).min(bounds.volts);
    }
}

/// Message for a load with lagging current.
const LAGGING_CURRENT: &str =
    "the current lags the voltage: an inductance is connected, the two sense channels are exchanged, or one of them is inverted";

/// Returns the load if it can be a transducer.
fn checked(load: Load, bounds: &Bounds) -> Result<Load, LinkError> {
    let siemens = median(load.tones.iter().map(|(_, y)| y.norm()));
    if siemens * SHORT_OHM > 1.0 && load.degrees().abs() < CAPACITIVE_DEGREES {
        return Err(LinkError::Failed(format!("a short of {}: check the stack and the cable", quantity(1.0 / siemens, "ohm"))));
    }
    let hz = median(load.tones.iter().map(|(hz, _)| *hz));
    if load.mean_siemens() < 0.5 * TAU * hz * MIN_CAPACITANCE_F {
        return Err(LinkError::Failed(open(bounds.volts)));
    }
    Ok(load)
}

/// Returns the median of finite values; NaN if there are none.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    quantile(&ascending(values.filter(|value| value.is_finite())), 0.5).unwrap_or(f64::NAN)
}
