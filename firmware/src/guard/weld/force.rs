//! Detection of a belt at rest by the force channel, independent of the encoder.
//!
//! Under vibration a moving contact has a mean friction of `mu N (2 / pi) asin(V / Vv)`, or less
//! with the bristles of a real contact. At rest the mean is zero after a few periods: the tip drags
//! the belt equally in both directions. The channel learns the mean force while the drive is ON and
//! settled. Less than `LOW_FORCE_REL` of it for `HOLD_S` means that the belt is at rest: fault 42,
//! unless the encoder has detected the stop by then. Without ultrasound a stopped belt keeps its
//! force, but then nothing welds it.
//!
//! The check needs a drive that is ON for longer than its settling time (`SETTLE_S` and the
//! channel's own time), and a force of at least four times its noise; otherwise it does not judge.
//! It cannot detect a belt that was at rest from the beginning. After a change of amplitude it
//! learns again.
//!
//! A channel is broken (fault 46) if its reading is missing, is not a number, or stays the same to
//! the last bit for `STUCK_S` under drive. The converter's noise must therefore exceed its last
//! bit. For the tension of a belt that restrains an occupant in a crash, this is the only check.

use crate::seam::config::Config;
use crate::seam::fault::Fault;

/// Mean force below which the belt is at rest, relative to the learned force.
const LOW_FORCE_REL: f32 = 0.25;
/// Duration of a low force that raises a fault, s: longer than the encoder needs.
const HOLD_S: f32 = 3e-3;
/// Settling time after a change of the drive or its amplitude, s.
const SETTLE_S: f32 = 3e-3;
/// Additional settling time, in time constants `1 / (2 pi f)` of the channel.
const SETTLE_TIME_CONSTANTS: f32 = 5.0;
/// Longest time for which a reading may stay the same, s.
const STUCK_S: f32 = 32e-3;
/// Relative change of the amplitude set point after which the force is learned again.
const AMPLITUDE_CHANGE_REL: f32 = 0.1;
/// Smoothing factor of the mean, per block; a power of two.
const MEAN_SMOOTHING: f32 = 1.0 / 8.0;
/// Smoothing factor of the scatter, per block; a power of two.
const SCATTER_SMOOTHING: f32 = 1.0 / 64.0;
/// Smoothing factor of the learned force, per block; a power of two.
const LEARN_SMOOTHING: f32 = 1.0 / 2048.0;
/// Smallest ratio of learned force to scatter at which the force is judged.
const MIN_FORCE_SCATTERS: f32 = 4.0;
/// Number of low blocks cancelled by a block that is not low: noise may raise the mean briefly.
const CANCELLED_BLOCKS: u32 = 8;

/// State of the force check.
#[derive(Clone, Debug)]
pub(crate) struct ForceWatch {
    /// `true` if a force channel is configured.
    has_channel: bool,
    /// `true` if the channel measures the friction under the tip; `false` if it measures the
    /// tension of a belt in a crash, which varies by itself.
    is_friction: bool,
    settle_blocks: u32,
    hold_blocks: u32,
    stuck_blocks: u32,
    last: f32,
    same: u32,
    /// Blocks since the drive or its amplitude changed.
    settled: u32,
    amplitude: f32,
    mean: f32,
    scatter: f32,
    learned: f32,
    low: u32,
}

impl ForceWatch {
    /// Builds the check for a channel of the configured bandwidth.
    pub(crate) fn build(config: &Config, block_s: f32) -> Self {
        let hz = config.front_end.force_hz;
        let channel_s = hz.map_or(0.0, |hz| SETTLE_TIME_CONSTANTS / (core::f32::consts::TAU * hz));
        ForceWatch {
            has_channel: hz.is_some(),
            is_friction: config.restraint.is_none(),
            settle_blocks: ((SETTLE_S + channel_s) / block_s) as u32,
            hold_blocks: (HOLD_S / block_s) as u32,
            stuck_blocks: (STUCK_S / block_s) as u32,
            last: 0.0,
            same: 0,
            settled: 0,
            amplitude: 0.0,
            mean: 0.0,
            scatter: 0.0,
            learned: 0.0,
            low: 0,
        }
    }

