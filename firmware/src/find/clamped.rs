//! Measurement of the clamped branch at power-on, from tones off resonance. It needs no ring-up and
//! does not depend on the exact resonance.
//!
//! Before it starts, a tracker must know the clamped branch `Y0` and the direction of the motional
//! admittance, both as measured by the converters. A relative error `e` of the clamped capacitance
//! and an error `a` of the phase of the sensing chain shift the lock point by
//!
//! ```text
//! df = fs / (2 Q) (e / M + a),    M = 1 / (w C0 Rm)
//! ```
//!
//! At 40 kHz and C0 / Cm = 15 this is 7.5 Hz per % and 2.5 Hz per 10 ns at Q 20, and 0.7 Hz
//! and 0.8 Hz at Q 65.
//!
//! Eight tones of 200 periods are driven, four on each side of the window of possible resonances.
//! Each tone rises and falls. Its start makes the resonance ring, but at another frequency, which a
//! Hann window over the tone suppresses. No ring-down is needed at any Q. A `model` of the whole
//! admittance is then fitted, one admittance per block, while the drive is silent.
//!
//! Images of the DAC add a capacitance that changes with frequency; between the two sides, at the
//! resonance, it is correct. A second resonance is fitted if one does not explain the measurement.
//! The remaining residual increases the stated deviations.

pub(crate) mod fit;
pub(crate) mod model;
pub mod online;
pub(crate) mod reading;

use crate::find::clamped::fit::{Fit, MAX_POINTS, Point, Solution};
use crate::find::clamped::model::D2;
use crate::find::clamped::reading::Deviations;
pub use crate::find::clamped::reading::{Clamped, Measured};
use crate::find::damage::{Damage, damage};
use crate::generate::shape::sine;
use crate::generate::step::Step;
use crate::seam::block::LATENCY_BLOCKS;
use crate::seam::compare::larger;
use crate::seam::config::Config;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::seam::phasor::Phasor;
use crate::sense::demod::Sensed;

const TAU: f32 = core::f32::consts::TAU;

/// Distance of the nearest tones from the end of the window, relative to the nominal frequency.
const NEAREST_REL: f32 = 0.0213;
/// Distance of the tones below the window from the nearest one, relative to the nominal frequency.
/// The nearest come first, so that their ringing has decayed most at the end.
const BELOW_REL: [f32; 4] = [0.0, 0.0279, 0.0713, 0.1297];
/// Distance of the tones above the window from the nearest one, relative to the nominal frequency.
/// The gap leaves room for a second resonance at +7 %.
const ABOVE_REL: [f32; 4] = [0.0, 0.0717, 0.1131, 0.1711];
/// Maximum frequency of a tone, relative to the sample rate.
const MAX_TONE_REL: f32 = 0.4;
/// Periods of a tone.
const TONE_PERIODS: f32 = 200.0;
/// Part of a tone in which it rises, and in which it falls.
const EDGE_PART: f32 = 0.2;
/// Minimum noise variance assumed for a sense channel, codes squared: one code in each of two
/// conversions.
const MIN_NOISE_CODES2: f32 = 2.25;
/// Minimum residual of the model (ringing, rounding), relative to the clamped susceptance.
const MIN_RESIDUAL_REL: f32 = 3e-4;
/// Maximum relative deviation of the capacitance from its nominal value, with a nominal inductance.
const MAX_SHIFT_REL: f32 = 0.4;
/// Maximum relative deviation of the capacitance without a nominal inductance.
const MAX_SHIFT_WITHOUT_LM_REL: f32 = 0.3;
/// Maximum relative deviation of the capacitance of a depoled stack.
const MAX_SHIFT_DEPOLED_REL: f32 = 0.2;
/// Ratio of the motional inductance to the nominal one above which a stack is depoled. Without a
/// nominal inductance, a stack without a significant resonance is depoled.
const DEPOLED_LM_RATIO: f32 = 5.0;
/// Q relative to the nominal one below which damage is reported without a scan. It lies between the
/// fifth left by a crack and the third of a nominal Q that is too high.
const CRACKED_Q_REL: f32 = 0.27;
/// Minimum Q relative to the one tracked before; a load may reduce it to a third.
const FALLEN_Q_REL: f32 = 0.3;
/// Maximum rms residual of two resonances, in standard deviations. Healthy transducers reach 4;
/// beyond this limit a transducer cannot be tracked.
const MAX_MISFIT_SIGMAS: f32 = 20.0;
/// Maximum relative deviation of Q with which damage is reported without a scan. That of a crack is
/// below 1.3 %; resonances that the tones cannot separate make a Q that is low, but less certain.
const CERTAIN_Q_REL: f32 = 0.02;
/// Maximum misfit with which damage is reported without a scan, standard deviations.
const CERTAIN_MISFIT_SIGMAS: f32 = 8.0;
/// Maximum standard deviation of the motional phase at the lock point, rad. Healthy transducers
/// reach 2e-3; beyond this limit there is no usable lock point.
const MAX_PHASE_DEVIATION_RAD: f32 = 0.1;
/// Minimum strength of the resonance, in standard deviations; noise alone reaches four.
const MIN_STRENGTH_SIGMAS: f32 = 10.0;
/// Shortest time constant of a resonance, blocks, that the observer tracks: a shorter ring-down
/// ends within the block. The phase loop then tracks the resonance that a scan has found.
pub(crate) const MIN_OBSERVED_BLOCKS: f32 = 0.65;
/// Margin of a judgement, in standard deviations.
const MARGIN_SIGMAS: f32 = 3.0;

