//! Calibration of the lanes: by how much each amplifier departs from its nominal gain and phase, and the trims that correct it.
//!
//! All lanes are driven at the scan voltage, untrimmed, and the sense channels listen to one after the other. At each of a few frequencies
//! over the window, with `V(lane)` the measured voltage and `offset(lane)` the nominal phase of the lane:
//!
//! ```text
//! E(lane)     = V(lane) / V(0) exp(-j offset(lane))
//! phase trim  = -arg E                                 lane 0 is the reference: a delay that all have does not matter
//! gain trim   = (1 / |E|) / largest of all lanes       so that no lane gets more than it is ordered
//! ```
//!
//! Trims only ever turn a lane down: the limits hold whatever is found, and stored trims can never make a configuration invalid.
//! The price is that all lanes are as loud as the weakest. Corrections that the configuration has stay; what is found is what they leave.
//!
//! A second pass over the same frequencies verifies the trims. What does not come out within 0.1 degrees and 0.1 % of lane 0, is more than 45
//! degrees or 3 dB to begin with, or is not measured at all, is a fault, and the trims are what they were before.
//!
//! What limits it:
//!
//! * Noise. A ratio of two phasors of `A` codes over `N` samples with noise of `s` codes is off by `2 s / (A sqrt(N))`. So many blocks are
//!   averaged that one code leaves 0.006 %, and 0.0034 degrees, as a standard deviation; where the scan voltage is less than 92 codes, more.
//! * Rounding, of both converters, repeats with the wave where that is a simple fraction of the sample rate, and then does not average out:
//!   the frequencies are none.
//! * Ring-up. A resonant load pulls the source. At each frequency 16 nominal time constants pass first: a Q of twice the nominal one leaves
//!   0.03 % of that pull.
//! * What is folded onto the carrier (images of the DAC) is common to all lanes, and cancels.
//! * Between the frequencies, straight lines: exact for a delay; in the widest window, and for one pole at twice the frequency, 0.02 degrees
//!   and 0.018 % off.
//! * What is trimmed is the voltage at the terminals under the load of this calibration. A lane whose load differs from the others' pulls its
//!   source differently, and that changes with the load.

use crate::generate::phasing::{PLAUSIBLE, Phasing, SWITCH_BLOCKS};
use crate::generate::shape::sine;
use crate::generate::step::Step;
use crate::seam::block::{LATENCY_BLOCKS, MAX_LANES};
use crate::seam::config::{Config, LaneTrims, Trim, TrimPoint};
use crate::seam::fault::Fault;
use crate::seam::phasor::{Phasor, argument, magnitude};
use crate::seam::units::Turns;
use crate::sense::demod::Sensed;

/// Where in the window is measured: next to its ends and evenly between, but at no simple fraction of anything.
const POSITIONS: [f32; 5] = [-0.996, -0.513, 0.017, 0.509, 0.996];
/// Nominal time constants that a frequency rings up for.
const RING_UP: f32 = 16.0;
/// Relative noise of a lane's error that one code of noise may leave.
const NOISE: f32 = 6e-5;
/// Fewest and most blocks to average.
const AVERAGE: (f32, f32) = (64.0, 4096.0);
/// Largest error that is left: turns, and a part.
const RESIDUAL: (f32, f32) = (0.1 / 360.0, 1e-3);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Pass {
    Measure,
    Verify,
}

/// The calibration, in progress.
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
    /// The trims as they were, while this is not over.
    before: Option<LaneTrims>,
    completed: u32,
}

impl Calibrate {
    /// A calibration of the configured window, which the scan has checked.
    pub(crate) fn build(config: &Config) -> Self {
        let block_s = f32::from(config.block_samples) / config.sample_hz;
        let tau_s = config.tracking.nominal_q / (core::f32::consts::PI * config.drive.frequency_hz);
        let codes = config.drive.scan_volts / config.front_end.volt_per_lsb;
        let root_samples = 2.0 / (NOISE * codes);
        let blocks = root_samples * root_samples / f32::from(config.block_samples);
        Calibrate {
            nominal_hz: config.drive.frequency_hz,
            volts: config.drive.scan_volts,
            window_hz: config.tracking.span * config.drive.frequency_hz,
            lanes: config.lanes.into(),
            ring_up_blocks: (RING_UP * tau_s / block_s) as u32 + 1,
            average_blocks: blocks.clamp(AVERAGE.0, AVERAGE.1) as u32,
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

    /// How many have been completed.
    pub(crate) fn completed(&self) -> u32 {
        self.completed
    }

    /// Ends an unfinished calibration: the trims are again what they were.
    pub(crate) fn abandon(&mut self, phasing: &mut Phasing) {
        if let Some(before) = self.before.take() {
            phasing.trim(before);
        }
    }

    /// Takes the phasors of the measured block and returns the next step. Clears the trims when it begins, and sets them.
    // Not inlined: a block takes fewer instructions so, which `docs/evidence/instructions.md` counts.
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

    /// Offset of the present tone, Hz.
    fn offset_hz(&self) -> f32 {
        self.window_hz * POSITIONS.get(self.point).unwrap_or(&0.0)
    }

    fn tone(&self) -> Step {
        Step::Tone { offset_hz: self.offset_hz(), volts: self.volts, lane: self.lane as u8 }
    }

    /// All lanes have been measured at this frequency.
    fn take_point(&mut self, phasing: &mut Phasing) -> Step {
        let errors = self.errors(phasing.quadrature(None).0);
        let errors = errors.get(..self.lanes).unwrap_or(&errors);
        let bound = if self.pass == Pass::Measure { PLAUSIBLE } else { (RESIDUAL.0, 1.0 + RESIDUAL.1) };
        if !errors.iter().all(|error| is_within(error, bound)) {
            self.abandon(phasing);
            return Step::Failed(Fault::LaneImplausible);
        }
        if self.pass == Pass::Measure {
            let hz = self.nominal_hz + self.offset_hz();
            // As many points as there is room for.
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

    /// Each lane relative to lane 0 and to where it ought to stand: phase and gain.
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

/// Whether an error is within so many turns, and a factor; what is not a number is not.
fn is_within(&(phase, gain): &(Turns, f32), (turns, factor): (f32, f32)) -> bool {
    phase.0.abs() <= turns && gain <= factor && gain * factor >= 1.0
}

/// What takes these errors away.
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
