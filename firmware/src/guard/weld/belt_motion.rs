//! The belt-motion interlock: a timer since the last new ground under the tip.
//!
//! The belt counts as stopped if no new ground has come for `T` = `limits.belt_stop_ms`. With `n`
//! counts a metre this includes every belt slower than `1 / (n T)`. A sudden stop is detected
//! within `T`. A belt that slows may give one more count just before `T` is over, and is detected
//! within `2 T`. The drive is OFF three blocks later: the block of the count, and two that are
//! queued.
//!
//! While the drive follows the resonance, a stop mutes it. It resumes after `REARM_BLOCKS` blocks
//! with new ground, none more than `T / 2` after the one before, so that a belt near the threshold
//! does not switch the drive repeatedly. A drive that is muted for `LATCH_S` while it is requested
//! raises a fault.
//!
//! A measurement cannot be interrupted. Over a belt at rest, measurements may drive for `LATCH_S`
//! in total. If the belt has moved since the order, a stop is a fault immediately.

use super::super::Stage;
use crate::seam::config::Config;
use crate::seam::fault::Fault;
use crate::sense::belt::Belt;

/// Number of blocks with new ground that end a mute.
const REARM_BLOCKS: u32 = 4;
/// Longest mute, and longest measurement over a belt at rest, s.
const LATCH_S: f32 = 0.1;

/// State of the belt-motion interlock.
#[derive(Clone, Debug)]
pub struct BeltMotion {
    stop_blocks: u32,
    latch_blocks: u32,
    muted: bool,
    /// Blocks since the last new ground, as of the block before.
    still: u32,
    /// Number of blocks with new ground, each at most half of `stop_blocks` after the one before.
    rearmed: u32,
    /// `true` if the belt has moved or the drive was ON since the order: a belt at rest has
    /// stopped.
    armed: bool,
    /// `true` if the encoder was read before this block.
    was_read: bool,
    /// Blocks in which a requested drive was muted, or a measurement drove over a belt at rest.
    latch_count: u32,
}

impl BeltMotion {
    /// Builds the interlock from the configured limit.
    pub(crate) fn build(config: &Config, block_s: f32) -> Self {
        let stop_ms = config.limits.belt_stop_ms;
        BeltMotion {
            stop_blocks: (stop_ms * 1e-3 / block_s) as u32,
            latch_blocks: (LATCH_S / block_s) as u32,
            muted: false,
            still: u32::MAX,
            rearmed: 0,
            armed: false,
            was_read: false,
            latch_count: 0,
        }
    }

    /// Resets the interlock for a new attempt. The timer and the mute remain.
    pub(super) fn begin(&mut self) {
        (self.armed, self.latch_count) = (false, 0);
    }

    /// Returns `true` if the drive must be silent.
    pub(super) fn is_muted(&self) -> bool {
        self.muted
    }

