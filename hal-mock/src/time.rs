//! Virtual time: all mocks read it, and only the block stream (or a test that stalls the stream)
//! advances it.
//!
//! `now = samples / sample_hz`. Samples are counted instead of nanoseconds, so that no run drifts
//! at any rate.

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use firmware::seam::block::{DriveBlock, SenseBlock};

use crate::analog::Analog;

/// Virtual clock. Its clones show the same time.
#[derive(Clone, Debug)]
pub struct Clock {
    samples: Rc<Cell<u64>>,
    sample_hz: u32,
}

impl Clock {
    /// Creates a clock at zero, for a sample rate in Hz.
    pub fn new(sample_hz: u32) -> Self {
        Clock { samples: Rc::default(), sample_hz: sample_hz.max(1) }
    }

    /// Returns the time since the start.
    pub fn now(&self) -> Duration {
        let (samples, hz) = (self.samples.get(), u64::from(self.sample_hz));
        Duration::new(samples / hz, ((samples % hz) * 1_000_000_000 / hz) as u32)
    }

    /// Returns the number of samples since the start.
    pub fn samples(&self) -> u64 {
        self.samples.get()
    }

    /// Advances the time by this number of sample periods.
    pub fn advance(&self, samples: u64) {
        self.samples.set(self.samples.get() + samples);
    }
}

/// Middleware on the converters: each block advances the time by its number of samples. Nothing
/// else advances time, so a block clock without this middleware has no cost.
#[derive(Clone, Debug)]
pub struct Timed<A> {
    /// Analog side whose blocks take time.
    pub inner: A,
    clock: Clock,
}

impl<A> Timed<A> {
    /// Creates the middleware: blocks played on `inner` advance `clock`.
    pub fn new(inner: A, clock: Clock) -> Self {
        Timed { inner, clock }
    }
}

impl<A: Analog> Analog for Timed<A> {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.inner.exchange(drive, sense);
        self.clock.advance(drive.lanes.first().map_or(0, |lane| lane.len()) as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loop_back::LoopBack;

    #[test]
    fn a_block_takes_its_samples() {
        let clock = Clock::new(1_000_000);
        let mut timed = Timed::new(LoopBack::new(2048, 1.0), clock.clone());
        for _ in 0..31_250 {
            timed.exchange(&DriveBlock::silent(2, 32, 2048), &mut SenseBlock::default());
        }
        assert_eq!(clock.now(), Duration::from_secs(1));
    }

    #[test]
    fn an_odd_rate_does_not_drift() {
        let clock = Clock::new(44_100);
        (0..44_100 * 3).for_each(|_| clock.advance(1));
        assert_eq!((clock.now(), clock.samples()), (Duration::from_secs(3), 132_300));
        clock.advance(1);
        assert_eq!(clock.now().subsec_nanos(), 22_675);
    }
}
