//! The sine and cosine of the drive by both generators of the controller, net of an empty loop.

use core::hint::black_box;

use firmware::generate::nco::{Stretch, tuning_word};
use firmware::generate::shape::sine::{self, Steady};
use firmware::seam::phasor::Phasor;
use qemu_m4::counter::Counter;

use crate::csv::line;
use crate::repeat::repeat;

/// Number of samples in a block, hidden from the compiler.
const SAMPLES: usize = 32;
const REPETITIONS: u32 = 600;

/// Counts the instructions of both generators.
pub fn count(counter: &Counter) {
    let empty = blocks(counter, nothing);
    let print = |name, ticks: i64| line("generator", name, SAMPLES, REPETITIONS, ticks - empty);
    print("rotation", blocks(counter, rotations));
    print("swing", blocks(counter, swings));
}

/// Returns the ticks of all blocks; the phase continues from block to block as in the controller.
#[inline(never)]
fn blocks(counter: &Counter, block: impl Fn(&Stretch, usize)) -> i64 {
    let word = tuning_word(40_400.0 / 1e6);
    let mut phase = 0;
    repeat(counter, REPETITIONS, || {
        let (samples, word) = (black_box(SAMPLES), black_box(word));
        block(&Stretch { phase, word, step: 0 }, samples);
        phase = phase.wrapping_add(word.wrapping_mul(samples as u64));
    })
}

fn sink(sine: f32, cosine: f32) {
    black_box(sine);
    black_box(cosine);
}

/// Rotates by the phase of each sample.
#[inline]
fn rotations(stretch: &Stretch, samples: usize) {
    let mut phase = stretch.phase;
    for _ in 0..samples {
        let turned = sine::rotation(phase);
        sink(turned.im, turned.re);
        phase = phase.wrapping_add(stretch.word);
    }
}

/// Runs two oscillators, set anew for each block, a quarter turn apart.
#[inline]
fn swings(stretch: &Stretch, samples: usize) {
    let steady = Steady::new(stretch);
    let (mut sine, mut cosine) = (steady.swing(Phasor::new(1.0, 0.0)), steady.swing(Phasor::new(0.0, 1.0)));
    (0..samples).for_each(|_| sink(sine.take(), cosine.take()));
}

/// Runs the loop and the sink alone, which are not part of a generator.
#[inline]
fn nothing(stretch: &Stretch, samples: usize) {
    let (sine, cosine) = (stretch.phase as u32 as f32, stretch.word as u32 as f32);
    (0..samples).for_each(|_| sink(sine, cosine));
}
