//! What a generator is: a sine and a cosine at a phase, or a block of them.

/// A sine and its cosine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pair<N> {
    /// The sine.
    pub sin: N,
    /// The cosine.
    pub cos: N,
}

/// A generator of sine and cosine.
pub trait Generator {
    /// What it makes: `f32`, or integers.
    type Number: Copy + Into<f64>;
    /// The number that means one.
    const ONE: f64;
    /// Its name in tables and plots.
    const NAME: &'static str;
    /// What it shares a curve with in the plot.
    const FAMILY: &'static str;
    /// How it works, in a few words.
    const HOW: &'static str;

    /// The pair at a phase of `phase / 2^64` turns.
    fn pair(phase: u64) -> Pair<Self::Number>;

    /// The pairs at `phase`, `phase + word`, `phase + 2 word` and so on, one block of them.
    #[inline]
    fn block(phase: u64, word: u64, samples: usize, mut sink: impl FnMut(Pair<Self::Number>)) {
        let mut phase = phase;
        for _ in 0..samples {
            sink(Self::pair(phase));
            phase = phase.wrapping_add(word);
        }
    }
}
