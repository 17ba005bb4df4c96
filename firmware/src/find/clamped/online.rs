//! Measurement of the clamped capacitance during operation: the drive steps to both sides of the
//! lock point, and the motional resistance must be equal on both.
//!
//! The error of C0 is the susceptance that makes them equal (`balance`). The method does not depend
//! on Q, Lm, the lock point, or a small tracking error. The axis and the loss of the clamped branch
//! are taken from the measurement at power-on; unlike C0, they do not change with temperature.
//!
//! The steps of a round are `+ - - +`, so that an even drift of the resonance cancels. Each round
//! is blended with the previous estimate, weighted by the two variances (Kalman 1960). A round is
//! due:
//!
//! - after the ring-up that follows a cold start or a scan, neither of which measures at the lock
//!   point. There, another resonance nearby adds to the susceptance, and images of the drive to the
//!   axis; a round removes half of the latter error;
//! - after an abrupt change of the load, because C0 may have changed with it;
//! - after a round that has corrected the branch;
//! - if C0 is configured to drift, once its possible drift exceeds the target deviation.

mod balance;

use crate::find::clamped::online::balance::{Balance, Side};
use crate::find::clamped::reading::Measured;
use crate::seam::block::LATENCY_BLOCKS;
use crate::seam::compare::is_step;
use crate::seam::config::Config;
use crate::seam::phasor::Phasor;
use crate::sense::demod::Sensed;
use crate::sense::motional::Motional;

/// Step, half bandwidths. It costs 1.1 % of the velocity once settled, and at most 1.5 % during the
/// transition (`cargo test -p scenarios clamped::online`).
const STEP_HALF_BANDWIDTHS: f32 = 0.15;
/// Minimum duration of each quarter of a round, blocks.
const QUARTER_BLOCKS: f32 = 20.0;
/// Minimum duration of each quarter of a round, time constants.
const QUARTER_TIME_CONSTANTS: f32 = 1.0;
/// Settling time after a step, in time constants: 2 % of the step remains, the same on both sides.
const SETTLE_TIME_CONSTANTS: f32 = 4.0;
/// Settling times of steady drive before about half of the rounds that follow an interrupted one:
/// if the drive is seldom steady long enough, most rounds only cost velocity. The other half begins
/// as soon as possible, else there might be no time for any.
const WAIT: u32 = 4;
/// Odd factor whose product has a random upper bit.
const HASH: u32 = 0x9e37_79b9;
/// Correction for incomplete settling with quarters of one time constant: half of 1.7 %. The true
/// value is between 1.7 % and zero; zero applies if the source resistance dominates the damping.
const UNSETTLED_REL: f32 = 0.0085;
/// Relative standard deviation of a nominal C0 that was not measured.
const NOMINAL_DEVIATION_REL: f32 = 0.05;
/// Relative standard deviation of C0 above which a round is due.
const TARGET_DEVIATION_REL: f32 = 7e-4;
/// Standard deviation at the lock point of a branch measured elsewhere, relative to the motional
/// conductance.
const ELSEWHERE_DEVIATION_REL: f32 = 0.02;
/// Range of plausible relative changes of C0 during operation.
const PLAUSIBLE_CHANGE_REL: core::ops::Range<f32> = -0.6..1.5;
/// Minimum error of the initial branch that is corrected, and correction that another round checks,
/// relative to the motional conductance: 0.15 % of the bandwidth.
const MIN_CORRECTION_REL: f32 = 0.003;
/// Maximum time constant for rounds that are not due to drift, s. A round takes 16 to 20 time
/// constants, and the longer they are, the smaller is the error of the lock point in hertz.
const MAX_TIME_CONSTANT_S: f32 = 8e-3;
/// Margin of a judgement, in standard deviations.
const MARGIN_SIGMAS: f32 = 3.0;
/// Difference from the expected result, in standard deviations, above which a round is repeated
/// before it is accepted.
const SURPRISE_SIGMAS: f32 = 6.0;

/// Measured block under drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<'a> {
    /// Phasors measured in the block.
    pub sensed: &'a Sensed,
    /// Frequency of the block, relative to the nominal one.
    pub relative: f32,
    /// Intended distance from the lock point, Hz.
    pub detune_hz: f32,
    /// Peak voltage of the drive, V.
    pub volts: f32,
    /// `true` if the loop is locked at a constant envelope of one, within all limits, and nothing
    /// else moves it off the lock point.
    pub steady: bool,
}

