//! What the force channel says of the belt's motion, whatever the encoder says.
//!
//! Under vibration the mean friction of a moving contact is `mu N (2 / pi) asin(V / Vv)` or what its bristles make of it, and that of a
//! standing one is zero after a few periods: the tip drags it as far one way as the other. The channel learns the mean force while
//! the drive is ON and settled, and takes less than `LOW` of it, for `HOLD_S`, for a belt that stands: fault 42, where the encoder has
//! not said so by then. Without ultrasound a belt that has stopped keeps its force, but then there is nothing to weld it.
//!
//! Valid where the drive is ON for longer than it takes to settle (`SETTLE_S` and the channel's own time), and where the force stands out
//! of its noise: shorter bursts, and forces of less than four times the noise, are not judged. A belt that has stood from the beginning cannot be
//! recognized by it. A new amplitude is learned again.
//!
//! A channel whose reading is no number, is missing, or is the same to the last bit for `STUCK_S` under drive is broken: fault 46. A
//! converter's noise must be more than its last bit. That is all that is asked of the tension of a belt that restrains an occupant in a crash.

use crate::seam::config::Config;
use crate::seam::fault::Fault;

/// A mean force below this part of what has been learned is that of a belt that stands.
const LOW: f32 = 0.25;
/// For so long, s: longer than the encoder takes.
const HOLD_S: f32 = 3e-3;
/// After the drive or its amplitude has changed, s; and so many times the channel's `1 / (2 pi f)` more.
const SETTLE_S: f32 = 3e-3;
const CHANNEL_TIMES: f32 = 5.0;
/// A reading may stay the same for so long, s.
const STUCK_S: f32 = 32e-3;
/// An amplitude that differs by this part is another one.
const OTHER_AMPLITUDE: f32 = 0.1;
/// Memory of the mean and of the scatter, and of what has been learned, blocks: powers of two.
const MEAN: f32 = 1.0 / 8.0;
const SCATTER: f32 = 1.0 / 64.0;
const LEARN: f32 = 1.0 / 2048.0;
/// The force must be so many times its scatter.
const ABOVE_SCATTER: f32 = 4.0;
/// A block that is not low takes back so many that were: noise may lift the mean for a moment.
const TAKES_BACK: u32 = 8;

/// The watch over the force channel.
#[derive(Clone, Debug)]
pub(crate) struct ForceWatch {
    /// A force channel is configured.
    has_channel: bool,
    /// The channel measures the friction under the tip, and not the tension of a belt in a crash, which comes and goes by itself.
    is_friction: bool,
    settle_blocks: u32,
    hold_blocks: u32,
    stuck_blocks: u32,
    last: f32,
    same: u32,
    /// Blocks since drive and amplitude are what they are.
    settled: u32,
    asked: f32,
    mean: f32,
    scatter: f32,
    learned: f32,
    low: u32,
}

impl ForceWatch {
    /// A watch of a channel of the configured bandwidth.
    pub(crate) fn build(config: &Config, block_s: f32) -> Self {
        let hz = config.front_end.force_hz;
        let channel_s = hz.map_or(0.0, |hz| CHANNEL_TIMES / (core::f32::consts::TAU * hz));
        ForceWatch {
            has_channel: hz.is_some(),
            is_friction: config.restraint.is_none(),
            settle_blocks: ((SETTLE_S + channel_s) / block_s) as u32,
            hold_blocks: (HOLD_S / block_s) as u32,
            stuck_blocks: (STUCK_S / block_s) as u32,
            last: 0.0,
            same: 0,
            settled: 0,
            asked: 0.0,
            mean: 0.0,
            scatter: 0.0,
            learned: 0.0,
            low: 0,
        }
    }

    /// A new attempt begins: nothing has been learned.
    pub(super) fn begin(&mut self) {
        (self.settled, self.same, self.low) = (0, 0, 0);
    }

    /// Takes one block's reading, N; whether the drive was on in it at all and throughout, and the amplitude asked for.
    pub(super) fn step(&mut self, force: Option<f32>, driving: bool, full: bool, asked: f32) -> Option<Fault> {
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
        if !full || (asked - self.asked).abs() > OTHER_AMPLITUDE * self.asked.abs() {
            self.asked = asked;
            self.settled = 0;
            return None;
        }
        (self.is_friction && self.judge(force)).then_some(Fault::BeltSensorImplausible)
    }

