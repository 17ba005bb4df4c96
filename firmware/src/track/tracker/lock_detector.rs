//! Is the loop locked?
//!
//! Locked: the phase stays within 5 degrees for [`LOCK_BLOCKS`]. Lost: it stays beyond 45 degrees for the time a load step
//! may take to settle, longer than any that is followed. In between, the last verdict stands.

use crate::seam::units::Turns;

/// Blocks within the inner bound that make a lock.
pub(crate) const LOCK_BLOCKS: u32 = 8;
const INNER_TURNS: f32 = 5.0 / 360.0;
const OUTER_TURNS: f32 = 45.0 / 360.0;
/// How long the phase may be beyond the outer bound, in time constants of the resonance and at least, in blocks.
const LOST_TIME_CONSTANTS: f32 = 4.0;
const LOST_BLOCKS: u32 = 80;
/// Blocks outside that one between the bounds makes up for.
const FORGIVEN: u32 = 4;

/// State of the lock, by the phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Lock {
    /// The lock is being acquired.
    Seeking,
    /// The phase is locked.
    Locked,
    /// The lock was lost.
    Lost,
}

/// The detector.
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
    /// Starts seeking, on a resonance with this time constant, in blocks.
    pub(crate) fn restart(&mut self, time_constant_blocks: f32) {
        *self = LockDetector {
            lost_blocks: LOST_BLOCKS.max((LOST_TIME_CONSTANTS * time_constant_blocks) as u32),
            ..LockDetector::default()
        };
    }

    /// Takes one block's phase.
    pub(crate) fn update(&mut self, phase: Turns) -> Lock {
        let size = phase.0.abs();
        self.inside = if size < INNER_TURNS { self.inside.saturating_add(1) } else { 0 };
        self.outside = match size {
            size if size > OUTER_TURNS => self.outside.saturating_add(1),
            size if size < INNER_TURNS => 0,
            // A phase that passes by on its way from one side to the other forgives little.
            _ => self.outside.saturating_sub(FORGIVEN),
        };
        if self.inside >= LOCK_BLOCKS {
            self.state = Lock::Locked;
        } else if self.outside >= self.lost_blocks {
            self.state = Lock::Lost;
        }
        self.state
    }

    /// Whether the last phase was within the outer bound.
    pub(crate) fn agrees(&self) -> bool {
        self.outside == 0
    }

    /// The verdict so far.
    pub(crate) fn state(&self) -> Lock {
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locks_inside_and_forgives_a_step() {
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
