//! The clamped capacitance while running: the drive steps to both sides of the lock point, and the motional resistance must be the same on both.
//!
//! What is thought of C0 is wrong by the susceptance that makes it so (`balance`). No Q, no Lm and no lock point enters; nor does a tracker that is off by a little. Only
//! the axis and the loss of the clamped branch are taken from the calibration at power-on, and neither changes with the temperature as C0 does.
//!
//! A round is `+ - - +`, so that a resonance that drifts evenly does not look like a capacitance; each is blended with the estimate before it by the two
//! variances (Kalman 1960). A round is due once the stack has rung up after a cold start or after a scan, which have not measured at the lock point: there, another
//! resonance near by adds to the susceptance, and images of the drive to the axis, half of whose error a round takes away. It is due again when the load has changed
//! abruptly, because C0 may have changed with it; and, where C0 is said to drift, when it may have wandered further than the target deviation.

mod balance;

use crate::find::clamped::online::balance::{Balance, Side};
use crate::find::clamped::reading::Measured;
use crate::seam::block::LATENCY_BLOCKS;
use crate::seam::config::Config;
use crate::seam::phasor::Phasor;
use crate::sense::demod::Sensed;
use crate::sense::motional::Motional;

/// The step, half bandwidths: takes 1.1 % of the velocity once settled, 1.5 % at most on the way (`cargo test -p scenarios clamped::online`).
const STEP: f32 = 0.15;
/// Blocks of each quarter of a round that are averaged: as many as this, or so many time constants if that is more.
const QUARTER: (f32, f32) = (20.0, 1.0);
/// Time constants that a step settles for: 2 % of it is left, the same on both sides.
const SETTLES: f32 = 4.0;
/// What of it is left in the mean of quarters of one time constant: 1.7 %, or as little as nothing where the source's resistance damps the resonance more than its own.
const UNSETTLED: f32 = 0.0085;
/// Deviation of a nominal C0 that was not measured, relative.
const NOMINAL_DEVIATION: f32 = 0.05;
/// Deviation of C0, relative, from which on a round is made.
const TARGET_DEVIATION: f32 = 7e-4;
/// What the branch that a lock begins with may be off by at the lock point, relative to the motional conductance.
const ELSEWHERE: f32 = 0.02;
/// By how much of itself C0 may have changed while running.
const PLAUSIBLE: (f32, f32) = (-0.6, 1.5);
/// What it is off by that is worth a change, in the same terms: 0.15 % of the bandwidth.
const WORTH: f32 = 0.003;
/// The longest time constant with which a round is made unasked, s: it takes 16 to 20 of them, and what a branch is off by is the less in hertz the longer they are.
const LONGEST_S: f32 = 8e-3;
/// Standard deviations that a judgement leaves room for.
const SIGMAS: f32 = 3.0;
/// A result that differs from what was expected by more of its standard deviations than this, and is then made again before it counts.
const SURPRISE: f32 = 6.0;

/// A block under drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<'a> {
    /// Phasors measured in the block.
    pub sensed: &'a Sensed,
    /// Frequency of the block, relative to the nominal one.
    pub relative: f32,
    /// How far beside the lock point that was on purpose, Hz.
    pub detune_hz: f32,
    /// Locked, driven at a constant envelope of one, within all limits, and by no other order off the lock point.
    pub steady: bool,
}

/// A new estimate of the clamped branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// The clamped branch, by all measurements so far.
    pub motional: Motional,
    /// Standard deviation of its susceptance, relative to it.
    pub(crate) deviation: f32,
    /// By how much the estimate of this round alone is larger, relative, and its standard deviation.
    pub(crate) round: (f32, f32),
    /// By how much of the motional conductance at least the branch of a lock was off that had only just begun, beyond three standard deviations.
    pub(crate) was_off: Option<f32>,
    /// Quality factor by this round alone: by how far the motional phase turns from one side to the other.
    pub(crate) q: Measured,
}

/// Output of the estimator after a block: its order to the drive, and its estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// How far beside the lock point to drive, Hz.
    pub detune_hz: f32,
    /// The measured block had not settled after a step: its phase must not be used as that of a steady state.
    pub hold: bool,
    /// A new estimate, at the end of a round.
    pub update: Option<Update>,
}

/// The estimator of the clamped capacitance while running.
#[derive(Clone, Debug)]
pub struct Online {
    block_s: f32,
    /// How fast C0 may drift, relative, 1/s; zero where it is not measured while running.
    drift_per_s: f32,
    motional: Motional,
    /// How what other resonances add to it changes with the frequency, S/Hz.
    slope: Phasor,
    /// Variance of the susceptance, relative to it.
    variance: f32,
    step_hz: f32,
    settle_blocks: u32,
    quarter_blocks: u32,
    /// Blocks of this round, zero between rounds; and blocks measured since the last step.
    round: u32,
    settled: u32,
    last_hz: f32,
    /// Below and above.
    sides: [Side; 2],
    doubted: bool,
    /// The branch was not measured at the lock point yet, or not since something has changed.
    due: Due,
    /// Blocks of a steady drive.
    steady: u32,
}

