//! One period in 1024 entries, read at two places.
//!
//! Error of the nearest entry to the left: up to one step, `2 pi / 1024 = 6.1e-3`. Of a straight line between two: `(2 pi / 1024)^2 / 8 = 4.7e-6`.

use crate::generator::{Generator, Pair};
use crate::sines::sine_and_cosine;

const INDEX_BITS: u32 = 10;
const LENGTH: usize = 1 << INDEX_BITS;
const FRACTION_BITS: u32 = 32 - INDEX_BITS;
const QUARTER: u32 = 1 << 30;

/// One period; the first entry stands again at the end.
static SINE: [f32; LENGTH + 1] = {
    let mut entries = [0.0; LENGTH + 1];
    let mut n = 0;
    while n <= LENGTH {
        entries[n] = sine_and_cosine(n as f64 / LENGTH as f64).0 as f32;
        n += 1;
    }
    entries
};

/// The table's entry below the phase.
pub struct Nearest;

impl Generator for Nearest {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "table 1024, nearest";
    const FAMILY: &'static str = "table 1024, nearest";
    const HOW: &'static str = "entry below the phase";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        let phase = (phase >> 32) as u32;
        let at = |phase: u32| SINE[(phase >> FRACTION_BITS) as usize];
        Pair { sin: at(phase), cos: at(phase.wrapping_add(QUARTER)) }
    }
}

/// A straight line between two entries.
pub struct Interpolated;

impl Generator for Interpolated {
    type Number = f32;
    const ONE: f64 = 1.0;
    const NAME: &'static str = "table 1024, linear";
    const FAMILY: &'static str = "table 1024, linear";
    const HOW: &'static str = "straight line between two entries";

    #[inline]
    fn pair(phase: u64) -> Pair<f32> {
        let phase = (phase >> 32) as u32;
        // The same for both, because a quarter turn is a whole number of entries.
        let fraction = (phase & ((1 << FRACTION_BITS) - 1)) as f32 * (1.0 / (1u32 << FRACTION_BITS) as f32);
        let at = |phase: u32| {
            let index = (phase >> FRACTION_BITS) as usize;
            SINE[index] + (SINE[index + 1] - SINE[index]) * fraction
        };
        Pair { sin: at(phase), cos: at(phase.wrapping_add(QUARTER)) }
    }
}