/// Reason why the measurement cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Refused {
    /// The transducer is faulty.
    Fault(Fault),
    /// The measurement is inconclusive: there is no significant resonance, two resonances do not
    /// explain it or the second is the stronger one, the resonance is outside the window, it
    /// resembles that of a crack, or it decays too fast for the observer. A scan, which takes
    /// longer, measures at the resonance itself.
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

/// Measurement of the clamped branch at power-on, in progress.
#[derive(Clone, Debug)]
pub struct PowerOn {
    nominal_hz: f32,
    /// Reference capacitance, F.
    c0_f: f32,
    /// `true` if the reference is a configured nominal capacitance.
    is_nominal: bool,
    nominal_q: f32,
    nominal_lm_h: Option<f32>,
    /// Half-width of the range of plausible resonances, relative to the nominal frequency.
    window: f32,
    volts: f32,
    /// Noise variance per component of a block's phasor: of the current and of the voltage,
    /// relative to their values for the capacitance at the scan voltage.
    noise: (f32, f32),
    /// Minimum noise variance per component: of the voltage, V², and of the current, A².
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
    /// Clamped capacitance as the tones show it, F, even if the rest is inconclusive.
    pub(crate) shown_c0_f: Option<f32>,
    /// `true` if an apparently missing or damaged resonance is measured once more. A resonance that
    /// returns during the measurement looks like that.
    repeats: bool,
    /// Quality factor of the resonance before it was lost.
    tracked_q: Option<f32>,
}

