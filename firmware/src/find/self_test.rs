//! Self-test before the first real drive: checks both sense channels and the presence of a
//! transducer.
//!
//! The test starts with silence until all vibration has decayed. The mean code of each channel is
//! then its offset, which must be small and is removed from then on. A tone well below the
//! resonance follows, where the transducer is little more than its clamped capacitance. The current
//! must lead the voltage. The voltage must equal the played one, and the current must match the
//! nominal capacitance, each within a factor. Without a nominal capacitance, the measured one must
//! be in the range of any transducer and is used by all later steps. The amplitude rises and falls
//! in steps: a jump of the voltage draws a peak of current into the clamped capacitance, which may
//! exceed the range of the channel.
//!
//! Too much current is a short, or another resonance near the tone, or a strong coupling: a second,
//! lower tone decides.
//!
//! The test takes 97 blocks, 65 more for a second tone, and up to 1000 blocks and 40 nominal time
//! constants more if an earlier vibration must decay first. Swapped channels are detected 4 blocks
//! after the tone is first measured, all other faults at its end.

use crate::generate::step::Step;
use crate::seam::block::{LATENCY_BLOCKS, SenseBlock};
use crate::seam::config::{Config, Tracking};
use crate::seam::fault::Fault;
use crate::seam::phasor::{Phasor, magnitude};
use crate::sense::convert::Convert;
use crate::sense::demod::Sensed;
use crate::sense::source::LARGEST_OHM;

/// Number of silent blocks that are averaged.
const SILENT_BLOCKS: u32 = 32;
/// Maximum rms current in silence, relative to the expected current of the tone.
const QUIET_REL: f32 = 0.25;
/// Rms current that always counts as silence, codes.
const QUIET_CODES: f32 = 2.0;
/// Maximum rms current that counts as noise if it no longer decays, codes.
const NOISE_CODES: f32 = 16.0;
/// Ratio of the mean squares of two consecutive windows below which the vibration is decaying.
/// Within a window, it decays to 0.37 at the nominal Q, and to 0.72 at three times that Q.
const MAX_DECAY_RATIO: f32 = 0.85;
/// Minimum length of a window, blocks.
const MIN_WINDOW_BLOCKS: u32 = 16;
/// Length of a window, nominal time constants.
const WINDOW_TIME_CONSTANTS: f32 = 0.5;
/// Maximum ring-down of an earlier run, nominal time constants. Q may be three times the nominal
/// one.
const RING_DOWN_TIME_CONSTANTS: f32 = 40.0;
/// Blocks added to the maximum ring-down.
const RING_DOWN_BLOCKS: u32 = 1000;
/// Blocks of the tone.
const TONE_BLOCKS: u32 = 64;
/// Blocks in which the tone rises, and in which it falls.
const FADE_BLOCKS: u32 = 8;
/// Blocks of the tone that are measured, before it falls.
const MEASURED_BLOCKS: u32 = 16;
/// First blocks of the tone whose phase reveals swapped channels, before the guard reports an
/// implausible voltage.
const PHASE_BLOCKS: u32 = 4;
/// Minimum mean amplitude whose phase is judged, codes, while the tone rises to half of its
/// amplitude; noise alone reaches a quarter of a code.
const PHASE_CODES: f32 = 1.25;
/// Frequencies of the two tones, relative to the nominal frequency.
const TONE_FREQUENCIES_REL: [f32; 2] = [0.85, 0.7];
/// Amplitude of the tone, relative to the scan voltage.
const TONE_AMPLITUDE_REL: f32 = 0.5;
/// Maximum offset, relative to half the range.
const MAX_OFFSET_REL: f32 = 0.05;
/// Maximum ratio between the measured and the played voltage.
const VOLTAGE_FACTOR: f32 = 1.5;
/// Factor by which the current may be smaller than that of the nominal capacitance.
const CURRENT_FACTOR_BELOW: f32 = 3.0;
/// Factor by which the current may be larger than that of the nominal capacitance. Coupling alone
/// increases it by `1 + k^2 / (1 - k^2) / (1 - 0.85^2)`: 1.4 at k = 0.3, 5.6 at 0.75 and 7.4 at
/// 0.8, where it is 4.5 at 0.7 of the resonance. The nominal capacitance may be off by 30 %. A
/// short draws a hundred times as much.
const CURRENT_FACTOR_ABOVE: f32 = 8.0;

