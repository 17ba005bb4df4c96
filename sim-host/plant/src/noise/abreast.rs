//! Noise of several runs, drawn in a batch.
//!
//! A number from the inner layers of the ziggurat, 98.8 % of all, is the product of its bits and a
//! table entry. The library draws the others from the state of the run's generator. Each run has
//! the same stream as alone, bit for bit.

use std::sync::LazyLock;

use rand_distr::{Distribution, StandardNormal};

use super::{Noise, PAIRS_PER_DRAW};
use crate::noise::generator::{Generator, Resumed, Scripted};
use crate::quad::{Kernel, LANES, Quad, Registers, Wide, run_widest};

/// Layers of the ziggurat.
const LAYERS: usize = 256;
/// Bits that turn a fraction into a number from two to four; minus three, it lies between minus one
/// and one.
const TWO_BITS: u64 = 0x4000_0000_0000_0000;

/// Edge of each layer and of the next one, as in the library.
static LAYER: LazyLock<[[f64; 2]; LAYERS]> = LazyLock::new(|| {
    let edge = |layer: usize| if layer < LAYERS { edge(layer) } else { 0.0 };
    std::array::from_fn(|layer| [edge(layer), edge(layer + 1)])
});

/// Returns the edge of a layer: the number drawn for half of it, doubled. If half the edge is
/// beyond the next layer, the library draws once more, and the script makes it accept.
fn edge(layer: usize) -> f64 {
    // The library puts the upper 52 bits after 2.0 and subtracts three.
    let half = 3.5f64.to_bits() << 12;
    let drawn: f64 = StandardNormal.sample(&mut Scripted(Some(half | layer as u64)));
    2.0 * drawn
}

/// The same word of the state of several generators.
type Words = [u64; LANES];

/// Batched noise of several runs.
#[derive(Clone, Debug)]
pub(crate) struct NoiseBatch {
    /// States of the runs' generators, for each channel.
    states: [[Words; 4]; 2],
    drawn: [[Quad; 2]; PAIRS_PER_DRAW],
    next: usize,
}

impl NoiseBatch {
    /// Creates a batch without any run.
    pub(crate) fn new() -> Self {
        NoiseBatch { states: [[[1; LANES]; 4]; 2], drawn: [[Quad::default(); 2]; PAIRS_PER_DRAW], next: PAIRS_PER_DRAW }
    }

    /// Moves to the position of `noise` in its drawn numbers.
    pub(crate) fn follow(&mut self, noise: &Noise) {
        self.next = noise.next;
    }

    /// Takes over the noise of a run. Returns `false` if its position differs from that of the
    /// batch.
    pub(crate) fn take(&mut self, lane: usize, noise: &Noise) -> bool {
        if noise.next != self.next {
            return false;
        }
        for (states, generator) in self.states.iter_mut().zip(&noise.random) {
            states.iter_mut().zip(generator.0).for_each(|(words, word)| words[lane] = word);
        }
        for (drawn, pair) in self.drawn.iter_mut().zip(&noise.drawn).skip(self.next) {
            drawn.iter_mut().zip(pair).for_each(|(quad, number)| quad[lane] = *number);
        }
        true
    }

    /// Returns the noise to its run.
    pub(crate) fn give_back(&self, lane: usize, noise: &mut Noise) {
        noise.next = self.next;
        for (states, generator) in self.states.iter().zip(&mut noise.random) {
            *generator = Generator(states.map(|words| words[lane]));
        }
        for (drawn, pair) in self.drawn.iter().zip(&mut noise.drawn).skip(self.next) {
            *pair = drawn.map(|quad| quad[lane]);
        }
    }

    /// Returns the next number of each run, for voltage and current.
    #[inline(always)]
    pub(crate) fn pair(&mut self) -> &[Quad; 2] {
        if self.next >= PAIRS_PER_DRAW {
            self.draw();
        }
        let pair = &self.drawn[self.next % PAIRS_PER_DRAW];
        self.next += 1;
        pair
    }

    #[inline(never)]
    fn draw(&mut self) {
        run_widest(Draw(self));
        self.next = 0;
    }
}

/// Draws numbers in advance.
struct Draw<'a>(&'a mut NoiseBatch);

