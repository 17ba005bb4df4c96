//! The clamped branch at power-on, from tones beside the resonance: before anything has rung up, whatever the resonance is.
//!
//! What a tracker must know before it starts is the clamped branch `Y0` and the direction of the motional admittance, both as the converters
//! see them. A clamped capacitance that is wrong by `e`, and a sensing chain that turns by `a` more than was thought, move the lock point by
//!
//! ```text
//! df = fs / (2 Q) (e / M + a),    M = 1 / (w C0 Rm)
//! ```
//!
//! which at 40 kHz and C0 / Cm = 15 is 7.5 Hz per % and 2.5 Hz per 10 ns at Q 20, 0.7 Hz and 0.8 Hz at Q 65.
//!
//! Eight tones, four on each side of the window in which the resonance may be, each of 200 periods. Each tone rises and falls; what
//! its start leaves ringing at the resonance is beside the tone, and a Hann window over the tone does not see it: nothing waits for a ring-down,
//! whatever Q is. A `model` of the whole admittance is then fitted, one admittance a block, while the drive is silent.
//!
//! What images of the DAC add to C0 changes with the frequency; between both sides it is right at the resonance. A second resonance that one
//! cannot explain is fitted as such; what then is left makes the stated deviations larger.

pub(crate) mod fit;
pub(crate) mod model;
pub mod online;
pub(crate) mod reading;

use crate::find::clamped::fit::{Fit, MAX_POINTS, Point, Solution};
use crate::find::clamped::reading::Deviations;
pub use crate::find::clamped::reading::{Clamped, Measured};
use crate::find::damage::{Damage, damage};
use crate::generate::shape::sine;
use crate::generate::step::Step;
use crate::seam::block::LATENCY_BLOCKS;
use crate::seam::config::Config;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::seam::phasor::Phasor;
use crate::sense::demod::Sensed;

const TAU: f32 = core::f32::consts::TAU;

/// Distance of the nearest tones from the window's end, and of the others from the nearest, below and above; relative to the nominal frequency.
/// Nearest first: what a tone leaves ringing is then the least at the end. Above there is room for a second resonance at +7 %.
const NEAREST: f32 = 0.0213;
const BELOW: [f32; 4] = [0.0, 0.0279, 0.0713, 0.1297];
const ABOVE: [f32; 4] = [0.0, 0.0717, 0.1131, 0.1711];
/// The highest tone, as a part of the sample rate.
const HIGHEST: f32 = 0.4;
/// Periods of a tone, and the part of them in which it rises, and in which it falls.
const TONE_PERIODS: f32 = 200.0;
const EDGE: f32 = 0.2;
/// Least noise of a sense channel that is reckoned with, codes squared: one code of each of two conversions.
const LEAST_NOISE: f32 = 2.25;
/// What the model leaves at best, relative to the clamped susceptance: ringing, rounding.
const FLOOR: f32 = 3e-4;
/// How far the capacitance may be from its nominal value, with a nominal inductance that agrees, and without one; and how far with a coupling that has gone as
/// well, as that of a stack that has depoled: with an inductance so many times the nominal one at least, or without a resonance that stands out.
const CAPACITANCE_SHIFT: (f32, f32) = (0.4, 0.3);
const DEPOLED: (f32, f32) = (0.2, 5.0);
/// Smallest Q, relative to the nominal one, that a scan is left to look at: between a crack's fifth and the third that a nominal Q may be too high by.
const CRACKED_Q: f32 = 0.27;
/// Smallest Q, relative to the one that was tracked before, which a load may have lowered by three.
const FALLEN_Q: f32 = 0.3;
/// Rms of what two resonances leave, in standard deviations, beyond which the transducer is not one that could be tracked. Healthy ones leave 4 at most.
const LARGEST_MISFIT: f32 = 20.0;
/// Deviation of the motional phase at the lock point, rad, beyond which there is nothing to lock to. Healthy transducers leave 2e-3 at most.
const LARGEST_TURN: f32 = 0.1;
/// Deviations of the strength of the resonance that it must have: noise alone makes one of four.
const SIGNIFICANT: f32 = 10.0;
/// Deviations that a judgement leaves room for.
const SIGMAS: f32 = 3.0;

/// Why the measurement says nothing to begin on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Refused {
    /// It tells that there is something wrong.
    Fault(Fault),
    /// It does not tell: no resonance stands out, two do not explain it, it seems to be outside the window, or much as that of a crack. A scan looks at the resonance itself, and takes longer.
    Unclear,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Tones,
    Fit,
    Judge,
    Report,
    Over,
}