impl PowerOn {
    /// Creates the measurement for the configured drive and window, which the scan has checked.
    pub fn build(config: &Config) -> Self {
        let (drive, tracking) = (&config.drive, &config.tracking);
        let block_periods = drive.frequency_hz * f32::from(config.block_samples) / config.sample_hz;
        let nearest = tracking.span + NEAREST_REL;
        let square = |x: f32| x * x;
        let per_block = MIN_NOISE_CODES2 / f32::from(config.block_samples);
        let highest = MAX_TONE_REL * config.sample_hz / drive.frequency_hz - 1.0;
        PowerOn {
            nominal_hz: drive.frequency_hz,
            c0_f: tracking.c0_f(),
            is_nominal: tracking.nominal_c0_f.is_some(),
            nominal_q: tracking.nominal_q,
            nominal_lm_h: tracking.nominal_lm_h,
            window: tracking.span + 0.5 * NEAREST_REL,
            volts: drive.scan_volts,
            least_noise: (per_block * square(config.front_end.volt_per_lsb), per_block * square(config.front_end.ampere_per_lsb)),
            noise: (0.0, 0.0),
            // Alternately below and above.
            offsets: core::array::from_fn(|n| match n % 2 {
                0 => -nearest - BELOW_REL[n / 2],
                _ => (nearest + ABOVE_REL[n / 2]).min(highest),
            }),
            tone_blocks: (TONE_PERIODS / block_periods) as u32 + 1,
            stage: Stage::Tones,
            block: 0,
            iv: Phasor::default(),
            vv: 0.0,
            fit: Fit::new(1.0 / tracking.nominal_q, drive.frequency_hz),
            deviations: Deviations::default(),
            verdict: None,
            shown_c0_f: None,
            repeats: false,
            tracked_q: None,
        }
    }

    /// Starts after the loss of a resonance with this Q. An apparently missing or damaged resonance
    /// is then measured once more.
    pub(crate) fn begin_twice(&mut self, tracked_q: Option<f32>) {
        self.restart();
        (self.repeats, self.tracked_q) = (true, tracked_q);
    }

    /// Starts again.
    pub(crate) fn restart(&mut self) {
        (self.repeats, self.tracked_q, self.shown_c0_f) = (false, None, None);
        (self.stage, self.block) = (Stage::Tones, 0);
        (self.iv, self.vv) = (Phasor::default(), 0.0);
        self.fit = Fit::new(1.0 / self.nominal_q, self.nominal_hz);
        self.deviations.restart();
    }

    /// Sets the noise variances (both components) of a block's voltage and current phasors, V² and
    /// A², and a reference capacitance, F, when no nominal value is configured.
    pub(crate) fn prepare(&mut self, (v, i): (f32, f32), c0_f: Option<f32>) {
        self.c0_f = c0_f.unwrap_or(self.c0_f);
        let amperes = self.volts * TAU * self.nominal_hz * self.c0_f;
        let relative = |variance: f32, least: f32, whole: f32| (0.5 * variance).max(least) / (whole * whole);
        self.noise = (relative(i, self.least_noise.1, amperes), relative(v, self.least_noise.0, self.volts));
    }

    /// Returns the clamped branch once it is measured, from the last silent block on.
    pub fn found(&self) -> Option<&Clamped> {
        let is_over = self.stage == Stage::Over;
        self.verdict.as_ref().filter(|_| is_over).and_then(|verdict| verdict.as_ref().ok())
    }

