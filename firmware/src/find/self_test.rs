//! Power-on plausibility, before any real drive: are both sense channels alive, and is there a transducer?
//!
//! First silence, until nothing rings any more; then the mean code of each channel is its offset, which must be small, and is
//! removed from then on. Then a tone well below the resonance, where the transducer is little more than its clamped capacitance: the current must lead
//! the voltage, the voltage must be what was played, the current what the nominal capacitance takes, each within a factor. Without a nominal
//! one the capacitance only has to be that of a transducer, and all that follows reckons with what was measured.
//!
//! It takes 96 blocks from silence, and 1000 and 40 nominal time constants more where something still rings. A swapped pair of channels is known
//! 4 blocks after the tone is measured, the rest at its end.

use crate::generate::step::Step;
use crate::seam::block::{LATENCY_BLOCKS, SenseBlock};
use crate::seam::config::{Config, Tracking};
use crate::seam::fault::Fault;
use crate::seam::phasor::{Phasor, magnitude};
use crate::sense::convert::Convert;
use crate::sense::demod::Sensed;
use crate::sense::source::LARGEST_OHM;

/// Blocks of silence that are averaged.
const SILENT_BLOCKS: u32 = 32;
/// Quiet: the current's rms about its mean is below this part of what the tone will draw, or below so many codes; or below so many more, and does not
/// fall any longer: that is noise.
const QUIET: (f32, f32, f32) = (0.25, 2.0, 16.0);
/// It falls if its mean square in one window is less than this part of that in the one before. A window has so many blocks at least, and half a nominal time
/// constant: in that what rings falls to 0.37 of its square, with three times the nominal Q to 0.72.
const FALLS: f32 = 0.85;
const WINDOW: (u32, f32) = (16, 0.5);
/// How long an earlier run may ring, nominal time constants and at least, in blocks. Q may be three times the nominal one.
const RING_DOWN: (f32, u32) = (40.0, 1000);
/// Blocks of the tone, and how many at its end are measured.
const TONE_BLOCKS: u32 = 64;
const MEASURED_BLOCKS: u32 = 16;
/// Blocks of the tone, from its first on, by whose phase swapped channels are recognized: before the guard finds the voltage implausible.
const PHASE_BLOCKS: u32 = 4;
/// Smallest amplitude whose phase is judged, codes: noise alone leaves a quarter of one.
const PHASE_CODES: f32 = 4.0;
/// The tone, relative to the nominal frequency and to the scan voltage.
const TONE_FREQUENCY: f32 = 0.85;
const TONE_AMPLITUDE: f32 = 0.5;
/// Largest offset, as a part of half the range.
const LARGEST_OFFSET: f32 = 0.05;
/// How far the voltage may be from what was played.
const VOLTAGE_FACTOR: f32 = 1.5;
/// How much less, and more, the current may be than what the nominal capacitance takes. By coupling alone it is `1 + k^2 / (1 - k^2) / (1 - 0.85^2)` times that,
/// 1.4 at k = 0.3 and 5.6 at 0.75; and the nominal capacitance may be off by 30 %. A short takes a hundred times as much.
const CURRENT_FACTORS: (f32, f32) = (3.0, 8.0);

/// The self-test, in progress.
#[derive(Clone, Debug)]
pub(crate) struct SelfTest {
    offset_hz: f32,
    volts: f32,
    /// Susceptance of the nominal capacitance, and the least and the largest of any transducer, S, at the tone's frequency.
    clamped_siemens: Option<f32>,
    any_siemens: (f32, f32),
    /// Capacitance that draws the tone's current, F.
    capacitance_f: f32,
    ring_down_blocks: u32,
    window_blocks: u32,
    /// Sums of mean squares in silence: of this window, and of the one before.
    heard: (f32, f32),
    /// Blocks of the present phase, and whether it is quiet.
    block: u32,
    quiet: bool,
    mean_codes: (f32, f32),
    sum: (f32, f32),
    /// The first blocks' voltage and current.
    first: (f32, f32),
    /// Their current against their voltage.
    lead: Phasor,
    /// Mean square of both channels in silence, codes.
    noise: (f32, f32),
}

