//! The noise of several runs, drawn side by side.
//!
//! A number of the ziggurat's inner layers, 98.8 % of all, is a product of its bits and a table's entry. The others are drawn by the library, from the
//! state of their run's generator: each run has the stream that it has alone, bit for bit.

use std::sync::LazyLock;

use rand_distr::{Distribution, StandardNormal};

use super::{DRAWN, Noise};
use crate::noise::generator::{Generator, Resumed, Scripted};
use crate::quad::{Four, LANES, Quad, Wide, Work, widest};

/// Layers of the ziggurat.
const LAYERS: usize = 256;
/// Two to four less three is minus one to one.
const TWO_BITS: u64 = 0x4000_0000_0000_0000;

/// Of each layer its edge and that of the next, as the library has them.
static LAYER: LazyLock<[[f64; 2]; LAYERS]> = LazyLock::new(|| {
    let edge = |layer: usize| if layer < LAYERS { edge(layer) } else { 0.0 };
    std::array::from_fn(|layer| [edge(layer), edge(layer + 1)])
});

/// The edge of a layer: the number that half of it makes, doubled. Where half is beyond the next layer, the library asks once more, and is told to
/// take it.
fn edge(layer: usize) -> f64 {
    // The library puts the upper 52 bits behind 2.0 and subtracts three.
    let half = 3.5f64.to_bits() << 12;
    let drawn: f64 = StandardNormal.sample(&mut Scripted(Some(half | layer as u64)));
    2.0 * drawn
}

/// The same word of several generators.
type Words = [u64; LANES];

/// The noise of several runs side by side.
#[derive(Clone, Debug)]
pub(crate) struct Abreast {
    /// For each channel the states of the runs' generators.
    states: [[Words; 4]; 2],
    drawn: [[Quad; 2]; DRAWN],
    next: usize,
}

impl Abreast {
    /// No run's noise.
    pub(crate) fn new() -> Self {
        Abreast { states: [[[1; LANES]; 4]; 2], drawn: [[Quad::default(); 2]; DRAWN], next: DRAWN }
    }

    /// How far it is in what was drawn ahead.
    pub(crate) fn follow(&mut self, noise: &Noise) {
        self.next = noise.next;
    }

    /// Takes the noise of a run, if that is as far as the others'.
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

    /// Gives a run its noise back.
    pub(crate) fn give_back(&self, lane: usize, noise: &mut Noise) {
        noise.next = self.next;
        for (states, generator) in self.states.iter().zip(&mut noise.random) {
            *generator = Generator(states.map(|words| words[lane]));
        }
        for (drawn, pair) in self.drawn.iter().zip(&mut noise.drawn).skip(self.next) {
            *pair = drawn.map(|quad| quad[lane]);
        }
    }

    /// The next number of each run, for voltage and current.
    #[inline(always)]
    pub(crate) fn pair(&mut self) -> &[Quad; 2] {
        if self.next >= DRAWN {
            self.draw();
        }
        let pair = &self.drawn[self.next % DRAWN];
        self.next += 1;
        pair
    }

    #[inline(never)]
    fn draw(&mut self) {
        widest(Draw(self));
        self.next = 0;
    }
}

/// Draws ahead.
struct Draw<'a>(&'a mut Abreast);

impl Work for Draw<'_> {
    type Output = ();

    #[inline(always)]
    fn with<F: Four>(self, four: F) {
        let Abreast { states, drawn, .. } = self.0;
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

/// The next normal number of each generator.
#[inline(always)]
fn normal<F: Four>(four: F, states: &mut [F::Words; 4], layers: &[[f64; 2]; LAYERS]) -> Quad {
    let [s0, s1, s2, s3] = *states;
    let bits = four.wrapping_sum(four.rotated::<23, 41>(four.wrapping_sum(s0, s3)), s0);
    let (later2, later3) = (four.xor(s2, s0), four.xor(s3, s1));
    let last = four.xor(later2, four.left::<17>(s1));
    *states = [four.xor(s0, later3), four.xor(s1, later2), last, four.rotated::<45, 19>(later3)];

    let fraction = four.right::<12>(bits);
    let part = Wide::of_bits(four, four.xor(fraction, four.words([TWO_BITS; LANES]))) - Wide::splat(four, 3.0);
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

/// The same, where some are not of an inner layer: those are drawn by the library.
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

    /// A million numbers of each of eight streams: some of the tail among them.
    #[test]
    fn each_run_has_the_noise_that_it_has_alone() {
        let mut alone = [1, 2, 77, u64::MAX].map(Noise::new);
        let mut abreast = Abreast::new();
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
        assert!(beyond > 500, "{beyond} of the tail");
    }

    #[test]
    fn a_run_takes_its_noise_along() {
        let (mut alone, mut taken) = (Noise::new(3), Noise::new(3));
        let mut abreast = Abreast::new();
        assert!(abreast.take(2, &taken));
        let go_on = |abreast: &mut Abreast, alone: &mut Noise, pairs: usize| {
            for _ in 0..pairs {
                let [v, i] = *abreast.pair();
                assert_eq!([v[2], i[2]], alone.pair());
            }
        };
        go_on(&mut abreast, &mut alone, 100);
        abreast.give_back(2, &mut taken);
        (0..50).for_each(|_| assert_eq!(taken.pair(), alone.pair()));
        assert!(!abreast.take(2, &taken), "the others are elsewhere");
        abreast.follow(&taken);
        assert!(abreast.take(2, &taken));
        go_on(&mut abreast, &mut alone, 100);
    }
}