/// Self-test in progress.
#[derive(Clone, Debug)]
pub(crate) struct SelfTest {
    nominal_hz: f32,
    volts: f32,
    nominal_c0_f: Option<f32>,
    /// Frequency of the tone, relative to the nominal one.
    tone_rel: f32,
    /// Capacitance that draws the measured current, F.
    capacitance_f: f32,
    ring_down_blocks: u32,
    window_blocks: u32,
    /// Sums of mean squares in silence: of this window and of the previous one.
    square_sums: (f32, f32),
    /// Blocks of the present phase of the test.
    block: u32,
    quiet: bool,
    mean_codes: (f32, f32),
    sum: (f32, f32),
    /// Mean amplitude of voltage and current in the first blocks of the tone.
    first: (f32, f32),
    /// Phase of the current relative to the voltage in these blocks.
    lead: Phasor,
    /// Voltage played in the last measured block, V.
    played: f32,
    /// Mean square of both channels in silence, codes squared.
    noise: (f32, f32),
}

impl SelfTest {
    /// Creates a test for the configured drive and nominal capacitance.
    pub(crate) fn build(config: &Config) -> Self {
        let tau_s = config.tracking.nominal_q / (core::f32::consts::PI * config.drive.frequency_hz);
        let block_s = f32::from(config.block_samples) / config.sample_hz;
        SelfTest {
            nominal_hz: config.drive.frequency_hz,
            volts: config.drive.scan_volts * TONE_AMPLITUDE_REL,
            nominal_c0_f: config.tracking.nominal_c0_f,
            tone_rel: TONE_FREQUENCIES_REL[0],
            capacitance_f: config.tracking.c0_f(),
            ring_down_blocks: RING_DOWN_BLOCKS + (RING_DOWN_TIME_CONSTANTS * tau_s / block_s) as u32,
            window_blocks: MIN_WINDOW_BLOCKS.max((WINDOW_TIME_CONSTANTS * tau_s / block_s) as u32),
            square_sums: (0.0, f32::INFINITY),
            block: 0,
            quiet: false,
            mean_codes: (0.0, 0.0),
            sum: (0.0, 0.0),
            first: (0.0, 0.0),
            lead: Phasor::default(),
            played: 0.0,
            noise: (0.0, 0.0),
        }
    }

    /// Returns `true` if a tone of `played` volts draws more current than any transducer would.
    pub(crate) fn is_short(&self, sensed: &Sensed, played: f32) -> bool {
        let most = self.admittances().1 * played;
        sensed.i.norm_sqr() > most * most
    }

    /// Returns the minimum and maximum admittance of a transducer at the frequency of the tone, S.
    fn admittances(&self) -> (f32, f32) {
        let (least_f, largest_f) = self
            .nominal_c0_f
            .map_or(Tracking::CAPACITANCES_F, |nominal_f| (nominal_f / CURRENT_FACTOR_BELOW, nominal_f * CURRENT_FACTOR_ABOVE));
        (self.omega() * least_f, self.omega() * largest_f)
    }

    /// Returns the angular frequency of the tone, rad/s.
    fn omega(&self) -> f32 {
        core::f32::consts::TAU * self.nominal_hz * self.tone_rel
    }

    /// Returns the capacitance that draws the current of the tone, F, if no nominal one is
    /// configured: the clamped capacitance increased by coupling.
    pub(crate) fn capacitance_f(&self) -> Option<f32> {
        self.nominal_c0_f.is_none().then_some(self.capacitance_f)
    }

    /// Returns the mean square of the noise of voltage and current in silence, codes squared.
    pub(crate) fn noise(&self) -> (f32, f32) {
        self.noise
    }

    /// Starts again.
    pub(crate) fn restart(&mut self) {
        self.block = 0;
        self.quiet = false;
        self.square_sums = (0.0, f32::INFINITY);
        self.mean_codes = (0.0, 0.0);
        self.noise = (0.0, 0.0);
        self.begin_tone(TONE_FREQUENCIES_REL[0]);
    }

    /// Begins a tone at this frequency, relative to the nominal one.
    fn begin_tone(&mut self, frequency_rel: f32) {
        self.tone_rel = frequency_rel;
        self.sum = (0.0, 0.0);
        self.first = (0.0, 0.0);
        self.lead = Phasor::default();
    }