    /// Resets the check for a new attempt: the force is learned again.
    pub(super) fn begin(&mut self) {
        (self.settled, self.same, self.low) = (0, 0, 0);
    }

    /// Checks one block. `force` is the reading, N. `driving` is `true` if the drive was ON in any
    /// part of the block, `full` if throughout. `amplitude` is its set point.
    pub(super) fn step(&mut self, force: Option<f32>, driving: bool, full: bool, amplitude: f32) -> Option<Fault> {
        if !self.has_channel || !driving {
            (self.settled, self.same) = (0, 0);
            return None;
        }
        let Some(force) = force.filter(|force| force.is_finite()) else {
            return Some(Fault::ForceSensorImplausible);
        };
        self.same = if force == self.last { self.same + 1 } else { 0 };
        self.last = force;
        if self.same > self.stuck_blocks {
            return Some(Fault::ForceSensorImplausible);
        }
        if !full || (amplitude - self.amplitude).abs() > AMPLITUDE_CHANGE_REL * self.amplitude.abs() {
            self.amplitude = amplitude;
            self.settled = 0;
            return None;
        }
        (self.is_friction && self.judge(force)).then_some(Fault::BeltSensorImplausible)
    }

    /// Returns `true` if the force has been that of a belt at rest for `HOLD_S`.
    fn judge(&mut self, force: f32) -> bool {
        self.settled = self.settled.saturating_add(1);
        if self.settled <= self.settle_blocks {
            (self.mean, self.learned, self.low) = (force, force, 0);
            return false;
        }
        let off = force - self.mean;
        self.mean += MEAN_SMOOTHING * off;
        self.scatter += SCATTER_SMOOTHING * (off.abs() - self.scatter);
        // The belt may move in either direction.
        let (mean, learned) = if self.learned < 0.0 { (-self.mean, -self.learned) } else { (self.mean, self.learned) };
        if mean >= LOW_FORCE_REL * learned || learned < MIN_FORCE_SCATTERS * self.scatter {
            self.low = self.low.saturating_sub(CANCELLED_BLOCKS);
            self.learned += LEARN_SMOOTHING * (self.mean - self.learned);
            return false;
        }
        self.low += 1;
        self.low > self.hold_blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLOCK_S: f32 = 32e-6;

    fn watch() -> ForceWatch {
        ForceWatch {
            has_channel: true,
            is_friction: true,
            settle_blocks: 143,
            hold_blocks: 93,
            stuck_blocks: 1000,
            last: 0.0,
            same: 0,
            settled: 0,
            amplitude: 3.0,
            mean: 0.0,
            scatter: 0.0,
            learned: 0.0,
            low: 0,
        }
    }

    /// Returns readings of a force with uniform noise of ± `noise`, reproducible in every run.
    fn readings(force: f32, noise: f32) -> impl FnMut() -> f32 {
        let mut state = 1u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            force + noise * ((state >> 8) as f32 / (1 << 23) as f32 - 1.0)
        }
    }

    fn run(watch: &mut ForceWatch, blocks: u32, mut force: impl FnMut() -> f32) -> Option<(u32, Fault)> {
        (0..blocks).find_map(|n| Some((n, watch.step(Some(force()), true, true, 3.0)?)))
    }

    #[test]
    fn a_lasting_loss_of_force_is_a_belt_at_rest() {
        for sign in [1.0, -1.0] {
            let mut watch = watch();
            assert_eq!(run(&mut watch, 5000, readings(sign, 0.1)), None);
            // A dip of 2 ms is not a fault.
            assert_eq!(run(&mut watch, 62, readings(0.0, 0.1)), None);
            assert_eq!(run(&mut watch, 1000, readings(sign, 0.1)), None);
            let (blocks, fault) = run(&mut watch, 1000, readings(0.0, 0.1)).expect("a fault: the belt is at rest");
            assert_eq!(fault, Fault::BeltSensorImplausible);
            // The mean falls to a quarter in 0.33 ms; a low mean for 3 ms raises the fault.
            let ms = blocks as f32 * BLOCK_S * 1e3;
            assert!((3.2..3.5).contains(&ms), "{ms}");
        }
    }

