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
use super::circle::NOISE_CODES;
use super::limits::Bounds;
use super::modes::Search;
use super::probe;
use crate::answer::quantity;
use crate::link_error::LinkError;
use crate::session::Session;
use crate::words;
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
/// Guesses of the capacitance, F, for a board that needs a value.
const CAPACITANCE_GUESSES_F: [f64; 5] = [300e-9, 15e-9, 1e-9, 0.15e-9, 5e-6];
/// Smallest and largest capacitance that the self-test accepts, relative to the guess.
const ACCEPTED_REL: (f64, f64) = (1.0 / 3.0, 8.0);
/// Offsets of the middle of the tones, relative, tried if the tone of the self-test meets a
/// resonance.
const SHIFTS_REL: [f64; 3] = [0.06, -0.06, 0.12];
/// Voltage at the load, relative to the tone, below which the load is a short circuit.
const SHORT_VOLTAGE_REL: f64 = 0.5;
/// Impedance below which the load is a short circuit, ohm.
const SHORT_OHM: f64 = 0.1;
/// Phase of an admittance above which the load is a capacitance and not a resistance, degrees.
const CAPACITIVE_DEGREES: f64 = 45.0;
/// Change of the capacitance over the tones that shows a resonance outside the band, relative.
const MIN_DISPERSION_REL: f64 = 0.02;
/// Rms distance of the admittance from a straight line over the tones above which a resonance
/// rings, relative.
const RINGING_REL: f64 = 0.1;
/// Standard deviations of the noise that are not ringing.
const NOISE_SIGMAS: f64 = 3.0;

/// Measured tone.
#[derive(Clone, Copy, Debug)]
pub struct Tone {
    /// Frequency, Hz.
    pub hz: f64,
    /// Admittance, S.
    pub siemens: Complex64,
    /// Change of the admittance during the tone, S.
    change: f64,
}

impl Tone {
    /// Returns the complex capacitance, F, whose real part is the capacitance.
    fn farads(&self) -> Complex64 {
        self.siemens / Complex64::new(0.0, TAU * self.hz)
    }
}

/// Result of the tones.
#[derive(Clone, Debug, Default)]
pub struct Load {
    /// Tones, in ascending order of frequency.
    pub tones: Vec<Tone>,
    /// Capacitance that draws the median current of the steadier half of the tones, F.
    pub capacitance_f: f64,
    /// Peak voltage of the tones, V.
    pub volts: f64,
    /// Standard deviation of the admittance due to noise, S.
    noise_siemens: f64,
}

impl Load {
    /// Creates the load from measured tones.
    fn from_tones(mut tones: Vec<Tone>, volts: f64, (code_v, code_a): (f64, f64)) -> Self {
        tones.sort_by(|a, b| a.hz.total_cmp(&b.hz));
        let mut steady = tones.clone();
        steady.sort_by(|a, b| a.change.total_cmp(&b.change));
        steady.truncate(tones.len() / 2 + 1);
        let capacitance_f = median(steady.iter().map(|tone| tone.farads().re));
        let noise_siemens = NOISE_CODES * code_a.hypot(code_v * median(tones.iter().map(|tone| tone.siemens.norm()))) / volts;
        Load { tones, capacitance_f, volts, noise_siemens }
    }

    /// Returns the median frequency, Hz.
    fn middle_hz(&self) -> f64 {
        median(self.tones.iter().map(|tone| tone.hz))
    }

    /// Returns the mean complex capacitance, F. Noise, with a phase that differs from tone to tone,
    /// averages out.
    fn mean_farads(&self) -> Complex64 {
        self.tones.iter().map(Tone::farads).sum::<Complex64>() / self.tones.len() as f64
    }

    /// Returns the magnitude of the mean admittance at the middle frequency, S.
    fn mean_siemens(&self) -> f64 {
        self.mean_farads().norm() * TAU * self.middle_hz()
    }

    /// Returns the slope of the complex capacitance by a straight line through the tones, F/Hz, and
    /// the rms distance of the tones from it, F.
    fn line(&self) -> (Complex64, f64) {
        let number = self.tones.len() as f64;
        let mean_hz = self.tones.iter().map(|tone| tone.hz).sum::<f64>() / number;
        let mean_f = self.mean_farads();
        let squares: f64 = self.tones.iter().map(|tone| (tone.hz - mean_hz).powi(2)).sum();
        let slope = self.tones.iter().map(|tone| (tone.hz - mean_hz) * (tone.farads() - mean_f)).sum::<Complex64>() / squares;
        let distance = |tone: &Tone| (tone.farads() - mean_f - slope * (tone.hz - mean_hz)).norm_sqr();
        (slope, (self.tones.iter().map(distance).sum::<f64>() / number).sqrt())
    }

    /// Returns the relative rise of the capacitance over the tones.
    fn rise(&self) -> f64 {
        2.0 * REACH_REL * self.middle_hz() * self.line().0.re / self.mean_farads().re
    }

    /// Returns the rms distance of the tones from a straight line, relative to their rms value, if
    /// it shows a resonance: a resistor, a capacitor or an inductance follows the line.
    fn ringing(&self) -> Option<f64> {
        let squares: f64 = self.tones.iter().map(|tone| tone.farads().norm_sqr()).sum();
        let (distance_f, rms_f) = (self.line().1, (squares / self.tones.len() as f64).sqrt());
        (distance_f > RINGING_REL * rms_f + NOISE_SIGMAS * self.noise_f()).then_some(distance_f / rms_f)
    }