/// The calibration, in progress.
#[derive(Clone, Debug)]
pub struct PowerOn {
    nominal_hz: f32,
    /// The capacitance that all is relative to, F, and whether it is the nominal one.
    c0_f: f32,
    is_nominal: bool,
    nominal_q: f32,
    nominal_lm_h: Option<f32>,
    /// Where the resonance may be, relative to the nominal frequency, with what the estimate may be off by.
    window: f32,
    volts: f32,
    /// Variance of a current and of a voltage, relative to what the scan voltage makes of the capacitance, of one part of a block's phasor.
    noise: (f32, f32),
    /// The least variances of the same that are reckoned with, of a voltage and of a current, V² and A².
    least_noise: (f32, f32),
    offsets: [f32; MAX_POINTS],
    tone_blocks: u32,
    stage: Stage,
    block: u32,
    iv: Phasor,
    vv: f32,
    fit: Fit,
    deviations: Deviations,
    verdict: Option<Result<Clamped, Refused>>,
    /// A transducer that looks like none, or like a broken one, is measured once more: a resonance that comes back in the middle of the
    /// measurement makes it look so.
    twice: bool,
    /// Q of the resonance that was lost.
    tracked_q: Option<f32>,
}

impl PowerOn {
    /// A calibration by the configured drive and window, which the scan has checked.
    pub fn build(config: &Config) -> Self {
        let (drive, tracking) = (&config.drive, &config.tracking);
        let block_periods = drive.frequency_hz * f32::from(config.block_samples) / config.sample_hz;
        let nearest = tracking.span + NEAREST;
        let square = |x: f32| x * x;
        let per_block = LEAST_NOISE / f32::from(config.block_samples);
        let highest = HIGHEST * config.sample_hz / drive.frequency_hz - 1.0;
        PowerOn {
            nominal_hz: drive.frequency_hz,
            c0_f: tracking.c0_f(),
            is_nominal: tracking.nominal_c0_f.is_some(),
            nominal_q: tracking.nominal_q,
            nominal_lm_h: tracking.nominal_lm_h,
            window: tracking.span + 0.5 * NEAREST,
            volts: drive.scan_volts,
            least_noise: (per_block * square(config.front_end.volt_per_lsb), per_block * square(config.front_end.ampere_per_lsb)),
            noise: (0.0, 0.0),
            // Below and above in turns.
            offsets: core::array::from_fn(|n| match n % 2 {
                0 => -nearest - BELOW[n / 2],
                _ => (nearest + ABOVE[n / 2]).min(highest),
            }),
            tone_blocks: (TONE_PERIODS / block_periods) as u32 + 1,
            stage: Stage::Tones,
            block: 0,
            iv: Phasor::default(),
            vv: 0.0,
            fit: Fit::new(1.0 / tracking.nominal_q, drive.frequency_hz),
            deviations: Deviations::default(),
            verdict: None,
            twice: false,
            tracked_q: None,
        }
    }

    /// Begins for a resonance that was lost, which had this Q: what looks like none, or like a broken one, is measured once more.
    pub(crate) fn begin_twice(&mut self, tracked_q: Option<f32>) {
        self.restart();
        (self.twice, self.tracked_q) = (true, tracked_q);
    }

    /// Begins again.
    pub(crate) fn restart(&mut self) {
        (self.twice, self.tracked_q) = (false, None);
        (self.stage, self.block) = (Stage::Tones, 0);
        (self.iv, self.vv) = (Phasor::default(), 0.0);
        self.fit = Fit::new(1.0 / self.nominal_q, self.nominal_hz);
        self.deviations.restart();
    }

    /// Takes the variances of the phasors of a block's voltage and current by noise, both components, V² and A²; and a capacitance to reckon with, F,
    /// where there is no nominal one.
    pub(crate) fn prepare(&mut self, (v, i): (f32, f32), c0_f: Option<f32>) {
        self.c0_f = c0_f.unwrap_or(self.c0_f);
        let amperes = self.volts * TAU * self.nominal_hz * self.c0_f;
        let relative = |variance: f32, least: f32, whole: f32| (0.5 * variance).max(least) / (whole * whole);
        self.noise = (relative(i, self.least_noise.1, amperes), relative(v, self.least_noise.0, self.volts));
    }

    /// The clamped branch, once it is measured: from the last silent block on.
    pub fn found(&self) -> Option<&Clamped> {
        let is_over = self.stage == Stage::Over;
        self.verdict.as_ref().filter(|_| is_over).and_then(|verdict| verdict.as_ref().ok())
    }

