//! The random numbers of a run, which follow from its seed alone.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A stream of random numbers.
pub(crate) struct Random(Xoshiro256PlusPlus);

impl Random {
    /// The stream of a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Random(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Uniform in 0 to 1.
    pub(crate) fn part(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    /// Uniform in -1 to 1.
    pub(crate) fn side(&mut self) -> f64 {
        2.0 * self.part() - 1.0
    }

    /// Uniform between two values.
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.part()
    }

    /// Log-uniform between two values.
    pub(crate) fn log(&mut self, from: f64, to: f64) -> f64 {
        from * (to / from).powf(self.part())
    }

    /// A whole number from one to another, both among them.
    pub(crate) fn whole(&mut self, from: u32, to: u32) -> u32 {
        from + (self.part() * f64::from(to - from + 1)) as u32
    }

    /// One of two.
    pub(crate) fn toss(&mut self) -> bool {
        self.part() < 0.5
    }
}
