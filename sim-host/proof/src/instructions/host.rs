//! How good each generator is: the same source, run here. It gives the same bits as on the target, because nothing is fused.

use std::f64::consts::TAU;

use candidates::{Generator, Visitor};
use firmware::nco::tuning_word;

use report::spectrum::Spectrum;

/// Samples in a block, as on the target.
const SAMPLES: usize = 32;
/// Samples of a spectrum.
const RECORD: usize = 1 << 16;
/// The tone of the spectrum: 40.4 kHz and a bit, at 1 Msps.
const TONE: f64 = 0.040_412_345;
/// Where errors are looked for, cycles a sample.
const FREQUENCIES: [f64; 6] = [0.02, 0.028_3, 0.040_4, 0.060_7, 0.1, 0.25];
/// Blocks at each, from phases all over the turn.
const BLOCKS: u64 = 2048;
/// The golden ratio of 2^64: phases that are multiples of it lie evenly.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
/// Full scale of a 12-bit converter about its middle.
const HALF_RANGE: f64 = 2047.0;

/// How good a generator is, of a sine of amplitude one.
#[derive(Clone, Copy, Debug)]
pub struct Quality {
    /// The largest error of sine or cosine, over frequencies from 20 to 250 kHz at 1 Msps and all phases.
    pub largest_error: f64,
    /// The tone over the strongest other line, dB.
    pub sfdr_db: f64,
    /// The tone over all the rest, dB.
    pub sndr_db: f64,
    /// The same of 12-bit codes.
    pub sndr_12_bit_db: f64,
}

/// A generator, by what it says of itself.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Its name.
    pub name: &'static str,
    /// What it shares a curve with in the plot.
    pub family: &'static str,
    /// How it works.
    pub how: &'static str,
}

/// Every generator, and how good it is.
pub fn qualities() -> Vec<(Known, Quality)> {
    let mut measuring = Measuring(Vec::new());
    candidates::each(&mut measuring);
    measuring.0
}

struct Measuring(Vec<(Known, Quality)>);

impl Visitor for Measuring {
    fn visit<G: Generator>(&mut self) {
        let known = Known { name: G::NAME, family: G::FAMILY, how: G::HOW };
        self.0.push((known, quality::<G>()));
    }
}

fn quality<G: Generator>() -> Quality {
    let wave = sines::<G>();
    let spectrum = Spectrum::new(&wave, TONE);
    let codes: Vec<f64> = wave.iter().map(|x| (HALF_RANGE * x).round()).collect();
    Quality {
        largest_error: largest_error::<G>(),
        sfdr_db: spectrum.sfdr_db(),
        sndr_db: spectrum.sndr_db(),
        sndr_12_bit_db: Spectrum::new(&codes, TONE).sndr_db(),
    }
}

/// A long sine, made in blocks as the controller makes it.
fn sines<G: Generator>() -> Vec<f64> {
    let (word, mut phase) = (tuning_word(TONE), 0u64);
    let mut wave = Vec::with_capacity(RECORD);
    while wave.len() < RECORD {
        G::block(phase, word, SAMPLES, |pair| wave.push(pair.sin.into() / G::ONE));
        phase = phase.wrapping_add(word.wrapping_mul(SAMPLES as u64));
    }
    wave
}

fn largest_error<G: Generator>() -> f64 {
    let mut largest = 0.0f64;
    for word in FREQUENCIES.map(tuning_word) {
        for block in 0..BLOCKS {
            let mut phase = block.wrapping_mul(GOLDEN);
            G::block(phase, word, SAMPLES, |pair| {
                let (sin, cos) = (TAU * (phase as f64 / 2f64.powi(64))).sin_cos();
                let errors = [pair.sin.into() / G::ONE - sin, pair.cos.into() / G::ONE - cos];
                largest = errors.iter().fold(largest, |largest, error| largest.max(error.abs()));
                phase = phase.wrapping_add(word);
            });
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;

    static QUALITIES: LazyLock<Vec<(Known, Quality)>> = LazyLock::new(qualities);

    fn of(name: &str) -> Quality {
        QUALITIES.iter().find(|(known, _)| known.name == name).unwrap().1
    }

    /// What theory says of each: a step, its square over eight, half the square and a sixth of the cube of half a step.
    #[test]
    fn tables_err_as_they_must() {
        let step = |entries: f64| TAU / entries;
        for (name, expected) in [
            ("table 1024, nearest", step(1024.0)),
            ("table 1024, linear", step(1024.0).powi(2) / 8.0),
            ("256 pairs, first order", step(512.0).powi(2) / 2.0),
            ("1024 pairs, first order", step(2048.0).powi(2) / 2.0),
            ("256 pairs, second order", step(512.0).powi(3) / 6.0),
        ] {
            let found = of(name).largest_error;
            // Sine and cosine, rounded to f32, may err both ways: 1e-7 more, or less where the worst phase is not met.
            assert!((found - expected).abs() < 0.01 * expected + 1.5e-7, "{name}: {found} is not {expected}");
        }
    }

    #[test]
    fn other_crates_err_as_they_are_known_to() {
        for (name, from, to) in [("idsp cossin", 5e-6, 2e-5), ("micromath", 1e-3, 1.2e-3), ("libm", 5e-8, 1.2e-6)] {
            let found = of(name).largest_error;
            assert!((from..to).contains(&found), "{name}: {found}");
        }
    }

    /// Rounded to 12 bits, every generator but the coarse ones is as good as the exact sine: 74.0 dB.
    #[test]
    fn twelve_bits_hide_what_is_finer() {
        for (known, quality) in QUALITIES.iter() {
            let coarse = ["table 1024, nearest", "micromath"].contains(&known.name);
            assert_eq!(quality.sndr_12_bit_db < 73.5, coarse, "{known:?}: {quality:?}");
        }
    }
}
