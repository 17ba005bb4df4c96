//! The noise of several runs, drawn side by side.
//!
//! A number of the ziggurat's inner layers, 98.8 % of all, is a product of its bits and a table's entry. The others are drawn by the library, from the
//! state of their run's generator: each run has the stream that it has alone, bit for bit.

use std::sync::LazyLock;

use rand_distr::{Distribution, StandardNormal};

use super::{DRAWN, Noise};
use crate::noise::generator::{Generator, Resumed, Scripted};
use crate::quad::{LANES, Quad, widest};

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
        let Abreast { states: [v, i], drawn, .. } = self;
        let layers = &*LAYER;
        widest(
            #[inline(always)]
            || {
                for pair in drawn {
                    *pair = [normal(v, layers), normal(i, layers)];
                }
            },
        );
        self.next = 0;
    }
}

/// The next normal number of each generator.
#[inline(always)]
fn normal(states: &mut [Words; 4], layers: &[[f64; 2]; LAYERS]) -> Quad {
    let mut bits = [0; LANES];
    let mut moved = *states;
    for lane in 0..LANES {
        let (word, state) = Generator::step(states.map(|words| words[lane]));
        bits[lane] = word;
        (0..4).for_each(|n| moved[n][lane] = state[n]);
    }
    *states = moved;
    let layer = bits.map(|bits| layers[(bits & 0xff) as usize]);
    let part = Quad(bits.map(|bits| f64::from_bits(bits >> 12 | TWO_BITS) - 3.0));
    let drawn = part * Quad(layer.map(|[edge, _]| edge));
    let inner = layer.map(|[_, next]| next);
    let beyond = drawn.0.iter().zip(inner).fold(false, |beyond, (x, next)| beyond | !(x.abs() < next));
    if beyond { outer(drawn, inner, bits, states) } else { drawn }
}

/// The same, where some are not of an inner layer: those are drawn by the library.
#[cold]
#[inline(never)]
fn outer(mut drawn: Quad, inner: [f64; LANES], bits: Words, states: &mut [Words; 4]) -> Quad {
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
