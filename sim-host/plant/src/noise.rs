//! Noise of the converters: two streams of normal numbers a run, one for each channel, drawn in
//! advance.
//!
//! A stream depends only on its seed. The number of values drawn at a time does not matter, nor
//! does the type that draws them ([`NoiseBatch`] for several runs at once). The generator is
//! xoshiro256++ (Blackman and Vigna 2019) with the ziggurat of `rand_distr`.

mod abreast;
mod generator;

pub(crate) use abreast::NoiseBatch;

use rand_distr::{Distribution, StandardNormal};

use crate::noise::generator::Generator;
use crate::quad::Quad;

/// Number of pairs of normal numbers drawn at a time, during which the states of the generators
/// stay in registers.
pub(crate) const PAIRS_PER_DRAW: usize = 64;

/// Normal numbers of voltage and current in turn.
#[derive(Clone, Debug)]
pub struct Noise {
    random: [Generator; 2],
    drawn: [[f64; 2]; PAIRS_PER_DRAW],
    /// Index of the first drawn number that has not been used.
    next: usize,
}

impl Noise {
    /// Creates the two streams of a seed. They never overlap: their seeds differ by half of a
    /// 64-bit space.
    pub fn new(seed: u64) -> Self {
        Noise {
            random: [seed, seed ^ (1 << 63)].map(Generator::from_seed),
            drawn: [[0.0; 2]; PAIRS_PER_DRAW],
            next: PAIRS_PER_DRAW,
        }
    }

    /// Returns the next number of each stream.
    #[inline(always)]
    pub fn pair(&mut self) -> [f64; 2] {
        if self.next >= PAIRS_PER_DRAW {
            self.draw();
        }
        let pair = self.drawn[self.next % PAIRS_PER_DRAW];
        self.next += 1;
        pair
    }

    /// Returns the next two numbers of each stream, or only the next.
    #[inline(always)]
    pub fn quad(&mut self, pairs: usize) -> Quad {
        let [v, i] = self.pair();
        let [later_v, later_i] = if pairs > 1 { self.pair() } else { [0.0; 2] };
        Quad([v, i, later_v, later_i])
    }

    #[inline(never)]
    fn draw(&mut self) {
        let [mut v, mut i] = self.random.clone();
        for pair in &mut self.drawn {
            *pair = [StandardNormal.sample(&mut v), StandardNormal.sample(&mut i)];
        }
        self.random = [v, i];
        self.next = 0;
    }
}

#[cfg(test)]
mod tests {
    use rand_core::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn both_streams_match_the_library() {
        let seed = 0x9e37_79b9_7f4a_7c15;
        let mut library = [seed, seed ^ (1 << 63)].map(Xoshiro256PlusPlus::seed_from_u64);
        let mut noise = Noise::new(seed);
        for n in 0..10_000 {
            let expected: [f64; 4] = std::array::from_fn(|k| StandardNormal.sample(&mut library[k % 2]));
            assert_eq!(noise.quad(2).0, expected, "{n}");
        }
    }

    #[test]
    fn one_pair_at_a_time_is_the_same_stream() {
        let (mut pairs, mut quads) = (Noise::new(5), Noise::new(5));
        assert_eq!(quads.quad(1).0[..2], pairs.pair());
        for _ in 0..200 {
            assert_eq!(quads.quad(2).0, [pairs.pair(), pairs.pair()].concat()[..]);
        }
    }
}