    #[test]
    fn a_force_within_its_noise_is_not_judged() {
        let mut watch = watch();
        assert_eq!(run(&mut watch, 20_000, readings(0.05, 0.3)), None);
        assert_eq!(run(&mut watch, 20_000, readings(0.0, 0.3)), None);
    }

    #[test]
    fn a_new_amplitude_and_a_pause_restart_learning() {
        let mut watch = watch();
        assert_eq!(run(&mut watch, 5000, readings(1.0, 0.05)), None);
        let mut quiet = readings(0.2, 0.05);
        let found = (0..2000).find_map(|_| watch.step(Some(quiet()), true, true, 5.0));
        assert_eq!(found, None);
        assert_eq!(watch.step(Some(1.0), false, false, 5.0), None);
        let mut quieter = readings(0.05, 0.01);
        let found = (0..2000).find_map(|_| watch.step(Some(quieter()), true, true, 5.0));
        assert_eq!(found, None);
    }

    #[test]
    fn a_stuck_missing_or_nan_reading_is_a_fault() {
        let broken = Some(Fault::ForceSensorImplausible);
        let mut stuck = watch();
        assert_eq!(run(&mut stuck, 1000, || 1.0), None);
        assert_eq!(run(&mut stuck, 2, || 1.0).map(|(_, fault)| fault), broken);
        for reading in [None, Some(f32::NAN), Some(f32::INFINITY)] {
            assert_eq!(watch().step(reading, true, true, 3.0), broken, "{reading:?}");
        }
        // No fault while the drive is silent.
        assert_eq!(watch().step(None, false, false, 3.0), None);
    }

    /// Returns the check of a 1 kHz channel, with a change of the configuration.
    fn built(change: impl FnOnce(&mut Config)) -> ForceWatch {
        let mut config = crate::board::parameters::tests::config();
        config.front_end.force_hz = Some(1e3);
        change(&mut config);
        ForceWatch::build(&config, BLOCK_S)
    }

    /// Runs `blocks` at 1 N, then a force of `low`, N; returns the number of low blocks until a
    /// fault.
    fn gone_after(watch: &mut ForceWatch, blocks: u32, low: f32) -> Option<u32> {
        assert_eq!(run(watch, blocks, readings(1.0, 1e-4)), None);
        run(watch, 900, readings(low, 1e-4)).map(|(after, _)| after)
    }

    #[test]
    fn nothing_is_judged_before_drive_and_channel_have_settled() {
        // 3 ms and 0.8 ms of the channel: 118 blocks after the one in which the drive began. The
        // first block after them is learned.
        assert_eq!(gone_after(&mut built(|_| {}), 1 + 117, 0.1), None);
        // The mean falls to a quarter in 14 blocks; 93 more are 3 ms.
        assert_eq!(gone_after(&mut built(|_| {}), 1 + 118, 0.1), Some(14 + 92));
        // A channel of 100 Hz takes 8 ms more.
        let slow = |blocks: u32| gone_after(&mut built(|config| config.front_end.force_hz = Some(100.0)), blocks, 0.1);
        assert_eq!((slow(1 + 341), slow(1 + 342).is_some()), (None, true));
    }

    #[test]
    fn a_quarter_of_the_force_is_a_moving_belt() {
        for (low, stands) in [(0.28, false), (0.22, true)] {
            assert_eq!(gone_after(&mut built(|_| {}), 1000, low).is_some(), stands, "{low}");
            assert!(gone_after(&mut built(|_| {}), 1000, -low).is_some(), "{low}");
        }
    }

    #[test]
    fn no_force_is_judged_without_a_channel_or_in_a_crash() {
        assert_eq!(gone_after(&mut built(|config| config.front_end.force_hz = None), 1000, 0.0), None);
        let restraint = |config: &mut Config| config.restraint = Some(crate::seam::config::Restraint::default());
        assert_eq!(gone_after(&mut built(restraint), 1000, 0.0), None);
        assert_eq!(built(|config| config.front_end.force_hz = None).step(None, true, true, 3.0), None);
        // The channel of a crash is still checked for readings.
        assert_eq!(built(restraint).step(None, true, true, 3.0), Some(Fault::ForceSensorImplausible));
    }

