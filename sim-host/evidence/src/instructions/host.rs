//! Quality of the controller's sine, from the same source on the host. It gives the same bits as on
//! the target, because no operations are fused.

use std::f64::consts::TAU;

use firmware::generate::nco::{Stretch, tuning_word};
use firmware::generate::shape::sine::{self, Steady};
use firmware::seam::phasor::Phasor;

use report::spectrum::Spectrum;

/// Number of samples in a block, as on the target.
const SAMPLES: usize = 32;
/// Number of samples of a spectrum.
const RECORD_SAMPLES: usize = 1 << 16;
/// Frequency of the spectrum's tone, cycles a sample: about 40.4 kHz at 1 Msps.
const TONE: f64 = 0.040_412_345;
/// Frequencies at which errors are measured, cycles a sample.
const FREQUENCIES: [f64; 6] = [0.02, 0.028_3, 0.040_4, 0.060_7, 0.1, 0.25];
/// Number of blocks at each frequency, with phases over the whole turn.
const BLOCKS: u64 = 2048;
/// Golden ratio times 2^64; its multiples are evenly distributed phases.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
/// Full scale of a 12-bit converter about its middle.
const HALF_RANGE_CODES: f64 = 2047.0;

/// A generator of the controller for a sine with its cosine.
#[derive(Clone, Copy, Debug)]
pub struct Generator {
    /// Name of the generator among the counts of the target.
    pub name: &'static str,
    /// Principle of the generator, in a few words.
    pub how: &'static str,
    /// Function that returns the sines and cosines of one block.
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

/// Quality of a generator, for a sine of amplitude one.
#[derive(Clone, Copy, Debug)]
pub struct Quality {
    /// Largest error of sine or cosine, over frequencies from 20 to 250 kHz at 1 Msps and all
    /// phases.
    pub largest_error: f64,
    /// Ratio of the tone to the strongest other line, dB.
    pub sfdr_db: f64,
    /// Ratio of the tone to the rest, dB.
    pub sndr_db: f64,
    /// Ratio of the tone to the rest with 12-bit codes, dB.
    pub sndr_12_bit_db: f64,
}

/// Computes the quality of a generator.
pub fn quality(generator: &Generator) -> Quality {
    let wave = sines(generator);
    let spectrum = Spectrum::new(&wave, TONE);
    let codes: Vec<f64> = wave.iter().map(|x| (HALF_RANGE_CODES * x).round()).collect();
    Quality {
        largest_error: largest_error(generator),
        sfdr_db: spectrum.sfdr_db(),
        sndr_db: spectrum.sndr_db(),
        sndr_12_bit_db: Spectrum::new(&codes, TONE).sndr_db(),
    }
}

/// Generates a long sine in blocks, as the controller does.
fn sines(generator: &Generator) -> Vec<f64> {
    let word = tuning_word(TONE);
    let block = |at: usize| (generator.block)(&Stretch { phase: word.wrapping_mul(at as u64), word, step: 0 });
    (0..RECORD_SAMPLES).step_by(SAMPLES).flat_map(block).map(|(sine, _)| f64::from(sine)).collect()
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

    /// The error of a rotation of second order is a sixth of the cube of half the distance between
    /// two entries, plus the rounding of f32. A swing adds the rounding of a block. Neither is
    /// visible in 12 bits, where the SNDR of the exact sine is 74.0 dB.
    #[test]
    fn the_sine_is_finer_than_the_converter() {
        let [rotation, swing] = GENERATORS.map(|generator| quality(&generator));
        let cubed = (TAU / 1024.0).powi(3) / 6.0;
        assert!((cubed..cubed + 1.5e-7).contains(&rotation.largest_error), "{rotation:?}");
        assert!(swing.largest_error < 2.44e-4 / 100.0, "{swing:?}");
        assert!(rotation.sndr_12_bit_db > 73.9 && swing.sndr_12_bit_db > 73.9, "{rotation:?} {swing:?}");
    }
}