    /// Takes the phasors of the measured block and returns the next step.
    pub fn listen(&mut self, sensed: &Sensed) -> Step {
        match self.stage {
            Stage::Tones => {
                if let Some(block) = self.block.checked_sub(LATENCY_BLOCKS as u32) {
                    self.update(block, sensed);
                }
                let tone = (self.block / self.tone_blocks) as usize;
                self.block += 1;
                if self.block == self.tone_blocks * MAX_POINTS as u32 + LATENCY_BLOCKS as u32 {
                    self.stage = Stage::Fit;
                }
                match self.offsets.get(tone) {
                    Some(offset) => Step::Tone { offset_hz: offset * self.nominal_hz, volts: self.volts * self.level(), lane: 0 },
                    None => Step::Silence,
                }
            }
            Stage::Fit => {
                if self.fit.advance() {
                    self.stage = Stage::Judge;
                }
                Step::Silence
            }
            Stage::Judge => {
                match self.fit.solution() {
                    // What follows from it takes a block of its own.
                    Some(solution) if self.deviations.read_on(solution) => {
                        (self.stage, self.verdict) = (Stage::Report, Some(self.judge(solution)));
                    }
                    Some(_) => {}
                    None => (self.stage, self.verdict) = (Stage::Report, None),
                }
                Step::Silence
            }
            Stage::Report => {
                self.stage = Stage::Over;
                match self.verdict {
                    Some(Err(Refused::Unclear | Refused::Fault(Fault::NoResonance | Fault::ResonanceDamaged))) if self.twice => {
                        let tracked_q = self.tracked_q;
                        self.restart();
                        self.tracked_q = tracked_q;
                        Step::Silence
                    }
                    Some(Err(Refused::Unclear)) => Step::Instead(Mode::Scan),
                    Some(Err(Refused::Fault(fault))) => Step::Failed(fault),
                    _ => Step::Silence,
                }
            }
            Stage::Over => Step::Done { volts: self.volts },
        }
    }

    /// Amplitude of the tone in the block that is about to be ordered, relative to the scan voltage.
    fn level(&self) -> f32 {
        let part = ((self.block - 1) % self.tone_blocks) as f32 / self.tone_blocks as f32;
        hann((part.min(1.0 - part) / (2.0 * EDGE)).min(0.5))
    }

    fn update(&mut self, block: u32, sensed: &Sensed) {
        let within = block % self.tone_blocks;
        let weight = hann((within as f32 + 0.5) / self.tone_blocks as f32);
        self.iv += sensed.i * sensed.v.conj() * weight;
        self.vv += sensed.v.norm_sqr() * weight;
        if within + 1 < self.tone_blocks {
            return;
        }
        let (iv, vv) = (core::mem::take(&mut self.iv), core::mem::take(&mut self.vv));
        let x = self.offsets[((block / self.tone_blocks) as usize).min(MAX_POINTS - 1)];
        let y = iv / (vv * TAU * self.nominal_hz * self.c0_f);
        let square = |x: f32| x * x;
        // A Hann window passes as much noise as two thirds of its length without.
        let noise = 1.5 * (self.noise.0 + y.norm_sqr() * self.noise.1) / self.tone_blocks as f32;
        self.fit.add(Point { x, y, deviation: libm::sqrtf(noise + square(FLOOR)) });
    }

    fn judge(&self, solution: &Solution) -> Result<Clamped, Refused> {
        let found = reading::read(solution, &self.deviations, self.nominal_hz, self.c0_f);
        let q_at_most = found.q.value + SIGMAS * found.q.deviation;
        let company = found.second_mode.map(|(hz, strength)| (hz / found.resonance_hz.value - 1.0, strength));
        let damage = if self.is_nominal { damage(q_at_most / self.nominal_q, company) } else { Damage::None };
        let cracked = damage == Damage::Certain && q_at_most < CRACKED_Q * self.nominal_q;
        let fallen = cracked || self.tracked_q.is_some_and(|q| q_at_most < FALLEN_Q * q);
        let shift = ((found.c0_f.value - self.c0_f).abs() - SIGMAS * found.c0_f.deviation) / self.c0_f;
        let turn = 2.0 * found.lock_deviation_hz * found.q.value / found.resonance_hz.value;
        let explained = fit::is_plausible(&solution.elements) && solution.misfit < LARGEST_MISFIT;
        // What is no number does not hold, either.
        let resonates = found.lm_h.value > SIGNIFICANT * found.lm_h.deviation;
        let most_strength = 1.0 + SIGMAS * found.lm_h.deviation / found.lm_h.value;
        let uncoupled = self.nominal_lm_h.map_or(!resonates, |nominal| found.lm_h.value > DEPOLED.1 * nominal * most_strength);
        let alone = if self.nominal_lm_h.is_some() { CAPACITANCE_SHIFT.0 } else { CAPACITANCE_SHIFT.1 };
        let shifted = shift > if uncoupled { DEPOLED.0 } else { alone };
        let holds = explained && resonates && turn < LARGEST_TURN;
        match () {
            () if resonates && (found.resonance_hz.value / self.nominal_hz - 1.0).abs() > self.window => Err(Refused::Unclear),
            () if explained && shifted && self.is_nominal => Err(Refused::Fault(Fault::CapacitanceShifted)),
            // Two that are near share their strength in many ways, and are as lossy in all of them.
            () if explained && fallen => Err(Refused::Fault(Fault::ResonanceDamaged)),
            () if !holds || damage != Damage::None => Err(Refused::Unclear),
            () => Ok(found),
        }
    }
}

/// `(1 - cos(2 pi part)) / 2`.
fn hann(part: f32) -> f32 {
    0.5 - 0.5 * sine::rotation(((part * 4_294_967_296.0) as u64) << 32).re
}