    /// Processes the phasors of the measured block and returns the next step.
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
                    Some(offset) => {
                        Step::Tone { offset_hz: offset * self.nominal_hz, volts: self.volts * self.envelope(), lane: 0 }
                    }
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
                    // The verdict takes a block of its own.
                    Some(solution) if self.deviations.advance(solution) => {
                        let found = reading::read(solution, &self.deviations, self.nominal_hz, self.c0_f);
                        self.shown_c0_f = fit::is_plausible(&solution.elements).then_some(found.c0_f.value);
                        (self.stage, self.verdict) = (Stage::Report, Some(self.judge(solution, &found).map(|()| found)));
                    }
                    Some(_) => {}
                    None => (self.stage, self.verdict) = (Stage::Report, None),
                }
                Step::Silence
            }
            Stage::Report => {
                self.stage = Stage::Over;
                match self.verdict {
                    Some(Err(Refused::Unclear | Refused::Fault(Fault::NoResonance | Fault::ResonanceDamaged)))
                        if self.repeats =>
                    {
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

    /// Returns the minimum Q with which the observer tracks, from the length of a tone in blocks.
    fn least_q(&self) -> f32 {
        MIN_OBSERVED_BLOCKS * core::f32::consts::PI * TONE_PERIODS / self.tone_blocks as f32
    }

    /// Returns the amplitude of the tone in the block to be ordered next, relative to the scan
    /// voltage.
    fn envelope(&self) -> f32 {
        let part = ((self.block - 1) % self.tone_blocks) as f32 / self.tone_blocks as f32;
        hann((part.min(1.0 - part) / (2.0 * EDGE_PART)).min(0.5))
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
        // The noise bandwidth of a Hann window is 1.5 times that of a rectangular one.
        let noise = 1.5 * (self.noise.0 + y.norm_sqr() * self.noise.1) / self.tone_blocks as f32;
        self.fit.add(Point { x, y, deviation: fpu::sqrtf(noise + square(MIN_RESIDUAL_REL)) });
    }

    fn judge(&self, solution: &Solution, found: &Clamped) -> Result<(), Refused> {
        let q_at_most = found.q.value + MARGIN_SIGMAS * found.q.deviation;
        let damage = if self.is_nominal { damage(q_at_most / self.nominal_q) } else { Damage::None };
        let clear = found.q.deviation < CERTAIN_Q_REL * found.q.value && solution.misfit < CERTAIN_MISFIT_SIGMAS;
        let strongest = found.second_mode.map_or(1.0, |(_, strength)| strength.max(1.0));
        // Both modes of a cracked stack have a low Q. If only the weaker one has it, the stack is
        // healthy.
        let stronger_q = if strongest > 1.0 { 1.0 / solution.elements[D2] } else { 0.0 };
        let cracked = damage == Damage::Certain && clear && larger(q_at_most, stronger_q) < CRACKED_Q_REL * self.nominal_q;
        let fallen = cracked || self.tracked_q.is_some_and(|q| q_at_most < FALLEN_Q_REL * q);
        let shift = ((found.c0_f.value - self.c0_f).abs() - MARGIN_SIGMAS * found.c0_f.deviation) / self.c0_f;
        let turn = 2.0 * found.lock_deviation_hz * found.q.value / found.resonance_hz.value;
        let explained = fit::is_plausible(&solution.elements) && solution.misfit < MAX_MISFIT_SIGMAS;
        // Written so that a NaN inductance counts as no resonance.
        let resonates = found.lm_h.value > MIN_STRENGTH_SIGMAS * found.lm_h.deviation;
        let most_strength = 1.0 + MARGIN_SIGMAS * found.lm_h.deviation / found.lm_h.value;
        let uncoupled = self
            .nominal_lm_h
            .map_or(!resonates, |nominal| found.lm_h.value > DEPOLED_LM_RATIO * nominal * most_strength * strongest);
        let alone = if self.nominal_lm_h.is_some() { MAX_SHIFT_REL } else { MAX_SHIFT_WITHOUT_LM_REL };
        let shifted = shift > if uncoupled { MAX_SHIFT_DEPOLED_REL } else { alone };
        let holds = explained && resonates && turn < MAX_PHASE_DEVIATION_RAD;
        match () {
            () if resonates && (found.resonance_hz.value / self.nominal_hz - 1.0).abs() > self.window => Err(Refused::Unclear),
            () if explained && shifted && self.is_nominal => Err(Refused::Fault(Fault::CapacitanceShifted)),
            // Two close resonances share their strength in many ways, all with the same loss.
            () if explained && fallen => Err(Refused::Fault(Fault::ResonanceDamaged)),
            () if !holds || strongest > 1.0 || damage != Damage::None || q_at_most < self.least_q() => Err(Refused::Unclear),
            () => Ok(()),
        }
    }
}

/// Computes the Hann window `(1 - cos(2 pi part)) / 2`.
fn hann(part: f32) -> f32 {
    0.5 - 0.5 * sine::rotation(((part * 4_294_967_296.0) as u64) << 32).re
}