/// Why a round is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Due {
    /// The lock has begun.
    Begun,
    /// Something has changed abruptly.
    Changed,
    /// C0 has drifted for long enough.
    Drift,
}

impl Online {
    /// An estimator by the nominal transducer.
    pub fn build(config: &Config) -> Self {
        let block_s = f32::from(config.block_samples) / config.sample_hz;
        let tracking = &config.tracking;
        Online::new(
            block_s,
            Motional::of_capacitance(tracking.c0_f(), config.drive.frequency_hz),
            config.drive.frequency_hz,
            tracking.nominal_q,
            tracking.c0_drift_per_s,
        )
    }

    fn new(block_s: f32, motional: Motional, resonance_hz: f32, q: f32, drift_per_s: f32) -> Self {
        let mut online = Online {
            block_s,
            drift_per_s,
            motional,
            slope: Phasor::new(0.0, 0.0),
            variance: NOMINAL_DEVIATION * NOMINAL_DEVIATION,
            step_hz: 0.0,
            settle_blocks: 0,
            quarter_blocks: 0,
            round: 0,
            settled: 0,
            last_hz: 0.0,
            sides: [Side::default(); 2],
            doubted: false,
            due: Due::Begun,
            steady: 0,
        };
        online.set_resonance(resonance_hz, q);
        online
    }

    /// Starts from what a scan or the calibration at power-on has found; `deviation` is that of C0, relative.
    pub fn seed(&mut self, motional: Motional, deviation: f32, resonance_hz: f32, q: f32) {
        self.motional = motional;
        self.variance = deviation * deviation;
        self.set_resonance(resonance_hz, q);
        self.slope = Phasor::new(0.0, 0.0);
        (self.doubted, self.due, self.settled) = (false, Due::Begun, u32::MAX);
        self.stop();
    }

    /// Takes how what other resonances add to the branch changes with the frequency, S/Hz.
    pub(crate) fn set_slope(&mut self, slope: Phasor) {
        self.slope = slope;
    }

    /// Follows a load that changes the resonance: by these the steps are measured, nothing else. Does not disturb a round.
    pub(crate) fn set_resonance(&mut self, resonance_hz: f32, q: f32) {
        let tau_blocks = q / (core::f32::consts::PI * resonance_hz * self.block_s);
        self.step_hz = STEP * 0.5 * resonance_hz / q;
        self.settle_blocks = (SETTLES * tau_blocks) as u32 + 1;
        self.quarter_blocks = QUARTER.0.max(QUARTER.1 * tau_blocks) as u32;
    }

    /// Whether a round is under way: the drive is beside the lock point on purpose.
    pub(crate) fn probes(&self) -> bool {
        self.round > 0
    }

    /// Whether something has changed abruptly, and no round since has shown what.
    pub(crate) fn doubts(&self) -> bool {
        self.due == Due::Changed
    }

    /// How far a round that is under way goes to either side, Hz.
    pub(crate) fn reach_hz(&self) -> f32 {
        if self.probes() { self.step_hz } else { 0.0 }
    }

    /// The clamped branch, by all measurements so far.
    pub fn motional(&self) -> Motional {
        self.motional
    }

    /// Standard deviation of its susceptance, relative to it.
    pub(crate) fn deviation(&self) -> f32 {
        libm::sqrtf(self.variance)
    }

    /// Whether a block is to be [taken](Self::step): only then is there anything to measure, or to wait for. `level`: the envelope is one throughout; `changed`: load or resonance
    /// have changed abruptly, by which a round becomes due.
    #[inline]
    pub(crate) fn listens(&mut self, level: bool, changed: bool) -> bool {
        // Its own steps surprise whoever else listens.
        if self.round > 0 || self.settled < self.settle_blocks {
            return true;
        }
        if changed && self.due == Due::Drift {
            self.due = Due::Changed;
        }
        if !level || changed {
            self.steady = 0;
            return false;
        }
        self.wants()
    }

    /// Takes it that a block says nothing: what is driven has to ring up again.
    #[inline]
    pub(crate) fn rest(&mut self) {
        self.steady = 0;
    }

    /// Takes a block and says what to do next.
    // Not inlined: few blocks are taken, and those that are not shall not wait for the registers that it needs.
    #[inline(never)]
    pub fn step(&mut self, sample: &Sample) -> Output {
        let wandered = self.drift_per_s * self.block_s;
        // As a walk whose standard deviation after a round is what a steady drift would make in it.
        self.variance += wandered * wandered * self.round_blocks() as f32;
        let stepped = (sample.detune_hz - self.last_hz).abs() > 0.5 * self.step_hz;
        self.settled = if stepped { 0 } else { self.settled.saturating_add(1) };
        self.last_hz = sample.detune_hz;
        let hold = self.settled < self.settle_blocks;
        if !sample.steady {
            self.stop();
            return Output { hold, ..Output::default() };
        }
        self.steady = self.steady.saturating_add(1);
        // What has not rung up yet would look like a susceptance.
        if self.round == 0 && (self.steady < self.settle_blocks || self.rests()) {
            return Output { hold, ..Output::default() };
        }
        self.listen(sample, hold);
        self.round += 1;
        if self.round <= self.round_blocks() + LATENCY_BLOCKS as u32 {
            return Output { detune_hz: self.probe_hz(), hold, update: None };
        }
        let update = self.finish();
        self.begin();
        Output { hold, update, ..Output::default() }
    }