impl SelfTest {
    /// A test by the configured drive and nominal capacitance.
    pub(crate) fn build(config: &Config) -> Self {
        let hz = config.drive.frequency_hz * TONE_FREQUENCY;
        let tau_s = config.tracking.nominal_q / (core::f32::consts::PI * config.drive.frequency_hz);
        let block_s = f32::from(config.block_samples) / config.sample_hz;
        let omega = core::f32::consts::TAU * hz;
        let (least_f, largest_f) = Tracking::CAPACITANCES_F;
        SelfTest {
            offset_hz: hz - config.drive.frequency_hz,
            volts: config.drive.scan_volts * TONE_AMPLITUDE,
            clamped_siemens: config.tracking.nominal_c0_f.map(|c0_f| omega * c0_f),
            any_siemens: (omega * least_f, omega * largest_f),
            capacitance_f: config.tracking.c0_f(),
            ring_down_blocks: RING_DOWN.1 + (RING_DOWN.0 * tau_s / block_s) as u32,
            window_blocks: WINDOW.0.max((WINDOW.1 * tau_s / block_s) as u32),
            heard: (0.0, f32::INFINITY),
            block: 0,
            quiet: false,
            mean_codes: (0.0, 0.0),
            sum: (0.0, 0.0),
            first: (0.0, 0.0),
            lead: Phasor::default(),
            noise: (0.0, 0.0),
        }
    }

    /// Whether the tone, of which `played` volts are, draws more current than any transducer would.
    pub(crate) fn is_short(&self, sensed: &Sensed, played: f32) -> bool {
        let most = self.admittances().1 * played;
        sensed.i.norm_sqr() > most * most
    }

    /// The least and the largest admittance that a transducer has at the tone's frequency, S.
    fn admittances(&self) -> (f32, f32) {
        self.clamped_siemens.map_or(self.any_siemens, |nominal| (nominal / CURRENT_FACTORS.0, nominal * CURRENT_FACTORS.1))
    }

    /// Capacitance that draws the tone's current, F, where there is no nominal one: the clamped one, and what coupling adds to it.
    pub(crate) fn capacitance_f(&self) -> Option<f32> {
        self.clamped_siemens.is_none().then_some(self.capacitance_f)
    }

    /// Mean square of the noise of voltage and current, codes, as measured in silence.
    pub(crate) fn noise(&self) -> (f32, f32) {
        self.noise
    }

    /// Begins again.
    pub(crate) fn restart(&mut self) {
        self.block = 0;
        self.quiet = false;
        self.heard = (0.0, f32::INFINITY);
        self.mean_codes = (0.0, 0.0);
        self.sum = (0.0, 0.0);
        self.first = (0.0, 0.0);
        self.lead = Phasor::default();
        self.noise = (0.0, 0.0);
    }

