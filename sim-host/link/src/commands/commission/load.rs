//! Load as the tones have measured it: its capacitance, and a diagnosis if it has no resonance.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use super::band::Band;
use super::circle::NOISE_CODES;
use super::modes::Search;
use super::tones::REACH_REL;
use crate::answer::quantity;
use crate::words;
use report::statistics::{ascending, quantile};

/// Phase of an admittance above which the load is a capacitance and not a resistance, degrees.
pub const CAPACITIVE_DEGREES: f64 = 45.0;
/// Change of the capacitance over the tones that shows a resonance outside the band, relative.
const MIN_DISPERSION_REL: f64 = 0.02;
/// Rms distance of the admittance from a straight line over the tones above which a resonance
/// rings, relative.
const RINGING_REL: f64 = 0.1;
/// Standard deviations of the noise that are not ringing.
const NOISE_SIGMAS: f64 = 3.0;

/// Message for a load with lagging current.
pub const LAGGING_CURRENT: &str =
    "the current lags the voltage: an inductance is connected, the two sense channels are exchanged, or one of them is inverted";

/// Measured tone.
#[derive(Clone, Copy, Debug)]
pub struct Tone {
    /// Frequency, Hz.
    pub hz: f64,
    /// Admittance, S.
    pub siemens: Complex64,
    /// Change of the admittance during the tone, S.
    pub change: f64,
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
    pub fn from_tones(mut tones: Vec<Tone>, volts: f64, (code_v, code_a): (f64, f64)) -> Self {
        tones.sort_by(|a, b| a.hz.total_cmp(&b.hz));
        let mut steady = tones.clone();
        steady.sort_by(|a, b| a.change.total_cmp(&b.change));
        steady.truncate(tones.len() / 2 + 1);
        let capacitance_f = median(steady.iter().map(|tone| tone.farads().re));
        let noise_siemens = NOISE_CODES * code_a.hypot(code_v * median(tones.iter().map(|tone| tone.siemens.norm()))) / volts;
        Load { tones, capacitance_f, volts, noise_siemens }
    }

    /// Returns the median frequency, Hz.
    pub fn middle_hz(&self) -> f64 {
        median(self.tones.iter().map(|tone| tone.hz))
    }

    /// Returns the mean complex capacitance, F. Noise, with a phase that differs from tone to tone,
    /// averages out.
    fn mean_farads(&self) -> Complex64 {
        self.tones.iter().map(Tone::farads).sum::<Complex64>() / self.tones.len() as f64
    }

    /// Returns the magnitude of the mean admittance at the middle frequency, S.
    pub fn mean_siemens(&self) -> f64 {
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
    pub fn ringing(&self) -> Option<f64> {
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
    pub fn degrees(&self) -> f64 {
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
            // Beyond a right angle from a resistance, one of the channels is inverted.
            degrees if !(-CAPACITIVE_DEGREES..=180.0 - CAPACITIVE_DEGREES).contains(&degrees) => {
                format!("{LAGGING_CURRENT}. There is {none}")
            }
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

/// Returns the median of finite values; NaN if there are none.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    quantile(&ascending(values.filter(|value| value.is_finite())), 0.5).unwrap_or(f64::NAN)
}