impl Kernel for Draw<'_> {
    type Output = ();

    #[inline(always)]
    fn with<F: Registers>(self, four: F) {
        let NoiseBatch { states, drawn, .. } = self.0;
        let layers = &*LAYER;
        let [v, i] = *states;
        let mut v = [four.words(v[0]), four.words(v[1]), four.words(v[2]), four.words(v[3])];
        let mut i = [four.words(i[0]), four.words(i[1]), four.words(i[2]), four.words(i[3])];
        for pair in drawn {
            *pair = [normal(four, &mut v, layers), normal(four, &mut i, layers)];
        }
        for n in 0..4 {
            (states[0][n], states[1][n]) = (four.array(v[n]), four.array(i[n]));
        }
    }
}

/// Returns the next normal number of each generator.
#[inline(always)]
fn normal<F: Registers>(four: F, states: &mut [F::Words; 4], layers: &[[f64; 2]; LAYERS]) -> Quad {
    let [s0, s1, s2, s3] = *states;
    let bits = four.wrapping_sum(four.rotated::<23, 41>(four.wrapping_sum(s0, s3)), s0);
    let (later2, later3) = (four.xor(s2, s0), four.xor(s3, s1));
    let last = four.xor(later2, four.left::<17>(s1));
    *states = [four.xor(s0, later3), four.xor(s1, later2), last, four.rotated::<45, 19>(later3)];

    let fraction = four.right::<12>(bits);
    let part = Wide::from_bits(four, four.xor(fraction, four.words([TWO_BITS; LANES]))) - Wide::splat(four, 3.0);
    let (mut edge, mut inner) = (Quad::default(), Quad::default());
    let words = four.array(bits);
    for lane in 0..LANES {
        [edge[lane], inner[lane]] = layers[(words[lane] & 0xff) as usize];
    }
    let drawn = part * edge.wide(four);
    if drawn.abs().is_below(inner.wide(four)) {
        return drawn.quad();
    }
    let [s0, s1, s2, s3] = *states;
    let mut later = [four.array(s0), four.array(s1), four.array(s2), four.array(s3)];
    let drawn = outer(drawn.quad(), inner, words, &mut later);
    *states = [four.words(later[0]), four.words(later[1]), four.words(later[2]), four.words(later[3])];
    drawn
}

/// Lets the library draw the numbers that are not in an inner layer.
#[cold]
#[inline(never)]
fn outer(mut drawn: Quad, inner: Quad, bits: Words, states: &mut [Words; 4]) -> Quad {
    for lane in 0..LANES {
        if drawn[lane].abs() < inner[lane] {
            continue;
        }
        let mut rest = Generator(states.map(|words| words[lane]));
        drawn[lane] = StandardNormal.sample(&mut Resumed { bits: Some(bits[lane]), rest: &mut rest });
        states.iter_mut().zip(rest.0).for_each(|(words, word)| words[lane] = word);
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A million numbers of each of eight streams, some of them from the tail.
    #[test]
    fn batched_noise_equals_that_of_each_run_alone() {
        let mut alone = [1, 2, 77, u64::MAX].map(Noise::new);
        let mut abreast = NoiseBatch::new();
        let mut beyond = 0;
        alone.iter().enumerate().for_each(|(lane, noise)| assert!(abreast.take(lane, noise)));
        for n in 0..1_000_000 {
            let [v, i] = *abreast.pair();
            for (lane, noise) in alone.iter_mut().enumerate() {
                let pair = noise.pair();
                assert!(pair == [v[lane], i[lane]], "{n} {lane}");
                beyond += usize::from(pair[0].abs() > 3.6542);
            }
        }
        assert!(beyond > 500, "{beyond} from the tail");
    }

    #[test]
    fn a_run_keeps_its_noise_across_batches() {
        let (mut alone, mut taken) = (Noise::new(3), Noise::new(3));
        let mut abreast = NoiseBatch::new();
        assert!(abreast.take(2, &taken));
        let go_on = |abreast: &mut NoiseBatch, alone: &mut Noise, pairs: usize| {
            for _ in 0..pairs {
                let [v, i] = *abreast.pair();
                assert_eq!([v[2], i[2]], alone.pair());
            }
        };
        go_on(&mut abreast, &mut alone, 100);
        abreast.give_back(2, &mut taken);
        (0..50).for_each(|_| assert_eq!(taken.pair(), alone.pair()));
        assert!(!abreast.take(2, &taken), "the batch is at another position");
        abreast.follow(&taken);
        assert!(abreast.take(2, &taken));
        go_on(&mut abreast, &mut alone, 100);
    }
}
