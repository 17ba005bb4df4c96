//! Bound of resonance tracking: the minimum error with which voltage and current determine the
//! series resonance, and the time needed.
//!
//! ```text
//! circuit, drive, start --> response (exact current, derivatives) --> information (sum over samples + prior) --> bound
//!                                                                            |
//!                                                                            +--> ramp: lag against jitter
//! ```
//!
//! This is the Cramer-Rao bound of a stack (Butterworth 1914, Van Dyke 1928) driven at its
//! terminals by a sine of constant frequency. Converters with white noise measure its voltage and
//! current. Resonance, Q, Lm and C0 are unknown, each with its prior. Amplitude and phase of the
//! voltage are either known (a calibrated amplifier) or also measured by a converter. The bound
//! does not depend on the firmware.
//!
//! The bound holds for unbiased estimates of constants. An estimate that is drawn towards its prior
//! is not better on average (van Trees 1968). The model excludes further modes, converter offsets,
//! skew and aliases, and a drive that follows the estimate.

mod information;
mod ramp;
mod response;

#[cfg(test)]
mod tests;

use realfft::num_complex::Complex64;

pub use information::Knowledge;
pub use ramp::{Compromise, ramp, ramp_with_slope};

use information::Information;
use plant::circuit::Circuit;
use plant::circuit_of;
use response::{PARAMETERS, Parameter, Response};
use scene::{Driven, Sensors, Transducer};

/// Beginning of a curve, s.
const FIRST_S: f64 = 25e-6;
/// End of a curve, s.
const LAST_S: f64 = 5e-3;
/// Number of points of a curve.
const POINTS: u32 = 60;
/// Maximum time to reach an accuracy, s.
const LONGEST_S: f64 = 20e-3;
/// Number of standard deviations to either side that contain 95 % of a Gaussian distribution.
pub const DEVIATIONS_95: f64 = 1.96;

/// A sinusoidal voltage at the terminals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Peak voltage of the drive, V.
    pub volts: f64,
    /// Frequency of the drive, Hz.
    pub hz: f64,
    /// Phase of the cosine at t = 0, rad; minus a quarter turn is a sine, which begins at zero.
    pub phase_rad: f64,
}

impl Drive {
    fn phasor(&self) -> Complex64 {
        Complex64::from_polar(self.volts, self.phase_rad)
    }
}

/// State of the stack at t = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// At rest when the drive begins.
    Rest,
    /// Driven until settled.
    Settled,
    /// Driven with this circuit and measured until settled: its total current is known, and its
    /// motional current as accurately as C0.
    Jump(Circuit),
}

/// Prior knowledge of each parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PriorKnowledge {
    /// Prior of the series resonance, Hz.
    pub resonance_hz: Knowledge,
    /// Prior of the logarithm of Q.
    pub q: Knowledge,
    /// Prior of Lm, relative.
    pub lm: Knowledge,
    /// Prior of C0, relative.
    pub c0: Knowledge,
    /// Prior of the voltage, relative, and of its phase, rad. An unknown voltage is measured.
    pub voltage: Knowledge,
    /// Prior of the motional current and charge at t = 0, as currents, A. `Unknown` denotes a
    /// window of a continuing drive.
    pub state: Knowledge,
}

impl PriorKnowledge {
    /// No priors, except that initial state and drive are known.
    pub const NONE: Self = PriorKnowledge {
        resonance_hz: Knowledge::Unknown,
        q: Knowledge::Unknown,
        lm: Knowledge::Unknown,
        c0: Knowledge::Unknown,
        voltage: Knowledge::Known,
        state: Knowledge::Known,
    };
    /// As [`Self::NONE`], but Lm and C0 are known.
    pub const LM_AND_C0: Self = PriorKnowledge { lm: Knowledge::Known, c0: Knowledge::Known, ..PriorKnowledge::NONE };

    /// Returns the prior of a stack before a cold start: its resonance within `span` (relative) of
    /// the nominal one, Q within a factor of two, Lm within 10 %, and C0 within 0.25 %, because it
    /// has been calibrated. The voltage is measured.
    pub fn cold(nominal_hz: f64, span: f64) -> Self {
        PriorKnowledge {
            resonance_hz: Knowledge::either_side(nominal_hz * span),
            q: Knowledge::either_side(2f64.ln()),
            lm: Knowledge::either_side(0.1),
            c0: Knowledge::either_side(0.0025),
            voltage: Knowledge::Unknown,
            state: Knowledge::Known,
        }
    }

    fn of_each(&self) -> [Knowledge; PARAMETERS] {
        let (voltage, state) = (self.voltage, self.state);
        [self.resonance_hz, self.q, self.lm, self.c0, voltage, voltage, state, state, Knowledge::Known]
    }
}

/// An experiment: driven circuit, sampling and priors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// True circuit of the stack.
    pub circuit: Circuit,
    /// Voltage that drives the stack.
    pub drive: Drive,
    /// State of the stack at t = 0.
    pub start: Start,
    /// Sample rate of the converters, Hz.
    pub sample_hz: f64,
    /// Length of a block, s.
    pub block_s: f64,
    /// Noise of a sample of the current, A rms.
    pub current_noise_a: f64,
    /// Noise of a sample of the voltage, V rms.
    pub voltage_noise_v: f64,
    /// Prior knowledge of each parameter.
    pub prior: PriorKnowledge,
}