/// Result of a round; the new estimate is [`Online::motional`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// Error of the branch at the start of a lock beyond three standard deviations, relative to the
    /// motional conductance; `None` later.
    pub(crate) was_off: Option<f32>,
    /// Quality factor from this round alone, by the change of the motional phase between the sides.
    pub(crate) q: Measured,
}

/// Output of the estimator after a block: detuning of the drive, and result.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// Distance from the lock point to drive at, Hz.
    pub detune_hz: f32,
    /// `true` if the measured block had not settled after a step, so that its phase is not that of
    /// a steady state.
    pub hold: bool,
    /// Result of a round, at its end.
    pub update: Option<Update>,
}

/// Estimator of the clamped capacitance during operation.
#[derive(Clone, Debug)]
pub struct Online {
    block_s: f32,
    /// Maximum relative drift rate of C0, 1/s; zero disables measurements for drift.
    drift_per_s: f32,
    motional: Motional,
    /// Slope with frequency of the admittance of other resonances, S/Hz.
    slope: Phasor,
    /// Variance of the susceptance at the last round, relative to its square.
    variance: f32,
    /// Blocks since that round.
    unmeasured: u32,
    step_hz: f32,
    settle_blocks: u32,
    quarter_blocks: u32,
    /// `true` if the next round begins after [`WAIT`] settling times.
    waits: bool,
    /// Blocks of this round; zero between rounds.
    round: u32,
    /// Blocks measured since the last step.
    settled: u32,
    last_hz: f32,
    evaluation: Evaluation,
    doubted: bool,
    /// Reason of the next round.
    due: Due,
    /// Blocks of steady drive.
    steady: u32,
    /// Peak voltage of the last block, V.
    volts: f32,
}

/// Progress of a round.
#[derive(Clone, Copy, Debug)]
enum Evaluation {
    /// Sums below and above the lock point.
    Measuring([Side; 2]),
    /// Result of both; `None` if it is not finite.
    Balanced(Option<Balance>),
    /// Result of the round; `None` if it is discarded.
    Over(Option<Update>),
}

impl Default for Evaluation {
    fn default() -> Self {
        Evaluation::Measuring([Side::default(); 2])
    }
}

/// Reason for a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Due {
    /// Start of a lock.
    Begun,
    /// Abrupt change of load or resonance, or a correction.
    Changed,
    /// Possible drift of C0.
    Drift,
    /// None: another resonance is within about a bandwidth.
    Never,
}

