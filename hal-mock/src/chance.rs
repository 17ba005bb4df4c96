//! Seeded random numbers for the mocks that inject faults: the same seed damages the same run in
//! the same way.

use rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Seeded source of random decisions.
#[derive(Clone, Debug)]
pub struct Chance(Xoshiro256PlusPlus);

impl Chance {
    /// Creates the source of a seed.
    pub fn new(seed: u64) -> Self {
        Chance(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Returns `true` with this probability. Draws no number if the probability is zero, so that an
    /// inactive fault does not change the others.
    pub fn strikes(&mut self, probability: f64) -> bool {
        probability > 0.0 && self.part() < probability
    }

    /// Returns a random number in [0, 1).
    fn part(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    /// Returns a random number below `bound`. The bias of the remainder is negligible, because
    /// `bound` is small compared with 2^64.
    pub fn below(&mut self, bound: u64) -> u64 {
        self.0.next_u64() % bound.max(1)
    }

    /// Returns a random byte.
    pub fn byte(&mut self) -> u8 {
        self.0.next_u64() as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strikes_with_its_probability() {
        let mut chance = Chance::new(1);
        let struck = (0..100_000).filter(|_| chance.strikes(0.03)).count();
        assert!((2800..3200).contains(&struck), "{struck}");
        assert!((0..1000).all(|_| chance.strikes(1.0)));
        assert!((0..1000).all(|_| !chance.strikes(0.0)));
    }

    #[test]
    fn a_probability_of_zero_draws_nothing() {
        let (mut one, mut other) = (Chance::new(7), Chance::new(7));
        other.strikes(0.0);
        assert_eq!(one.below(1 << 60), other.below(1 << 60));
    }
}
