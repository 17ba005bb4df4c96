//! Random numbers of a run, determined by its seed alone.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Stream of random numbers.
pub(crate) struct Random(Xoshiro256PlusPlus);

impl Random {
    /// Creates the stream of a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Random(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Draws uniformly from 0 to 1.
    pub(crate) fn part(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    /// Draws uniformly from -1 to 1.
    pub(crate) fn side(&mut self) -> f64 {
        2.0 * self.part() - 1.0
    }

    /// Draws uniformly between two values.
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.part()
    }

    /// Draws log-uniformly between two values.
    pub(crate) fn log(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.part())
    }

    /// Draws an integer from `from` to `to`, both included.
    pub(crate) fn whole(&mut self, from: u32, to: u32) -> u32 {
        from + (self.part() * f64::from(to - from + 1)) as u32
    }

    /// Draws `true` or `false` with equal probability.
    pub(crate) fn toss(&mut self) -> bool {
        self.part() < 0.5
    }
}