    /// Checks one block in which the encoder was read. `driving` is `true` if the drive was ON in
    /// it.
    pub(super) fn step(&mut self, belt: &Belt, stage: Stage, driving: bool, requested: bool) -> Option<Fault> {
        let was_read = core::mem::replace(&mut self.was_read, true);
        let before = core::mem::replace(&mut self.still, belt.still_blocks());
        if self.still == 0 {
            self.rearmed = if before <= self.stop_blocks / 2 { self.rearmed + 1 } else { 1 };
            self.armed = true;
            self.muted &= self.rearmed < REARM_BLOCKS;
        } else if self.still > self.stop_blocks {
            (self.muted, self.rearmed) = (true, 0);
        }
        if belt.is_lost() {
            return Some(Fault::BeltSensorLost);
        }
        let at_once = match stage {
            Stage::Silent => {
                self.latch_count = 0;
                return None;
            }
            Stage::Measuring => {
                self.latch_count += u32::from(self.muted && driving);
                self.muted && driving && self.armed
            }
            Stage::Following => {
                // Unless the belt has moved or the drive was ON, the run waits muted, without a
                // fault. A muted block with drive is the end of a measurement and does not arm.
                self.armed |= driving && !(self.muted && was_read);
                self.latch_count = if self.muted && self.armed { self.latch_count + u32::from(requested) } else { 0 };
                false
            }
        };
        (at_once || self.latch_count > self.latch_blocks).then_some(Fault::BeltStopped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::block::BeltSense;

    /// 2.4 ms in blocks of 32 us.
    const STOP: u32 = 75;
    /// 100 ms in blocks of 32 us.
    const LATCH: u32 = 3125;

    struct Rig {
        belt: Belt,
        motion: BeltMotion,
        counts: i32,
    }

    impl Rig {
        fn new() -> Self {
            let motion = BeltMotion {
                stop_blocks: STOP,
                latch_blocks: LATCH,
                muted: false,
                still: u32::MAX,
                rearmed: 0,
                armed: false,
                was_read: false,
                latch_count: 0,
            };
            Rig { belt: Belt::of(1e-5, 32e-6), motion, counts: 0 }
        }

        /// Runs `count` blocks, with one count of the encoder every `every` blocks. Returns the
        /// first fault.
        fn blocks(&mut self, count: u32, every: u32, stage: Stage) -> Option<Fault> {
            (1..=count).find_map(|n| {
                self.counts += i32::from(n.is_multiple_of(every));
                self.belt.update(Some(BeltSense { counts: self.counts, broken: false }));
                let driving = stage == Stage::Measuring || !self.motion.is_muted();
                self.motion.step(&self.belt, stage, driving, true)
            })
        }
    }

    const NEVER: u32 = u32::MAX;

    #[test]
    fn a_stop_mutes_and_is_a_fault_after_100_ms() {
        let mut rig = Rig::new();
        assert_eq!(rig.blocks(1000, 10, Stage::Following), None);
        assert!(!rig.motion.is_muted());
        assert_eq!(rig.blocks(STOP, NEVER, Stage::Following), None);
        assert!(!rig.motion.is_muted());
        assert_eq!(rig.blocks(1, NEVER, Stage::Following), None);
        assert!(rig.motion.is_muted());
        assert_eq!(rig.blocks(LATCH - 1, NEVER, Stage::Following), None);
        assert_eq!(rig.blocks(1, NEVER, Stage::Following), Some(Fault::BeltStopped));
    }

    #[test]
    fn a_moving_belt_ends_the_mute_and_a_creeping_one_does_not() {
        let mut rig = Rig::new();
        rig.blocks(1000, 10, Stage::Following);
        rig.blocks(2 * STOP, NEVER, Stage::Following);
        assert!(rig.motion.is_muted());
        // Above the speed that mutes, below the speed that ends the mute.
        assert_eq!(rig.blocks(10 * STOP, STOP - 5, Stage::Following), None);
        assert!(rig.motion.is_muted());
        assert_eq!(rig.blocks(4 * 30, 30, Stage::Following), None);
        assert!(!rig.motion.is_muted());
        // After the mute the same slow belt is accepted.
        assert_eq!(rig.blocks(10 * STOP, STOP - 5, Stage::Following), None);
        assert!(!rig.motion.is_muted());
    }

    #[test]
    fn a_measurement_over_a_belt_at_rest_may_last_100_ms() {
        let mut rig = Rig::new();
        assert_eq!(rig.blocks(LATCH, NEVER, Stage::Measuring), None);
        assert_eq!(rig.blocks(100 + STOP, NEVER, Stage::Measuring), Some(Fault::BeltStopped));
        rig.motion.begin();
        // Muted from the first block: nothing is driven, and no fault is raised.
        assert_eq!(rig.blocks(3 * LATCH, NEVER, Stage::Following), None);
        assert!(rig.motion.is_muted());
        assert_eq!(rig.blocks(100, 10, Stage::Following), None);
        assert!(!rig.motion.is_muted());
    }

    #[test]
    fn a_stop_during_a_measurement_is_a_fault_at_once() {
        let mut rig = Rig::new();
        assert_eq!(rig.blocks(100, 10, Stage::Measuring), None);
        assert_eq!(rig.blocks(STOP, NEVER, Stage::Measuring), None);
        assert_eq!(rig.blocks(1, NEVER, Stage::Measuring), Some(Fault::BeltStopped));
    }

    #[test]
    fn only_driven_blocks_over_a_belt_at_rest_count() {
        // A measurement may last over a moving belt, and in silence over a belt at rest.
        assert_eq!(Rig::new().blocks(3 * LATCH, 10, Stage::Measuring), None);
        let mut rig = Rig::new();
        for n in 0..3 * LATCH {
            rig.belt.update(Some(BeltSense { counts: 0, broken: false }));
            assert_eq!(rig.motion.step(&rig.belt, Stage::Measuring, false, true), None, "{n}");
        }
        assert!((0..=LATCH).any(|_| rig.motion.step(&rig.belt, Stage::Measuring, true, true) == Some(Fault::BeltStopped)));
    }

    #[test]
    fn a_run_driven_over_a_belt_at_rest_does_not_wait() {
        // Driven blocks over a belt at rest, and `true` if a fault results.
        for (driven, ends) in [(0..0, false), (1..2, true), (3..6, true)] {
            let mut rig = Rig::new();
            let found = (0..2 * LATCH).find_map(|n| {
                rig.belt.update(Some(BeltSense { counts: 0, broken: false }));
                rig.motion.step(&rig.belt, Stage::Following, driven.contains(&n), true)
            });
            assert_eq!(found.is_some(), ends, "{driven:?}");
        }
    }
}
