//! Watchdog on virtual time: it expires if it is not fed within its period.
//!
//! On a board, expiry is a reset; here the test reads it. An expiry is permanent: later feeding
//! does not undo it.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use crate::time::Clock;

/// Watchdog. Its clones are the same watchdog, so that a test can keep one while the controller
/// feeds the other.
#[derive(Clone, Debug)]
pub struct Watchdog {
    clock: Clock,
    time: Duration,
    fed: Rc<Cell<Duration>>,
    bitten: Rc<Cell<Option<Duration>>>,
    resets: Rc<Cell<u32>>,
}

impl Watchdog {
    /// Creates a watchdog that must be fed within `time` from now.
    pub fn new(clock: &Clock, time: Duration) -> Self {
        Watchdog {
            clock: clock.clone(),
            time,
            fed: Rc::new(Cell::new(clock.now())),
            bitten: Rc::default(),
            resets: Rc::default(),
        }
    }

    /// Returns the time at which it expired, if it did.
    pub fn bitten(&self) -> Option<Duration> {
        let due = self.fed.get() + self.time;
        if self.bitten.get().is_none() && self.clock.now() > due {
            self.bitten.set(Some(due));
        }
        self.bitten.get()
    }

    /// Returns the number of ordered resets. The test must perform the reset itself.
    pub fn resets(&self) -> u32 {
        self.resets.get()
    }

    /// Returns the time of the last feeding.
    pub fn fed(&self) -> Duration {
        self.fed.get()
    }
}

impl firmware::board::app::Watchdog for Watchdog {
    fn feed(&mut self) {
        // Record an expiry that was not read yet, before it is overwritten.
        self.bitten();
        self.fed.set(self.clock.now());
    }

    fn reset(&mut self) {
        self.resets.set(self.resets.get() + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use firmware::board::app::Watchdog as _;

    #[test]
    fn expires_exactly_after_its_period() {
        let clock = Clock::new(1000);
        let mut watchdog = Watchdog::new(&clock, Duration::from_millis(10));
        for _ in 0..5 {
            clock.advance(10);
            assert_eq!(watchdog.bitten(), None);
            watchdog.feed();
        }
        clock.advance(11);
        assert_eq!(watchdog.bitten(), Some(Duration::from_millis(60)));
    }

    #[test]
    fn feeding_does_not_undo_an_expiry() {
        let clock = Clock::new(1000);
        let mut watchdog = Watchdog::new(&clock, Duration::from_millis(10));
        let seen_by_the_test = watchdog.clone();
        clock.advance(500);
        watchdog.feed();
        assert_eq!(seen_by_the_test.bitten(), Some(Duration::from_millis(10)));
        assert_eq!(seen_by_the_test.fed(), Duration::from_millis(500));
    }
}
