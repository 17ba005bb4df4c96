//! How good the controller's sine is: the same source, run here. It gives the same bits as on the target, because nothing is fused.

use std::f64::consts::TAU;

use firmware::generate::nco::{Stretch, tuning_word};
use firmware::generate::shape::sine::{self, Steady};
use firmware::seam::phasor::Phasor;

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

/// A way in which the controller makes a sine with its cosine.
#[derive(Clone, Copy, Debug)]
pub struct Generator {
    /// Name of the generator among the counts of the target.
    pub name: &'static str,
    /// Principle of the generator, in a few words.
    pub how: &'static str,
    /// Sines and cosines of one block.
    block: fn(&Stretch) -> [(f32, f32); SAMPLES],
}

/// Both generators that the controller uses.
pub const GENERATORS: [Generator; 2] = [
    Generator { name: "rotation", how: "512 pairs, second order", block: rotations },
    Generator { name: "swing", how: "y + d, d - c y, restarted each block", block: swings },
];

fn rotations(stretch: &Stretch) -> [(f32, f32); SAMPLES] {
    std::array::from_fn(|at| {
        let turned = sine::rotation(stretch.phase_at(at));
        (turned.im, turned.re)
    })
}

fn swings(stretch: &Stretch) -> [(f32, f32); SAMPLES] {
    let steady = Steady::new(stretch);
    let (mut sine, mut cosine) = (steady.swing(Phasor::new(1.0, 0.0)), steady.swing(Phasor::new(0.0, 1.0)));
    std::array::from_fn(|_| (sine.take(), cosine.take()))
}

/// How good a generator is, of a sine of amplitude one.
#[derive(Clone, Copy, Debug)]
pub struct Quality {
    /// The largest error of sine or cosine, over frequencies from 20 to 250 kHz at 1 Msps and all phases.
    pub largest_error: f64,
    /// The tone over the strongest other line, dB.
    pub sfdr_db: f64,
    /// The tone over all the rest, dB.
    pub sndr_db: f64,
    /// The tone over all the rest with 12-bit codes, dB.
    pub sndr_12_bit_db: f64,
}

/// Computes how good a generator is.
pub fn quality(generator: &Generator) -> Quality {
    let wave = sines(generator);
    let spectrum = Spectrum::new(&wave, TONE);
    let codes: Vec<f64> = wave.iter().map(|x| (HALF_RANGE * x).round()).collect();
    Quality {
        largest_error: largest_error(generator),
        sfdr_db: spectrum.sfdr_db(),
        sndr_db: spectrum.sndr_db(),
        sndr_12_bit_db: Spectrum::new(&codes, TONE).sndr_db(),
    }
}

/// A long sine, made in blocks as the controller makes it.
fn sines(generator: &Generator) -> Vec<f64> {
    let word = tuning_word(TONE);
    let block = |at: usize| (generator.block)(&Stretch { phase: word.wrapping_mul(at as u64), word, step: 0 });
    (0..RECORD).step_by(SAMPLES).flat_map(block).map(|(sine, _)| f64::from(sine)).collect()
}

fn largest_error(generator: &Generator) -> f64 {
    let mut largest = 0.0f64;
    for word in FREQUENCIES.map(tuning_word) {
        for block in 0..BLOCKS {
            let stretch = Stretch { phase: block.wrapping_mul(GOLDEN), word, step: 0 };
            for (at, (sine, cosine)) in (generator.block)(&stretch).into_iter().enumerate() {
                let (exact_sine, exact_cosine) = (TAU * (stretch.phase_at(at) as f64 / 2f64.powi(64))).sin_cos();
                largest = largest.max((f64::from(sine) - exact_sine).abs()).max((f64::from(cosine) - exact_cosine).abs());
            }
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rotation of second order errs by a sixth of the cube of half the distance between two entries, and by what f32 rounds; a swing adds
    /// the rounding of a block. Neither shows in 12 bits: the SNDR of the exact sine is 74.0 dB there.
    #[test]
    fn the_sine_is_finer_than_the_converter() {
        let [rotation, swing] = GENERATORS.map(|generator| quality(&generator));
        let cubed = (TAU / 1024.0).powi(3) / 6.0;
        assert!((cubed..cubed + 1.5e-7).contains(&rotation.largest_error), "{rotation:?}");
        assert!(swing.largest_error < 2.44e-4 / 100.0, "{swing:?}");
        assert!(rotation.sndr_12_bit_db > 73.9 && swing.sndr_12_bit_db > 73.9, "{rotation:?} {swing:?}");
    }
}
