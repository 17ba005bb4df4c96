//! The lock detector.
//!
//! Locked: the phase stays within 5 degrees for [`LOCK_BLOCKS`]. Lost: it stays beyond 45 degrees
//! for longer than the settling time of any load step that is followed. In between, the state is
//! kept.

use crate::seam::units::Turns;

/// Number of consecutive blocks within the inner bound that make a lock.
pub(crate) const LOCK_BLOCKS: u32 = 8;
/// Largest phase of a lock, turns.
const INNER_TURNS: f32 = 5.0 / 360.0;
/// Phase beyond which a lock is lost, turns.
const OUTER_TURNS: f32 = 45.0 / 360.0;
/// Time beyond the outer bound after which a lock is lost, time constants of the resonance.
const LOST_TIME_CONSTANTS: f32 = 4.0;
/// Smallest number of blocks beyond the outer bound after which a lock is lost.
const LOST_BLOCKS: u32 = 80;
/// Number of outside blocks cancelled by a block between the bounds.
const CANCELLED_BLOCKS: u32 = 4;

/// State of the lock, from the phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lock {
    /// The lock is being acquired.
    Seeking,
    /// The phase is locked.
    Locked,
    /// The lock was lost.
    Lost,
}

/// State of the detector.
#[derive(Clone, Debug)]
pub(crate) struct LockDetector {
    lost_blocks: u32,
    inside: u32,
    outside: u32,
    state: Lock,
}

impl Default for LockDetector {
    fn default() -> Self {
        LockDetector { lost_blocks: LOST_BLOCKS, inside: 0, outside: 0, state: Lock::Seeking }
    }
}

impl LockDetector {
    /// Starts to seek on a resonance with this time constant, blocks.
    pub(crate) fn restart(&mut self, time_constant_blocks: f32) {
        *self = LockDetector {
            lost_blocks: LOST_BLOCKS.max((LOST_TIME_CONSTANTS * time_constant_blocks) as u32),
            ..LockDetector::default()
        };
    }

    /// Takes one block's phase, and returns the state.
    pub(crate) fn update(&mut self, phase: Turns) -> Lock {
        let size = phase.0.abs();
        self.inside = if size < INNER_TURNS { self.inside.saturating_add(1) } else { 0 };
        self.outside = match size {
            size if size > OUTER_TURNS => self.outside.saturating_add(1),
            size if size < INNER_TURNS => 0,
            // A phase that only passes from one side to the other cancels few blocks.
            _ => self.outside.saturating_sub(CANCELLED_BLOCKS),
        };
        if self.inside >= LOCK_BLOCKS {
            self.state = Lock::Locked;
        } else if self.outside >= self.lost_blocks {
            self.state = Lock::Lost;
        }
        self.state
    }

    /// Returns `true` if no block counts as outside.
    pub(crate) fn agrees(&self) -> bool {
        self.outside == 0
    }

    /// Returns the present state.
    pub(crate) fn state(&self) -> Lock {
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locks_inside_and_tolerates_a_step() {
        let mut detector = LockDetector::default();
        (0..LOCK_BLOCKS).for_each(|_| assert_ne!(detector.update(Turns(0.01)), Lock::Lost));
        assert_eq!(detector.state(), Lock::Locked);
        (0..LOST_BLOCKS - 1).for_each(|_| assert_eq!(detector.update(Turns(-0.2)), Lock::Locked));
        assert_eq!(detector.state(), Lock::Locked);
        assert_eq!(detector.update(Turns(-0.2)), Lock::Lost);
    }

    #[test]
    fn a_phase_between_the_bounds_never_locks() {
        let mut detector = LockDetector::default();
        assert!((0..1000).all(|_| detector.update(Turns(0.05)) == Lock::Seeking));
    }
}