impl Online {
    /// Creates an estimator for the nominal transducer.
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
            variance: NOMINAL_DEVIATION_REL * NOMINAL_DEVIATION_REL,
            unmeasured: 0,
            step_hz: 0.0,
            settle_blocks: 0,
            quarter_blocks: 0,
            waits: false,
            round: 0,
            settled: 0,
            last_hz: 0.0,
            evaluation: Evaluation::default(),
            doubted: false,
            due: Due::Begun,
            steady: 0,
            volts: 0.0,
        };
        online.set_resonance(resonance_hz, q);
        online
    }

    /// Starts from the result of a scan or of the measurement at power-on; `deviation` is the
    /// relative standard deviation of C0.
    pub fn seed(&mut self, motional: Motional, deviation: f32, resonance_hz: f32, q: f32) {
        self.motional = motional;
        (self.variance, self.unmeasured) = (deviation * deviation, 0);
        self.set_resonance(resonance_hz, q);
        self.slope = Phasor::new(0.0, 0.0);
        self.begin();
        self.steady = 0;
        (self.doubted, self.due, self.settled, self.waits) = (false, Due::Begun, u32::MAX, false);
    }

    /// Omits all rounds of a lock: another resonance is within about a bandwidth, so that the scan
    /// is more accurate.
    pub(crate) fn omit_rounds(&mut self) {
        self.due = Due::Never;
    }

    /// Sets the slope with frequency of the admittance of other resonances, S/Hz.
    pub(crate) fn set_slope(&mut self, slope: Phasor) {
        self.slope = slope;
    }

    /// Follows a change of the resonance by the load; it only determines the size of the steps.
    /// Does not disturb a round.
    pub(crate) fn set_resonance(&mut self, resonance_hz: f32, q: f32) {
        let tau_blocks = q / (core::f32::consts::PI * resonance_hz * self.block_s);
        self.step_hz = STEP_HALF_BANDWIDTHS * 0.5 * resonance_hz / q;
        self.settle_blocks = (SETTLE_TIME_CONSTANTS * tau_blocks) as u32 + 1;
        self.quarter_blocks = QUARTER_BLOCKS.max(QUARTER_TIME_CONSTANTS * tau_blocks) as u32;
    }

    /// Returns `true` during a round, when the drive is off the lock point on purpose.
    pub(crate) fn probes(&self) -> bool {
        self.round > 0
    }

    /// Returns `true` if another round must check the branch: after a load change or a correction.
    pub(crate) fn doubts(&self) -> bool {
        self.due == Due::Changed
    }

    /// Returns the detuning of the present round to either side, Hz; zero between rounds.
    pub(crate) fn reach_hz(&self) -> f32 {
        if self.probes() { self.step_hz } else { 0.0 }
    }

    /// Returns the clamped branch from all measurements so far.
    pub fn motional(&self) -> Motional {
        self.motional
    }

    /// Returns the relative standard deviation of the susceptance of the clamped branch.
    pub(crate) fn deviation(&self) -> f32 {
        fpu::sqrtf(self.variance())
    }

    /// Returns the variance of the susceptance, relative to its square. Since the last round C0 may
    /// have drifted steadily, also in a pause.
    fn variance(&self) -> f32 {
        let drifted = self.drift_per_s * self.block_s * self.unmeasured as f32;
        self.variance + drifted * drifted
    }

    /// Returns `true` if the block must be passed to [`step`](Self::step); other blocks need no
    /// processing. `level`: the envelope is one throughout. `changed`: load or resonance have
    /// changed abruptly, so that a round becomes due.
    #[inline]
    pub(crate) fn listens(&mut self, level: bool, changed: bool) -> bool {
        // Steps of the estimator itself look like an abrupt change.
        if self.round > 0 || self.settled < self.settle_blocks {
            return true;
        }
        if changed && self.due == Due::Drift {
            self.due = Due::Changed;
        }
        if !level || changed {
            self.rest();
            return false;
        }
        self.may_be_due()
    }

    /// Records a block that cannot be measured: the resonance must ring up again.
    #[inline]
    pub(crate) fn rest(&mut self) {
        self.steady = 0;
        self.unmeasured = self.unmeasured.saturating_add(1);
    }

    /// Processes a block and returns the detuning to drive at, and the result after a round.
    // Not inlined: few blocks need it, and the others must not pay for its registers.
    #[inline(never)]
    pub fn step(&mut self, sample: &Sample) -> Output {
        self.unmeasured = self.unmeasured.saturating_add(1);
        let stepped = (sample.detune_hz - self.last_hz).abs() > 0.5 * self.step_hz;
        self.settled = if stepped { 0 } else { self.settled.saturating_add(1) };
        self.last_hz = sample.detune_hz;
        let hold = self.settled < self.settle_blocks;
        let before_v = core::mem::replace(&mut self.volts, sample.volts);
        let steady = sample.steady && !(self.steady > 0 && is_step(before_v, sample.volts));
        self.steady = if steady { self.steady.saturating_add(1) } else { 0 };
        let last = self.round_blocks() + LATENCY_BLOCKS as u32 + 1;
        if self.round >= last || !matches!(self.evaluation, Evaluation::Measuring(_)) {
            // In blocks of its own, steady or not: measuring and evaluation together are too long
            // for one.
            return Output { hold, update: self.evaluate(), ..Output::default() };
        }
        if !steady {
            self.begin();
            return Output { hold, ..Output::default() };
        }
        // An incomplete ring-up would look like a susceptance.
        let wait = if self.waits { WAIT } else { 1 };
        if self.round == 0 && (self.steady < wait * self.settle_blocks || !self.is_due()) {
            return Output { hold, ..Output::default() };
        }
        if self.round == 0 {
            // For the next round, if this one is interrupted. By chance: a drive whose steady times
            // alternate must not prevent every round.
            self.waits = self.unmeasured.wrapping_mul(HASH) >> 31 != 0;
        }
        self.listen(sample, hold);
        self.round += 1;
        Output { detune_hz: self.probe_hz(), hold, update: None }
    }

    /// Advances the evaluation by one part. Returns the result after the last one.
    fn evaluate(&mut self) -> Option<Update> {
        match self.evaluation {
            Evaluation::Measuring([ref below, ref above]) => {
                self.evaluation = Evaluation::Balanced(Balance::from_sides(below, above));
            }
            Evaluation::Balanced(balance) => {
                self.waits = false;
                self.evaluation = Evaluation::Over(balance.and_then(|balance| self.weigh(&balance)));
            }
            Evaluation::Over(update) => {
                self.begin();
                return update;
            }
        }
        None
    }

    /// Ends or discards the present round.
    fn begin(&mut self) {
        if self.round > 0 {
            (self.round, self.evaluation) = (0, Evaluation::default());
        }
    }

    /// Returns `true` if a round is due, apart from the time that the drive must be steady.
    fn is_due(&self) -> bool {
        let has_drifted = || self.variance() >= TARGET_DEVIATION_REL * TARGET_DEVIATION_REL;
        self.may_be_due() && (self.due != Due::Drift || has_drifted())
    }

    /// Returns `true` if a round may be due; with a configured drift the variance must be advanced.
    fn may_be_due(&self) -> bool {
        match self.due {
            Due::Begun | Due::Changed => self.settle_blocks as f32 * self.block_s < SETTLE_TIME_CONSTANTS * MAX_TIME_CONSTANT_S,
            Due::Drift => self.drift_per_s > 0.0,
            Due::Never => false,
        }
    }

    /// Returns the blocks of a round: three settling times and four quarters, two of them in the
    /// middle.
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

    /// Returns the factor that corrects Q for incomplete settling. The phase turns too little by
    /// `(3 (1 - e^-n) / 2 + (1 - e^-2n)) e^-s / 2 n` after `s` time constants, with quarters of
    /// `n`; half of it is corrected.
    fn unsettled(&self) -> f32 {
        1.0 + UNSETTLED_REL * (self.settle_blocks as f32 / (SETTLE_TIME_CONSTANTS * self.quarter_blocks as f32)).min(1.0)
    }

    fn listen(&mut self, sample: &Sample, hold: bool) {
        let square = sample.sensed.v.norm_sqr();
        let Evaluation::Measuring(sides) = &mut self.evaluation else { return };
        let side = &mut sides[usize::from(sample.detune_hz > 0.0)];
        if hold || sample.detune_hz.abs() < 0.5 * self.step_hz || square == 0.0 {
            side.pause();
            return;
        }
        let current = self.motional.current(sample.sensed, sample.relative) - self.slope * sample.sensed.v * sample.detune_hz;
        side.add(self.motional.phase_of(current, sample.sensed.v) / square, sample.relative);
    }

    /// Weighs the result of the round against the previous estimate.
    fn weigh(&mut self, balance: &Balance) -> Option<Update> {
        let susceptance = self.motional.y0.im;
        let Balance { susceptance: b, variance, conductance, q } = *balance;
        (self.variance, self.unmeasured) = (self.variance(), 0);
        let (found, variance) = (b / susceptance, variance / (susceptance * susceptance));
        // So large a change is not one of the clamped capacitance.
        if self.due != Due::Begun && !PLAUSIBLE_CHANGE_REL.contains(&found) {
            return None;
        }
        let conductance = (conductance / susceptance).abs();
        // The initial branch is more accurate than a round, unless it differs at the lock point.
        let begun = self.due == Due::Begun;
        let agrees = begun && found.abs() < MIN_CORRECTION_REL * conductance;
        if begun && !agrees {
            let elsewhere = ELSEWHERE_DEVIATION_REL * conductance;
            self.variance = self.variance.max(elsewhere * elsewhere);
        }
        // An unexpected result may come from a load change during the round.
        let surprising = !agrees && found * found > SURPRISE_SIGMAS * SURPRISE_SIGMAS * (self.variance + variance);
        if surprising && !self.doubted {
            self.doubted = true;
            self.variance = self.variance.max(TARGET_DEVIATION_REL * TARGET_DEVIATION_REL);
            return None;
        }
        if surprising {
            self.variance += found * found;
        }
        self.doubted = false;
        let was_off = begun.then(|| (found.abs() - MARGIN_SIGMAS * fpu::sqrtf(variance)).max(0.0) / conductance);

        let gain = if agrees { 0.0 } else { self.variance / (self.variance + variance) };
        self.variance *= 1.0 - gain;
        // A round is less accurate the further the branch is off, so that a correction is checked.
        self.due = if gain * found.abs() < MIN_CORRECTION_REL * conductance { Due::Drift } else { Due::Changed };
        // Along the clamped susceptance as rotated by the sensing chain.
        self.motional.y0 += self.motional.axis * Phasor::new(0.0, gain * b);
        Some(Update { was_off, q: Measured { value: q.value * self.unsettled(), ..q } })
    }
}

#[cfg(test)]
mod tests;