    /// Takes a block, in which `played` volts were, and says what to do next. Moves the zero of both channels when the silence is over.
    // Not inlined: a block takes fewer instructions so, which `docs/evidence/instructions.md` counts.
    #[inline(never)]
    pub(crate) fn listen(&mut self, convert: &mut Convert, sense: &SenseBlock, sensed: &Sensed, played: f32) -> Step {
        const TONE_ENDS: u32 = SILENT_BLOCKS + TONE_BLOCKS;
        const FIRST_MEASURED: u32 = SILENT_BLOCKS + LATENCY_BLOCKS as u32;
        self.block += 1;
        if !self.quiet {
            return self.wait_for_quiet(convert, sense);
        }
        match self.block {
            n if n <= SILENT_BLOCKS => {
                let ((v, v_variance), (i, i_variance)) =
                    (convert.v.mean_and_variance(&sense.v), convert.i.mean_and_variance(&sense.i));
                self.mean_codes.0 += v / SILENT_BLOCKS as f32;
                self.mean_codes.1 += i / SILENT_BLOCKS as f32;
                if n > SILENT_BLOCKS / 2 {
                    // The residual vibration has decayed further by then.
                    let part = 1.0 / (SILENT_BLOCKS - SILENT_BLOCKS / 2) as f32;
                    self.noise.0 += part * v_variance;
                    self.noise.1 += part * i_variance;
                }
                if n == SILENT_BLOCKS { self.judge_offset(convert) } else { Step::Silence }
            }
            n if (FIRST_MEASURED..FIRST_MEASURED + PHASE_BLOCKS).contains(&n) => {
                self.first.0 += magnitude(sensed.v) / PHASE_BLOCKS as f32;
                self.first.1 += magnitude(sensed.i) / PHASE_BLOCKS as f32;
                self.lead += sensed.i * sensed.v.conj();
                if n + 1 == FIRST_MEASURED + PHASE_BLOCKS && self.is_swapped(convert) {
                    return Step::Failed(Fault::SenseSwapped);
                }
                self.tone()
            }
            n if n <= TONE_ENDS => {
                if n > TONE_ENDS - MEASURED_BLOCKS {
                    self.sum.0 += magnitude(sensed.v) / MEASURED_BLOCKS as f32;
                    self.sum.1 += magnitude(sensed.i) / MEASURED_BLOCKS as f32;
                }
                self.tone()
            }
            _ => self.judge_tone(played),
        }
    }

    fn wait_for_quiet(&mut self, convert: &Convert, sense: &SenseBlock) -> Step {
        let (part, codes, noisy) = QUIET;
        let tone_codes = convert.i.codes(self.volts * self.clamped_siemens.unwrap_or(0.0));
        // What was played before may still sound.
        let loudest = codes.max(part * tone_codes);
        let variance = convert.i.mean_and_variance(&sense.i).1;
        self.heard.0 += variance;
        let is_window = self.block.is_multiple_of(self.window_blocks);
        let is_noise = is_window && self.heard.0 > FALLS * self.heard.1 && variance < noisy * noisy;
        if is_window {
            self.heard = (0.0, self.heard.0);
        }
        self.quiet = self.block > LATENCY_BLOCKS as u32 && (variance < loudest * loudest || is_noise);
        if self.quiet {
            self.block = 0;
        } else if self.block > self.ring_down_blocks {
            return Step::Failed(Fault::SensorImplausible);
        }
        Step::Silence
    }

    fn tone(&self) -> Step {
        Step::Tone { offset_hz: self.offset_hz, volts: self.volts, lane: 0 }
    }

    fn judge_offset(&self, convert: &mut Convert) -> Step {
        let fits = |offset: f32, half_range: f32| offset.abs() <= LARGEST_OFFSET * half_range;
        if !fits(self.mean_codes.0, convert.v.half_range()) || !fits(self.mean_codes.1, convert.i.half_range()) {
            return Step::Failed(Fault::SensorImplausible);
        }
        convert.v.shift_zero(self.mean_codes.0);
        convert.i.shift_zero(self.mean_codes.1);
        self.tone()
    }

    /// Whether the current lags where it must lead.
    fn is_swapped(&self, convert: &Convert) -> bool {
        let measured = convert.v.codes(self.first.0) > PHASE_CODES && convert.i.codes(self.first.1) > PHASE_CODES;
        measured && self.lead.im < -self.lead.re.abs()
    }

    fn judge_tone(&mut self, played: f32) -> Step {
        let (volts, amperes) = self.sum;
        let (least, most) = self.admittances();
        if volts > played * VOLTAGE_FACTOR {
            Step::Failed(Fault::SensorImplausible)
        } else if amperes > volts * most {
            Step::Failed(Fault::LoadShorted)
        } else if volts * VOLTAGE_FACTOR < played - LARGEST_OHM * amperes {
            Step::Failed(Fault::SensorImplausible)
        } else if amperes < volts * least {
            Step::Failed(Fault::LoadOpen)
        } else {
            self.capacitance_f = amperes * self.any_siemens.0.recip() * Tracking::CAPACITANCES_F.0 / volts;
            Step::Done { volts: 0.0 }
        }
    }
}

#[cfg(test)]
mod tests;