    /// Returns the standard deviation of a capacitance due to noise, F.
    fn noise_f(&self) -> f64 {
        self.noise_siemens / (TAU * self.middle_hz())
    }

    /// Returns the median phase of the admittance, degrees: 90 for a capacitance, 0 for a
    /// resistance.
    fn degrees(&self) -> f64 {
        median(self.tones.iter().map(|tone| tone.siemens.arg().to_degrees()))
    }

    /// Describes the measured capacitance.
    pub fn in_words(&self) -> String {
        let (capacitance, volts) = (quantity(self.capacitance_f, "F"), quantity(self.volts, "V"));
        if self.ringing().is_some() {
            return format!("roughly {capacitance} measured by tones of {volts}, which make a resonance ring");
        }
        format!("{capacitance} measured by tones of {volts}")
    }

    /// Describes a load without a resonance in the band.
    pub fn without_resonance(&self, band: &Band, search: &Search) -> String {
        let none = format!("no resonance from {:.0} to {:.0} Hz", band.low_hz, band.high_hz);
        let rise = self.rise();
        let capacitance = quantity(self.capacitance_f, "F");
        let wider = "Give a band that contains the resonance of the transducer's data sheet";
        if let Some(outside) = &search.outside {
            return format!(
                "{none}; a resonance at {:.1} Hz with Q {:.1} is outside the band. Give a band that contains it",
                outside.hz(),
                outside.transducer.q
            );
        }
        if let Some(ringing) = self.ringing() {
            let changes = format!(
                "the admittance changes from tone to tone by {:.0} % of its rms value, as near the resonance of a transducer",
                100.0 * ringing
            );
            return match search.fault {
                Some(fault) => format!("{none} was identified: a scan ends with {}, and {changes}", words::fault(fault)),
                None => format!("{none}; {changes}: it is outside the band, or too weak for a scan. {wider}"),
            };
        }
        match self.degrees() {
            degrees if degrees < -CAPACITIVE_DEGREES => format!("{LAGGING_CURRENT}. There is {none}"),
            degrees if degrees < CAPACITIVE_DEGREES => {
                let ohm = 1.0 / median(self.tones.iter().map(|tone| tone.siemens.re));
                format!("a resistor of {}: {none}, and the current is in phase with the voltage", quantity(ohm, "ohm"))
            }
            _ if rise.abs() > MIN_DISPERSION_REL + NOISE_SIGMAS * self.noise_f() / self.mean_farads().norm() => format!(
                "{none}; the capacitance of about {capacitance} changes with the frequency by {:.1} %, as next to the resonance of \
                 a transducer: it is outside the band. {wider}",
                100.0 * rise.abs()
            ),
            _ => format!("a capacitor of {capacitance}: {none}. A transducer behaves like this far from its resonances. {wider}"),
        }
    }
}

/// Plays the tones with rising voltage until the current is clear. Fails if the load cannot be a
/// transducer, and names the load.
pub fn measure(band: &Band, bounds: &Bounds, board: &mut BoardSettings, session: &mut Session) -> Result<Load, LinkError> {
    let mut middle_hz = band.middle_hz();
    let mut shifts = SHIFTS_REL.into_iter();
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
                Ok(mut load) => {
                    if guess_f.is_finite() && load.ringing().is_some() {
                        load.capacitance_f = load.capacitance_f.clamp(ACCEPTED_REL.0 * guess_f, ACCEPTED_REL.1 * guess_f);
                    }
                    return checked(load, bounds);
                }
                Err(Fault::LoadOpen) if volts < most_v && guesses.len() == 1 => volts = (LEVEL_RATIO * volts).min(most_v),
                Err(Fault::OverCurrent | Fault::SenseSaturated | Fault::SensorImplausible) if volts > bounds.min_v => {
                    volts = (volts / LEVEL_RATIO).max(bounds.min_v);
                    most_v = volts;
                }
                Err(Fault::SenseSwapped) => match shifts.next() {
                    Some(shift) => middle_hz = band.middle_hz() * (1.0 + shift),
                    None => return Err(LinkError::Failed(LAGGING_CURRENT.into())),
                },
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
        Some(fault) => format!("the tones end with {}", words::fault(fault)),
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
            let is_open = load.mean_siemens() * volts < OPEN_CODES * code_a;
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

/// Message for a load with lagging current.
const LAGGING_CURRENT: &str =
    "the current lags the voltage: an inductance is connected, the two sense channels are exchanged, or one of them is inverted";

/// Returns the load if it can be a transducer.
fn checked(load: Load, bounds: &Bounds) -> Result<Load, LinkError> {
    let siemens = median(load.tones.iter().map(|tone| tone.siemens.norm()));
    if siemens * SHORT_OHM > 1.0 && load.degrees().abs() < CAPACITIVE_DEGREES {
        return Err(LinkError::Failed(format!("a short of {}: check the stack and the cable", quantity(1.0 / siemens, "ohm"))));
    }
    if load.mean_siemens() < 0.5 * TAU * load.middle_hz() * MIN_CAPACITANCE_F {
        return Err(LinkError::Failed(open(bounds.volts)));
    }
    Ok(load)
}

/// Returns the median of finite values; NaN if there are none.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    quantile(&ascending(values.filter(|value| value.is_finite())), 0.5).unwrap_or(f64::NAN)
}