    #[test]
    fn a_reading_may_stay_the_same_for_1000_driven_blocks() {
        let broken = Some(Fault::ForceSensorImplausible);
        let mut stuck = built(|_| {});
        assert!((0..=1000).all(|_| stuck.step(Some(2.0), true, true, 3.0).is_none()));
        assert_eq!(stuck.step(Some(2.0), true, true, 3.0), broken);
        // A pause, a different reading and a new attempt restart the count.
        let mut again = built(|_| {});
        for n in 0..3 {
            assert!((0..1000).all(|_| again.step(Some(2.0), true, true, 3.0).is_none()), "{n}");
            match n {
                0 => assert_eq!(again.step(Some(2.0), false, false, 3.0), None),
                1 => assert_eq!(again.step(Some(2.1), true, true, 3.0), None),
                _ => again.begin(),
            }
        }
        assert!((0..1000).all(|_| again.step(Some(2.0), true, true, 3.0).is_none()));
    }

    #[test]
    fn an_amplitude_within_a_tenth_is_the_same() {
        for (amplitude, learned_again) in [(3.29, false), (2.71, false), (3.31, true), (2.69, true), (-3.0, true)] {
            let mut watch = built(|_| {});
            assert_eq!(run(&mut watch, 1000, readings(1.0, 1e-4)), None);
            let mut low = readings(0.1, 1e-4);
            let stands = (0..900).any(|_| watch.step(Some(low()), true, true, amplitude).is_some());
            assert_eq!(stands, !learned_again, "{amplitude} V");
        }
        // Blocks that are not full and a new attempt also start to learn again.
        let mut watch = built(|_| {});
        assert_eq!(run(&mut watch, 1000, readings(1.0, 1e-4)), None);
        let mut low = readings(0.1, 1e-4);
        assert_eq!(watch.step(Some(low()), true, false, 3.0), None);
        assert!((0..900).all(|_| watch.step(Some(low()), true, true, 3.0).is_none()));
        assert_eq!(run(&mut watch, 1000, readings(1.0, 1e-4)), None);
        watch.begin();
        assert!((0..900).all(|_| watch.step(Some(low()), true, true, 3.0).is_none()));
    }

    #[test]
    fn each_good_block_cancels_eight_low_ones() {
        // In ten blocks one that is not low cancels eight low ones: the count never reaches 93.
        for (every, stands) in [(9, false), (30, true)] {
            let mut watch = built(|_| {});
            assert_eq!(run(&mut watch, 1000, readings(1.0, 1e-4)), None);
            (watch.mean, watch.scatter) = (0.0, 0.0);
            let found = (0..900).any(|n: u32| {
                // Sets the mean directly.
                watch.mean = if n.is_multiple_of(every) { 1.0 } else { 0.0 };
                watch.step(Some(watch.mean + 1e-6 * n as f32), true, true, 3.0).is_some()
            });
            assert_eq!(found, stands, "{every}");
        }
    }

    #[test]
    fn a_force_must_be_four_times_its_scatter() {
        // A force of 1 N with uniform noise: the scatter is half of its amplitude.
        for (noise, judged) in [(0.4, true), (0.62, false)] {
            let mut watch = built(|_| {});
            assert_eq!(run(&mut watch, 3000, readings(1.0, noise)), None);
            let found = run(&mut watch, 900, readings(0.0, noise));
            assert_eq!(found.is_some(), judged, "{noise}");
        }
    }

    #[test]
    fn the_learned_force_follows_slowly() {
        // From 1 N to 0.4 N, which is not low: after 2048 blocks 63 % of the change is learned.
        let mut watch = built(|_| {});
        assert_eq!(run(&mut watch, 1000, readings(1.0, 1e-4)), None);
        assert_eq!(run(&mut watch, 2048, readings(0.4, 1e-4)), None);
        assert!((watch.learned - 0.62).abs() < 0.01, "{}", watch.learned);
    }
}
