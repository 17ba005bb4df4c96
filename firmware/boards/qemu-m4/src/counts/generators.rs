//! The generators of the drive, each in blocks, net of a loop that does nothing but hand out numbers.

use core::hint::black_box;

use candidates::{Generator, Pair, Visitor};
use firmware::nco::tuning_word;
use qemu_m4::counter::Counter;

use crate::csv::line;
use crate::repeat::repeat;

/// Samples in a block; the generators do not know.
const SAMPLES: usize = 32;
const REPETITIONS: u32 = 600;

/// Counts every candidate.
pub fn count(counter: &Counter) {
    let empty = blocks::<Empty>(counter);
    candidates::each(&mut Counting { counter, empty });
}

struct Counting<'a> {
    counter: &'a Counter,
    /// Ticks of the empty loop.
    empty: i64,
}

impl Visitor for Counting<'_> {
    fn visit<G: Generator>(&mut self) {
        line("generator", G::NAME, SAMPLES, REPETITIONS, blocks::<G>(self.counter) - self.empty);
    }
}

/// Ticks of blocks, with the phase going on from block to block as in the controller.
#[inline(never)]
fn blocks<G: Generator>(counter: &Counter) -> i64 {
    let word = tuning_word(40_400.0 / 1e6);
    let mut phase = 0;
    repeat(counter, REPETITIONS, || {
        let (samples, word) = (black_box(SAMPLES), black_box(word));
        G::block(phase, word, samples, |pair| {
            black_box(pair.sin);
            black_box(pair.cos);
        });
        phase = phase.wrapping_add(word.wrapping_mul(samples as u64));
    })
}

/// Nothing: the loop and the sink, which are no part of a generator.
struct Empty;

impl Generator for Empty {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "";
    const FAMILY: &'static str = "";
    const HOW: &'static str = "";

    fn pair(_: u64) -> Pair<f32> {
        Pair::default()
    }

    #[inline]
    fn block(phase: u64, word: u64, samples: usize, mut sink: impl FnMut(Pair<f32>)) {
        let pair = Pair { sin: phase as u32 as f32, cos: word as u32 as f32 };
        (0..samples).for_each(|_| sink(pair));
    }
}