/// Returns the noise of a sample, the mean of its conversions, in the unit of `full_scale`: that of
/// the converter and of rounding.
pub fn noise(sensors: &Sensors, full_scale: f64) -> f64 {
    let lsb = full_scale / f64::from(1u32 << (sensors.adc_bits - 1));
    lsb * ((sensors.noise_lsb.powi(2) + 1.0 / 12.0) / f64::from(sensors.oversample)).sqrt()
}

impl Setting {
    /// Creates a cold start of a scene's stack, driven at the nominal frequency from rest. `None`
    /// for a stator, or if the scene gives no voltage.
    ///
    /// The amplifier's source resistance is added to the stack's own resistance. The current of C0
    /// through it is neglected (`omega C0 R`: 2 % at 0.3 ohm, 300 nF and 40 kHz).
    pub fn from_scene(scene: &Driven) -> Option<Setting> {
        let Transducer::Stack(..) = scene.transducer else { return None };
        let (drive, tracking, sensors) = (&scene.controller.drive, &scene.controller.tracking, scene.sensors);
        let circuit = circuit_of(scene);
        let volts = drive.scan_v.or(drive.amplitude_v)?;
        Some(Setting {
            circuit: Circuit { rm_ohm: circuit.rm_ohm + scene.amplifier.source_ohm, ..circuit },
            drive: Drive { volts, hz: drive.frequency_hz, phase_rad: -std::f64::consts::FRAC_PI_2 },
            start: Start::Rest,
            sample_hz: sensors.sample_hz,
            block_s: f64::from(scene.controller.block_samples) / sensors.sample_hz,
            current_noise_a: noise(sensors, sensors.i_full_scale_a),
            voltage_noise_v: noise(sensors, sensors.v_full_scale_v),
            prior: PriorKnowledge::cold(drive.frequency_hz, tracking.span),
        })
    }

    /// Returns the information after each sample, without the priors, and its time, s.
    fn information(&self) -> impl Iterator<Item = (f64, Information)> {
        let response = Response::new(&self.circuit, &self.drive, &self.start);
        let (current, voltage) = (self.current_noise_a.powi(2), self.voltage_noise_v.powi(2));
        let (mut information, sample_hz) = (Information::default(), self.sample_hz);
        (1u32..).map(move |n| {
            let time_s = f64::from(n) / sample_hz;
            information.add(&response.current(time_s).1, current);
            let mut by = [0.0; PARAMETERS];
            [by[Parameter::Voltage as usize], by[Parameter::Phase as usize]] = response.voltage(time_s).1;
            information.add(&by, voltage);
            (time_s, information.clone())
        })
    }

    /// Returns the bound after each sample: time, s, and minimum error of the resonance, Hz rms;
    /// infinite as long as the samples do not determine it.
    fn bounds(&self) -> impl Iterator<Item = (f64, f64)> {
        let prior = self.prior.of_each();
        let mut weight = [0.0; PARAMETERS];
        weight[Parameter::Resonance as usize] = 1.0;
        self.information().map(move |(time_s, information)| (time_s, information.with(&prior).deviation(&weight, &prior)))
    }
}

/// Returns the minimum error of the resonance, Hz rms, against the time measured, s: from 25 us to
/// 5 ms with logarithmic spacing.
pub fn bound(setting: &Setting) -> Vec<(f64, f64)> {
    let step = (LAST_S / FIRST_S).powf(f64::from(POINTS - 1).recip());
    let mut times = (0..POINTS).map(|n| FIRST_S * step.powi(n as i32)).peekable();
    let (half_s, mut curve) = (0.5 / setting.sample_hz, Vec::with_capacity(POINTS as usize));
    for point in setting.bounds().take_while(|point| point.0 < LAST_S + half_s) {
        let mut is_asked = false;
        while times.next_if(|&time_s| time_s < point.0 + half_s).is_some() {
            is_asked = true;
        }
        if is_asked {
            curve.push(point);
        }
    }
    curve
}

/// Returns the minimum error of the resonance after a time, Hz rms; infinite if the samples do not
/// determine it by then.
pub fn bound_at(setting: &Setting, time_s: f64) -> f64 {
    let half_s = 0.5 / setting.sample_hz;
    setting.bounds().take_while(|point| point.0 < time_s + half_s).last().map_or(f64::INFINITY, |point| point.1)
}

/// Returns the minimum steady-state error of a window of this length, s, in Hz rms: from the phase
/// alone, without a transient.
pub fn steady(setting: &Setting, memory_s: f64) -> f64 {
    bound_at(&Setting { start: Start::Settled, ..*setting }, memory_s)
}

/// Returns the time after which the resonance can be played within `hz` at 95 %, s: the time to
/// measure it, and `latency_blocks` until the estimate is played. `None` if it exceeds 20 ms.
pub fn time_to(setting: &Setting, hz: f64, latency_blocks: f64) -> Option<f64> {
    let mut bounds = setting.bounds().take_while(|point| point.0 < LONGEST_S);
    bounds.find(|point| DEVIATIONS_95 * point.1 <= hz).map(|point| point.0 + latency_blocks * setting.block_s)
}