    fn stop(&mut self) {
        self.steady = 0;
        self.begin();
    }

    fn begin(&mut self) {
        self.round = 0;
        self.sides = [Side::default(); 2];
    }

    /// Whether C0 cannot have drifted far enough yet.
    fn rests(&self) -> bool {
        self.due == Due::Drift && self.variance < TARGET_DEVIATION * TARGET_DEVIATION
    }

    /// Whether a round is to be made; where C0 drifts, it is counted how far.
    fn wants(&self) -> bool {
        match self.due {
            Due::Begun | Due::Changed => self.settle_blocks as f32 * self.block_s < SETTLES * LONGEST_S,
            Due::Drift => self.drift_per_s > 0.0,
        }
    }

    /// Blocks of a round: three stretches, the middle one of two quarters.
    fn round_blocks(&self) -> u32 {
        3 * self.settle_blocks + 4 * self.quarter_blocks
    }

    fn probe_hz(&self) -> f32 {
        let first = self.settle_blocks + self.quarter_blocks;
        let second = first + self.settle_blocks + 2 * self.quarter_blocks;
        match self.round {
            n if n > self.round_blocks() => 0.0,
            n if n > first && n <= second => -self.step_hz,
            _ => self.step_hz,
        }
    }

    /// By how much a round's quarters, which begin before the step has settled to the end, make the phase turn too little: half of
    /// `(3 (1 - e^-n) / 2 + (1 - e^-2n)) e^-s / 2 n` after `s` time constants, with quarters of `n`.
    fn unsettled(&self) -> f32 {
        1.0 + UNSETTLED * (self.settle_blocks as f32 / (SETTLES * self.quarter_blocks as f32)).min(1.0)
    }

    fn listen(&mut self, sample: &Sample, hold: bool) {
        let square = sample.sensed.v.norm_sqr();
        let side = &mut self.sides[usize::from(sample.detune_hz > 0.0)];
        if hold || sample.detune_hz.abs() < 0.5 * self.step_hz || square == 0.0 {
            side.pause();
            return;
        }
        let current = self.motional.current(sample.sensed, sample.relative) - self.slope * sample.sensed.v * sample.detune_hz;
        side.take(self.motional.phase_of(current, sample.sensed.v) / square, sample.relative);
    }

    /// What the round says.
    fn finish(&mut self) -> Option<Update> {
        let [below, above] = &self.sides;
        let susceptance = self.motional.y0.im;
        let Balance { susceptance: b, variance, conductance, q } = Balance::of(below, above)?;
        let (found, variance) = (b / susceptance, variance / (susceptance * susceptance));
        // What has changed is not the clamped capacitance.
        if self.due != Due::Begun && !(PLAUSIBLE.0..PLAUSIBLE.1).contains(&found) {
            return None;
        }
        let conductance = (conductance / susceptance).abs();
        // What a lock has begun with is known better than by a single round, unless it was measured where something else is added.
        let begun = self.due == Due::Begun;
        let agrees = begun && found.abs() < WORTH * conductance;
        if begun && !agrees {
            let elsewhere = ELSEWHERE * conductance;
            self.variance = self.variance.max(elsewhere * elsewhere);
        }
        // An unexpected one may be a load that changed in the middle of it.
        let surprising = !agrees && found * found > SURPRISE * SURPRISE * (self.variance + variance);
        if surprising && !self.doubted {
            self.doubted = true;
            self.variance = self.variance.max(TARGET_DEVIATION * TARGET_DEVIATION);
            return None;
        }
        if surprising {
            self.variance += found * found;
        }
        self.doubted = false;
        self.due = Due::Drift;
        let was_off = begun.then(|| (found.abs() - SIGMAS * libm::sqrtf(variance)).max(0.0) / conductance);

        let gain = if agrees { 0.0 } else { self.variance / (self.variance + variance) };
        self.variance *= 1.0 - gain;
        // Along the clamped susceptance, as sensing turns it.
        self.motional.y0 += self.motional.axis * Phasor::new(0.0, gain * b);
        Some(Update {
            motional: self.motional,
            deviation: self.deviation(),
            round: (found, libm::sqrtf(variance)),
            was_off,
            q: Measured { value: q.value * self.unsettled(), ..q },
        })
    }
}

#[cfg(test)]
mod tests;