    /// Whether a belt with this force stands.
    fn judge(&mut self, force: f32) -> bool {
        self.settled = self.settled.saturating_add(1);
        if self.settled <= self.settle_blocks {
            (self.mean, self.learned, self.low) = (force, force, 0);
            return false;
        }
        let off = force - self.mean;
        self.mean += MEAN * off;
        self.scatter += SCATTER * (off.abs() - self.scatter);
        // Either way the belt may move.
        let (mean, learned) = if self.learned < 0.0 { (-self.mean, -self.learned) } else { (self.mean, self.learned) };
        if mean >= LOW * learned || learned < ABOVE_SCATTER * self.scatter {
            self.low = self.low.saturating_sub(TAKES_BACK);
            self.learned += LEARN * (self.mean - self.learned);
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
            asked: 3.0,
            mean: 0.0,
            scatter: 0.0,
            learned: 0.0,
            low: 0,
        }
    }

    /// A force with a noise of `noise` to either side, the same numbers in every run.
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
    fn a_force_that_goes_and_stays_away_is_a_belt_that_stands() {
        for sign in [1.0, -1.0] {
            let mut watch = watch();
            assert_eq!(run(&mut watch, 5000, readings(sign, 0.1)), None);
            // Not by a dip of 2 ms.
            assert_eq!(run(&mut watch, 62, readings(0.0, 0.1)), None);
            assert_eq!(run(&mut watch, 1000, readings(sign, 0.1)), None);
            let (blocks, fault) = run(&mut watch, 1000, readings(0.0, 0.1)).expect("it stands");
            assert_eq!(fault, Fault::BeltSensorImplausible);
            // The mean falls to a quarter in 0.33 ms, and is held against it for 3 ms.
            let ms = blocks as f32 * BLOCK_S * 1e3;
            assert!((3.2..3.5).contains(&ms), "{ms}");
        }
    }

    #[test]
    fn what_does_not_stand_out_of_its_noise_is_not_judged() {
        let mut watch = watch();
        assert_eq!(run(&mut watch, 20_000, readings(0.05, 0.3)), None);
        assert_eq!(run(&mut watch, 20_000, readings(0.0, 0.3)), None);
    }

