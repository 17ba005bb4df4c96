//! Calibration of the lanes: measures the gain and phase error of each amplifier and computes the
//! trims that correct it.
//!
//! All lanes are driven at the scan voltage without trims, and the sense channels measure one after
//! the other. At each of several frequencies in the window, with `V(lane)` the measured voltage and
//! `offset(lane)` the nominal phase of the lane:
//!
//! ```text
//! E(lane)     = V(lane) / V(0) exp(-j offset(lane))
//! phase trim  = -arg E                                 lane 0 is the reference: a common delay does not matter
//! gain trim   = (1 / |E|) / largest of all lanes       so that no lane exceeds its command
//! ```
//!
//! Trims only reduce the amplitude of a lane. The limits therefore hold for any result, and stored
//! trims cannot make a configuration invalid. In return, all lanes have the amplitude of the
//! weakest. Configured corrections remain in effect; the calibration measures the remaining error.
//!
//! A second pass over the same frequencies verifies the trims. The calibration fails, and the
//! previous trims are restored, in each of these cases:
//!
//! * the initial error exceeds 45 degrees or 3 dB;
//! * after trimming, the error relative to lane 0 exceeds 0.1 degrees or 0.1 %;
//! * a lane cannot be measured.
//!
//! Limits of the accuracy:
//!
//! * Noise. A ratio of two phasors of `A` codes over `N` samples with noise of `s` codes is off by
//!   `2 s / (A sqrt(N))`. Enough blocks are averaged that one code of noise leaves a standard
//!   deviation of 0.006 %, or 0.0034 degrees; more if the scan voltage is less than 92 codes.
//! * Rounding by both converters repeats with the wave at simple fractions of the sample rate and
//!   then does not average out. The frequencies avoid such fractions.
//! * Ring-up. A resonant load pulls the source. At each frequency the calibration waits 16 nominal
//!   time constants: a Q of twice the nominal one leaves 0.03 % of that pull.
//! * Images of the DAC that fold onto the carrier are common to all lanes and cancel.
//! * Linear interpolation between the frequencies is exact for a delay. For one pole at twice the
//!   frequency, in the widest window, it is off by 0.02 degrees and 0.018 %.
//! * The calibration corrects the voltage at the terminals under its own load. A lane with a
//!   different load pulls its source differently, and this changes with the load.

use crate::generate::phasing::{PLAUSIBLE, Phasing, SWITCH_BLOCKS};
use crate::generate::shape::sine;
use crate::generate::step::Step;
use crate::seam::block::{LATENCY_BLOCKS, MAX_LANES};
use crate::seam::config::{Config, LaneTrims, Trim, TrimPoint};
use crate::seam::fault::Fault;
use crate::seam::phasor::{Phasor, argument, magnitude};
use crate::seam::units::Turns;
use crate::sense::demod::Sensed;

/// Positions in the window at which the lanes are measured, relative to its half-width: evenly
/// spaced up to the ends, but not at simple fractions.
const POSITIONS: [f32; 5] = [-0.996, -0.513, 0.017, 0.509, 0.996];
/// Ring-up time at each frequency, in nominal time constants.
const RING_UP_TIME_CONSTANTS: f32 = 16.0;
/// Target relative noise of the error of a lane, at one code of noise.
const NOISE_REL: f32 = 6e-5;
/// Minimum number of blocks to average.
const MIN_AVERAGE_BLOCKS: f32 = 64.0;
/// Maximum number of blocks to average.
const MAX_AVERAGE_BLOCKS: f32 = 4096.0;
/// Maximum remaining phase error, turns.
const MAX_PHASE_ERROR_TURNS: f32 = 0.1 / 360.0;
/// Maximum remaining gain error, relative.
const MAX_GAIN_ERROR_REL: f32 = 1e-3;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Pass {
    Measure,
    Verify,
}

/// Calibration in progress.
#[derive(Clone, Debug)]
pub(crate) struct Calibrate {
    nominal_hz: f32,
    /// Peak voltage of the drive, V.
    volts: f32,
    window_hz: f32,
    lanes: usize,
    ring_up_blocks: u32,
    average_blocks: u32,
    pass: Pass,
    point: usize,
    lane: usize,
    blocks: u32,
    sum: Phasor,
    measured: [Phasor; MAX_LANES],
    found: LaneTrims,
    /// Previous trims; set during a calibration.
    before: Option<LaneTrims>,
    completed: u32,
}

impl Calibrate {
    /// Creates a calibration over the configured window, which the scan has checked.
    pub(crate) fn build(config: &Config) -> Self {
        let block_s = f32::from(config.block_samples) / config.sample_hz;
        let tau_s = config.tracking.nominal_q / (core::f32::consts::PI * config.drive.frequency_hz);
        let codes = config.drive.scan_volts / config.front_end.volt_per_lsb;
        let root_samples = 2.0 / (NOISE_REL * codes);
        let blocks = root_samples * root_samples / f32::from(config.block_samples);
        Calibrate {
            nominal_hz: config.drive.frequency_hz,
            volts: config.drive.scan_volts,
            window_hz: config.tracking.span * config.drive.frequency_hz,
            lanes: config.lanes.into(),
            ring_up_blocks: (RING_UP_TIME_CONSTANTS * tau_s / block_s) as u32 + 1,
            average_blocks: blocks.clamp(MIN_AVERAGE_BLOCKS, MAX_AVERAGE_BLOCKS) as u32,
            pass: Pass::Measure,
            point: 0,
            lane: 0,
            blocks: 0,
            sum: Phasor::default(),
            measured: [Phasor::default(); MAX_LANES],
            found: LaneTrims::new(),
            before: None,
            completed: 0,
        }
    }

