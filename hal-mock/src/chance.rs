//! Seeded chance for the mocks that inject faults: the same seed damages the same run in the same way.

use rand_core::{Rng, SeedableRng};
use rand_distr::{Distribution, StandardUniform};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A seeded source of decisions.
#[derive(Clone, Debug)]
pub struct Chance(Xoshiro256PlusPlus);

impl Chance {
    /// The source that belongs to a seed.
    pub fn new(seed: u64) -> Self {
        Chance(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// True with this probability. Draws nothing at a probability of zero, so that an inactive fault does not move the others.
    pub fn strikes(&mut self, probability: f64) -> bool {
        probability > 0.0 && self.part() < probability
    }

    /// A number from 0 up to 1.
    fn part(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    /// A number below `bound`, which is small against 2^64: the bias of the remainder does not matter.
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
    fn strikes_as_often_as_asked() {
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