    #[test]
    fn another_amplitude_and_a_pause_are_learned_again() {
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
    fn a_channel_that_is_stuck_gone_or_no_number_is_broken() {
        let broken = Some(Fault::ForceSensorImplausible);
        let mut stuck = watch();
        assert_eq!(run(&mut stuck, 1000, || 1.0), None);
        assert_eq!(run(&mut stuck, 2, || 1.0).map(|(_, fault)| fault), broken);
        for reading in [None, Some(f32::NAN), Some(f32::INFINITY)] {
            assert_eq!(watch().step(reading, true, true, 3.0), broken, "{reading:?}");
        }
        // It is no fault while the drive is silent.
        assert_eq!(watch().step(None, false, false, 3.0), None);
    }

    /// A watch of a channel of 1 kHz, at the noise of nothing but its last bits.
    fn built(change: impl FnOnce(&mut Config)) -> ForceWatch {
        let mut config = crate::board::parameters::tests::config();
        config.front_end.force_hz = Some(1e3);
        change(&mut config);
        ForceWatch::build(&config, BLOCK_S)
    }

    /// After how many blocks of `low` a force is known to be gone that was there for `blocks`.
    fn gone_after(watch: &mut ForceWatch, blocks: u32, low: f32) -> Option<u32> {
        assert_eq!(run(watch, blocks, readings(1.0, 1e-4)), None);
        run(watch, 900, readings(low, 1e-4)).map(|(after, _)| after)
    }

    #[test]
    fn nothing_is_judged_before_drive_and_channel_have_settled() {
        // 3 ms and 0.8 ms of the channel: 118 blocks after the one in which the drive has begun. What comes then is what is learned.
        assert_eq!(gone_after(&mut built(|_| {}), 1 + 117, 0.1), None);
        // The mean falls to a quarter in 14 blocks, and 93 more are 3 ms.
        assert_eq!(gone_after(&mut built(|_| {}), 1 + 118, 0.1), Some(14 + 92));
        // A channel of 100 Hz takes 8 ms more.
        let slow = |blocks: u32| gone_after(&mut built(|config| config.front_end.force_hz = Some(100.0)), blocks, 0.1);
        assert_eq!((slow(1 + 341), slow(1 + 342).is_some()), (None, true));
    }

    #[test]
    fn a_quarter_of_the_force_is_a_belt_that_moves() {
        for (low, stands) in [(0.28, false), (0.22, true)] {
            assert_eq!(gone_after(&mut built(|_| {}), 1000, low).is_some(), stands, "{low}");
            assert!(gone_after(&mut built(|_| {}), 1000, -low).is_some(), "{low}");
        }
    }

    #[test]
    fn without_a_channel_or_on_a_belt_in_a_crash_no_force_is_judged() {
        assert_eq!(gone_after(&mut built(|config| config.front_end.force_hz = None), 1000, 0.0), None);
        let restraint = |config: &mut Config| config.restraint = Some(crate::seam::config::Restraint::default());
        assert_eq!(gone_after(&mut built(restraint), 1000, 0.0), None);
        assert_eq!(built(|config| config.front_end.force_hz = None).step(None, true, true, 3.0), None);
        // But the channel of a crash must be alive.
        assert_eq!(built(restraint).step(None, true, true, 3.0), Some(Fault::ForceSensorImplausible));
    }

    #[test]
    fn a_reading_may_stay_the_same_for_a_thousand_blocks_of_drive() {
        let broken = Some(Fault::ForceSensorImplausible);
        let mut stuck = built(|_| {});
        assert!((0..=1000).all(|_| stuck.step(Some(2.0), true, true, 3.0).is_none()));
        assert_eq!(stuck.step(Some(2.0), true, true, 3.0), broken);
        // A pause, another reading, and a new attempt begin the count again.
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
        for (asked, learned_again) in [(3.29, false), (2.71, false), (3.31, true), (2.69, true), (-3.0, true)] {
            let mut watch = built(|_| {});
            assert_eq!(run(&mut watch, 1000, readings(1.0, 1e-4)), None);
            let mut low = readings(0.1, 1e-4);
            let stands = (0..900).any(|_| watch.step(Some(low()), true, true, asked).is_some());
            assert_eq!(stands, !learned_again, "{asked} V");
        }
        // So are blocks that are not full, and what a new attempt finds.
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
    fn a_force_that_comes_and_goes_takes_back_eight_blocks_for_each() {
        // Of ten blocks one that is not low takes back eight: it never comes to 93.
        for (every, stands) in [(9, false), (30, true)] {
            let mut watch = built(|_| {});
            assert_eq!(run(&mut watch, 1000, readings(1.0, 1e-4)), None);
            (watch.mean, watch.scatter) = (0.0, 0.0);
            let found = (0..900).any(|n: u32| {
                // The mean itself comes and goes.
                watch.mean = if n.is_multiple_of(every) { 1.0 } else { 0.0 };
                watch.step(Some(watch.mean + 1e-6 * n as f32), true, true, 3.0).is_some()
            });
            assert_eq!(found, stands, "{every}");
        }
    }

    #[test]
    fn a_force_must_stand_out_of_its_noise_four_times() {
        // Of a force of 1 N, whose readings are uniform to either side: a scatter of half of it.
        for (noise, judged) in [(0.4, true), (0.62, false)] {
            let mut watch = built(|_| {});
            assert_eq!(run(&mut watch, 3000, readings(1.0, noise)), None);
            let found = run(&mut watch, 900, readings(0.0, noise));
            assert_eq!(found.is_some(), judged, "{noise}");
        }
    }

    #[test]
    fn what_is_learned_follows_slowly() {
        // From 1 N to 0.4 N within 10 ms, which is not low; after 2048 blocks two thirds of that are learned.
        let mut watch = built(|_| {});
        assert_eq!(run(&mut watch, 1000, readings(1.0, 1e-4)), None);
        assert_eq!(run(&mut watch, 2048, readings(0.4, 1e-4)), None);
        assert!((watch.learned - 0.62).abs() < 0.01, "{}", watch.learned);
    }
}