    /// Returns the number of completed calibrations.
    pub(crate) fn completed(&self) -> u32 {
        self.completed
    }

    /// Ends an unfinished calibration and restores the previous trims.
    pub(crate) fn abandon(&mut self, phasing: &mut Phasing) {
        if let Some(before) = self.before.take() {
            phasing.trim(before);
        }
    }

    /// Processes the phasors of the measured block and returns the next step. Clears the trims at
    /// the start and sets the new ones after the first pass.
    // Not inlined: saves instructions per block, which `docs/evidence/instructions.md` counts.
    #[inline(never)]
    pub(crate) fn listen(&mut self, phasing: &mut Phasing, sensed: &Sensed) -> Step {
        if self.before.is_none() {
            self.before = Some(phasing.trim(LaneTrims::new()));
            self.begin(Pass::Measure);
            if self.lanes == 1 {
                return self.finish();
            }
        }
        self.blocks += 1;
        let settles = if self.lane == 0 { self.ring_up_blocks } else { SWITCH_BLOCKS } + LATENCY_BLOCKS as u32;
        if self.blocks > settles {
            self.sum += sensed.v;
        }
        if self.blocks < settles + self.average_blocks {
            return self.tone();
        }
        let sum = core::mem::take(&mut self.sum);
        self.measured.get_mut(self.lane).into_iter().for_each(|measured| *measured = sum);
        (self.lane, self.blocks) = (self.lane + 1, 0);
        if self.lane < self.lanes { self.tone() } else { self.take_point(phasing) }
    }

    fn begin(&mut self, pass: Pass) {
        (self.pass, self.point, self.lane, self.blocks) = (pass, 0, 0, 0);
        self.sum = Phasor::default();
        if pass == Pass::Measure {
            self.found.clear();
        }
    }

    fn finish(&mut self) -> Step {
        self.before = None;
        self.completed = self.completed.wrapping_add(1);
        Step::Done { volts: 0.0 }
    }

    /// Returns the offset of the present tone, Hz.
    fn offset_hz(&self) -> f32 {
        self.window_hz * POSITIONS.get(self.point).unwrap_or(&0.0)
    }

    fn tone(&self) -> Step {
        Step::Tone { offset_hz: self.offset_hz(), volts: self.volts, lane: self.lane as u8 }
    }

    /// Evaluates one frequency after all lanes have been measured there.
    fn take_point(&mut self, phasing: &mut Phasing) -> Step {
        let errors = self.errors(phasing.quadrature(None).0);
        let errors = errors.get(..self.lanes).unwrap_or(&errors);
        let bound = if self.pass == Pass::Measure { PLAUSIBLE } else { (MAX_PHASE_ERROR_TURNS, 1.0 + MAX_GAIN_ERROR_REL) };
        if !errors.iter().all(|error| is_within(error, bound)) {
            self.abandon(phasing);
            return Step::Failed(Fault::LaneImplausible);
        }
        if self.pass == Pass::Measure {
            let hz = self.nominal_hz + self.offset_hz();
            // There is room for one point per position.
            let _ = self.found.push(TrimPoint { hz, lanes: trims(errors) });
        }
        (self.lane, self.point) = (0, self.point + 1);
        if self.point < POSITIONS.len() {
            return self.tone();
        }
        if self.pass == Pass::Verify {
            return self.finish();
        }
        phasing.trim(self.found.clone());
        self.begin(Pass::Verify);
        self.tone()
    }

    /// Computes phase and gain of each lane relative to lane 0 and to its nominal phase.
    fn errors(&self, quadrature: f32) -> [(Turns, f32); MAX_LANES] {
        let offsets = Phasing::offsets(quadrature);
        let reference = self.measured[0];
        core::array::from_fn(|lane| {
            let ideal = sine::rotation(u64::from(offsets[lane]) << 32);
            let error = self.measured[lane] * reference.conj() * ideal.conj();
            (argument(error), magnitude(error) / reference.norm_sqr())
        })
    }
}

/// Returns `true` if an error is within this phase, turns, and this gain factor; `false` for NaN.
fn is_within(&(phase, gain): &(Turns, f32), (turns, factor): (f32, f32)) -> bool {
    phase.0.abs() <= turns && gain <= factor && gain * factor >= 1.0
}

/// Computes the trims that correct these errors.
fn trims(errors: &[(Turns, f32)]) -> [Trim; MAX_LANES] {
    let weakest = errors.iter().map(|error| error.1).fold(f32::INFINITY, f32::min);
    let mut trims = [Trim::default(); MAX_LANES];
    for (trim, (phase, gain)) in trims.iter_mut().zip(errors) {
        *trim = Trim { phase_turns: -phase.0, gain: weakest / gain };
    }
    trims
}

#[cfg(test)]
mod tests;
