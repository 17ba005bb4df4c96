//! The random numbers of an example, which follow from its number alone.

use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
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

    /// Uniform between two values.
    pub(crate) fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.part()
    }

    /// Log-uniform between two values.
    pub(crate) fn log(&mut self, from: f64, to: f64) -> f64 {
        from * libm::pow(to / from, self.part())
    }

    /// Standard normal.
    pub(crate) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// True in this part of the cases.
    pub(crate) fn chance(&mut self, part: f64) -> bool {
        self.part() < part
    }

    /// One of several.
    pub(crate) fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// A whole number below another.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        ((self.part() * end as f64) as usize).min(end.saturating_sub(1))
    }
}
