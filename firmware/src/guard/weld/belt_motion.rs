//! The belt-motion interlock: a timer since the last new ground under the tip.
//!
//! The belt has stopped where nothing new has come for `T` = `limits.belt_stop_ms`; with `n` counts a metre, so has every belt slower than
//! `1 / (n T)`. A belt that stops is noticed within `T`. One that slows may give one count more, just before `T` is over, and is noticed
//! within `2 T`. Drive is OFF three blocks later: the one in which the count came, and two that are on their way.
//!
//! While the resonance is followed, a stop mutes the drive, and it goes on when the belt does: after `REARM_BLOCKS` blocks with new
//! ground, none more than `T / 2` after the one before, so that a belt which creeps about the threshold does not make the drive flutter.
//! A drive that has been muted for `LATCH_S` while it was requested is a fault.
//!
//! A measurement cannot be interrupted. It may take place over a belt at rest, for `LATCH_S` of drive in all; over a belt that has moved
//! since the order, a stop is a fault at once.

use super::super::Stage;
use crate::seam::config::Config;
use crate::seam::fault::Fault;
use crate::sense::belt::Belt;

/// Blocks with new ground that end a mute.
const REARM_BLOCKS: u32 = 4;
/// Longest mute, and longest measurement over a belt at rest, s.
const LATCH_S: f32 = 0.1;

/// The interlock of the drive with the motion of the belt.
#[derive(Clone, Debug)]
pub struct BeltMotion {
    stop_blocks: u32,
    latch_blocks: u32,
    muted: bool,
    /// Blocks since the last new ground, before this one.
    still: u32,
    /// Blocks with new ground that came soon after each other.
    rearmed: u32,
    /// Something has moved, or has been driven: what stands now has stopped.
    armed: bool,
    /// The encoder has been read before this block.
    met: bool,
    /// Blocks in which a requested drive was muted, or the belt was measured at rest.
    over: u32,
}

impl BeltMotion {
    /// A watch that keeps the configured limit.
    pub(crate) fn build(config: &Config, block_s: f32) -> Self {
        let stop_ms = config.limits.belt_stop_ms;
        BeltMotion {
            stop_blocks: (stop_ms * 1e-3 / block_s) as u32,
            latch_blocks: (LATCH_S / block_s) as u32,
            muted: false,
            still: u32::MAX,
            rearmed: 0,
            armed: false,
            met: false,
            over: 0,
        }
    }

    /// A new attempt begins.
    pub(super) fn begin(&mut self) {
        (self.armed, self.over) = (false, 0);
    }

    /// Whether the drive must be silent.
    pub(super) fn is_muted(&self) -> bool {
        self.muted
    }

    /// Takes one block, in which the encoder has been read; `driving` says whether anything was played in it.
    pub(super) fn step(&mut self, belt: &Belt, stage: Stage, driving: bool, requested: bool) -> Option<Fault> {
        let met = core::mem::replace(&mut self.met, true);
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
                self.over = 0;
                return None;
            }
            Stage::Measuring => {
                self.over += u32::from(self.muted && driving);
                self.muted && driving && self.armed
            }
            Stage::Following => {
                // Where nothing has ever moved or been driven, it waits.
                // Blocks measured while it waits are the end of a measurement.
                self.armed |= driving && !(self.muted && met);
                self.over = if self.muted && self.armed { self.over + u32::from(requested) } else { 0 };
                false
            }
        };
        (at_once || self.over > self.latch_blocks).then_some(Fault::BeltStopped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::block::BeltSense;

    /// 2.4 ms and 100 ms in blocks of 32 us.
    const STOP: u32 = 75;
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
                met: false,
                over: 0,
            };
            Rig { belt: Belt::of(1e-5, 32e-6), motion, counts: 0 }
        }

        /// So many blocks; the belt moves by a count in every `every`th. Returns the first fault.
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
    fn a_stop_mutes_and_becomes_a_fault_after_a_tenth_of_a_second() {
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
    fn a_moving_belt_is_driven_again_and_a_creeping_one_is_not() {
        let mut rig = Rig::new();
        rig.blocks(1000, 10, Stage::Following);
        rig.blocks(2 * STOP, NEVER, Stage::Following);
        assert!(rig.motion.is_muted());
        // Faster than the threshold, slower than it takes to go on.
        assert_eq!(rig.blocks(10 * STOP, STOP - 5, Stage::Following), None);
        assert!(rig.motion.is_muted());
        assert_eq!(rig.blocks(4 * 30, 30, Stage::Following), None);
        assert!(!rig.motion.is_muted());
        // And then it bears what it did not bear before.
        assert_eq!(rig.blocks(10 * STOP, STOP - 5, Stage::Following), None);
        assert!(!rig.motion.is_muted());
    }

    #[test]
    fn a_belt_at_rest_is_waited_for_during_a_tenth_of_a_second() {
        let mut rig = Rig::new();
        assert_eq!(rig.blocks(LATCH, NEVER, Stage::Measuring), None);
        assert_eq!(rig.blocks(100 + STOP, NEVER, Stage::Measuring), Some(Fault::BeltStopped));
        rig.motion.begin();
        // It is muted from the first block on, nothing is driven, and nothing latches.
        assert_eq!(rig.blocks(3 * LATCH, NEVER, Stage::Following), None);
        assert!(rig.motion.is_muted());
        assert_eq!(rig.blocks(100, 10, Stage::Following), None);
        assert!(!rig.motion.is_muted());
    }

    #[test]
    fn a_stop_under_a_measurement_is_a_fault_at_once() {
        let mut rig = Rig::new();
        assert_eq!(rig.blocks(100, 10, Stage::Measuring), None);
        assert_eq!(rig.blocks(STOP, NEVER, Stage::Measuring), None);
        assert_eq!(rig.blocks(1, NEVER, Stage::Measuring), Some(Fault::BeltStopped));
    }

    #[test]
    fn a_measurement_counts_where_it_is_driven_over_a_belt_at_rest() {
        // For as long as it likes over a belt that moves, and in silence over one that stands.
        assert_eq!(Rig::new().blocks(3 * LATCH, 10, Stage::Measuring), None);
        let mut rig = Rig::new();
        for n in 0..3 * LATCH {
            rig.belt.update(Some(BeltSense { counts: 0, broken: false }));
            assert_eq!(rig.motion.step(&rig.belt, Stage::Measuring, false, true), None, "{n}");
        }
        assert!((0..=LATCH).any(|_| rig.motion.step(&rig.belt, Stage::Measuring, true, true) == Some(Fault::BeltStopped)));
    }

    #[test]
    fn what_has_been_driven_before_the_belt_moved_does_not_wait_for_it() {
        // In blocks of a belt that stands: those that are driven, and whether that ends in a fault.
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
