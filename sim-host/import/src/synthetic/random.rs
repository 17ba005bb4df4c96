//! Random numbers of an example, which depend only on its number.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Stream of random numbers.
pub(crate) struct Random(Xoshiro256PlusPlus);

impl Random {
    /// Creates the stream of a seed.
    pub(crate) fn new(seed: u64) -> Self {
        Random(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Draws a number uniformly from 0 to 1.
    pub(crate) fn part(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    /// Draws a number uniformly between two values.
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.part()
    }

    /// Draws a number log-uniformly between two values.
    pub(crate) fn log(&mut self, from: f64, to: f64) -> f64 {
        from * libm::pow(to / from, self.part())
    }

    /// Draws a standard normal number.
    pub(crate) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Returns `true` with this probability.
    pub(crate) fn chance(&mut self, part: f64) -> bool {
        self.part() < part
    }

    /// Chooses one of several values.
    pub(crate) fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// Draws an integer below another.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        ((self.part() * end as f64) as usize).min(end.saturating_sub(1))
    }
}