    /// Processes a block in which `played` volts were driven and returns the next step. Moves the
    /// zero of both channels at the end of the silence.
    // Not inlined: saves instructions per block, which `docs/evidence/instructions.md` counts.
    #[inline(never)]
    pub(crate) fn listen(&mut self, convert: &mut Convert, sense: &SenseBlock, sensed: &Sensed, played: f32) -> Step {
        const TONE_ENDS: u32 = SILENT_BLOCKS + TONE_BLOCKS;
        const TONE_FALLS: u32 = TONE_ENDS - FADE_BLOCKS;
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
                    // Residual vibration has decayed further in the second half.
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
            n if n <= TONE_FALLS => {
                if n > TONE_FALLS - MEASURED_BLOCKS {
                    self.sum.0 += magnitude(sensed.v) / MEASURED_BLOCKS as f32;
                    self.sum.1 += magnitude(sensed.i) / MEASURED_BLOCKS as f32;
                }
                self.played = played;
                self.tone()
            }
            n if n <= TONE_ENDS => self.tone(),
            _ => self.judge_tone(),
        }
    }

    fn wait_for_quiet(&mut self, convert: &Convert, sense: &SenseBlock) -> Step {
        let tone_codes = convert.i.codes(self.volts * self.omega() * self.nominal_c0_f.unwrap_or(0.0));
        // Blocks driven earlier may still arrive.
        let limit = QUIET_CODES.max(QUIET_REL * tone_codes);
        let variance = convert.i.mean_and_variance(&sense.i).1;
        self.square_sums.0 += variance;
        let is_window = self.block.is_multiple_of(self.window_blocks);
        let is_noise =
            is_window && self.square_sums.0 > MAX_DECAY_RATIO * self.square_sums.1 && variance < NOISE_CODES * NOISE_CODES;
        if is_window {
            self.square_sums = (0.0, self.square_sums.0);
        }
        self.quiet = self.block > LATENCY_BLOCKS as u32 && (variance < limit * limit || is_noise);
        if self.quiet {
            self.block = 0;
        } else if self.block > self.ring_down_blocks {
            return Step::Failed(Fault::SensorImplausible);
        }
        Step::Silence
    }

    /// Returns the tone of the block to be ordered next.
    fn tone(&self) -> Step {
        let (since, left) = (self.block + 1 - SILENT_BLOCKS, SILENT_BLOCKS + TONE_BLOCKS + 1 - self.block);
        let steps = since.min(left).min(FADE_BLOCKS);
        Step::Tone {
            offset_hz: self.nominal_hz * self.tone_rel - self.nominal_hz,
            volts: self.volts * (steps as f32 / FADE_BLOCKS as f32),
            lane: 0,
        }
    }

    fn judge_offset(&self, convert: &mut Convert) -> Step {
        let fits = |offset: f32, half_range: f32| offset.abs() <= MAX_OFFSET_REL * half_range;
        if !fits(self.mean_codes.0, convert.v.half_range()) || !fits(self.mean_codes.1, convert.i.half_range()) {
            return Step::Failed(Fault::SensorImplausible);
        }
        convert.v.shift_zero(self.mean_codes.0);
        convert.i.shift_zero(self.mean_codes.1);
        self.tone()
    }

    /// Returns `true` if the current lags, although it must lead.
    fn is_swapped(&self, convert: &Convert) -> bool {
        let measured = convert.v.codes(self.first.0) > PHASE_CODES && convert.i.codes(self.first.1) > PHASE_CODES;
        measured && self.lead.im < -self.lead.re.abs()
    }

    fn judge_tone(&mut self) -> Step {
        let ((volts, amperes), played) = (self.sum, self.played);
        let (least, most) = self.admittances();
        if volts > played * VOLTAGE_FACTOR {
            Step::Failed(Fault::SensorImplausible)
        } else if amperes > volts * most && self.tone_rel > TONE_FREQUENCIES_REL[1] {
            self.begin_tone(TONE_FREQUENCIES_REL[1]);
            self.block = SILENT_BLOCKS;
            self.tone()
        } else if amperes > volts * most {
            Step::Failed(Fault::LoadShorted)
        } else if volts * VOLTAGE_FACTOR < played - LARGEST_OHM * amperes {
            Step::Failed(Fault::SensorImplausible)
        } else if amperes < volts * least {
            Step::Failed(Fault::LoadOpen)
        } else {
            self.capacitance_f = amperes / (volts * self.omega());
            Step::Done { volts: 0.0 }
        }
    }
}

#[cfg(test)]
mod tests;
