//! Tests of a stack, driven open loop through its converters, against formulas and other runs.

mod abreast;
mod delay;
mod faults;
mod further;
mod power;
mod rest;
mod shift;

use std::f64::consts::TAU;

use firmware::seam::block::{DriveBlock, SenseBlock};
use hal_mock::analog::Analog;
use realfft::num_complex::Complex64;

use crate::Plant;
use crate::truth::Sample;
use scene::load::{Loaded, load};

/// Loads the scene `lock` with changes, and a DAC of 16 bits, so that rounding hides nothing.
fn scene(sets: &[&str]) -> Loaded {
    let sets: Vec<String> = ["sensors.dac_bits=16"].iter().chain(sets).map(|set| (*set).to_owned()).collect();
    load("lock", &sets).unwrap_or_else(|error| panic!("{error}"))
}

/// A plant driven by a sine.
struct Bench {
    plant: Plant,
    turns: f64,
    /// Volts of one code.
    volt: f64,
}

impl Bench {
    fn new(loaded: &Loaded) -> Self {
        let driven = loaded.scene.driven().unwrap();
        let volt = driven.amplifier.full_scale_v / 32768.0;
        Bench { plant: Plant::new(&driven), turns: 0.0, volt }
    }

    /// Plays codes, block by block.
    fn play(&mut self, codes: &[u16]) {
        let mut sense = SenseBlock::default();
        for block in codes.chunks(32) {
            let drive =
                DriveBlock { lanes: [block.iter().copied().collect()].into_iter().collect(), listen: 0, drops_queue: false };
            self.plant.exchange(&drive, &mut sense);
        }
    }

    /// Plays a sine for `samples` samples, in phase with the previous one, and passes each block to
    /// `each`.
    fn sine(&mut self, hz: f64, volts: f64, samples: usize, mut each: impl FnMut(&[Sample])) {
        self.plant.keep_samples(true);
        let step = hz * self.plant.sample_s();
        let mut left = samples;
        while left > 0 {
            let block = left.min(32);
            let codes: Vec<u16> = (0..block)
                .map(|n| (32768.0 + volts / self.volt * (TAU * (self.turns + step * n as f64)).sin()).round() as u16)
                .collect();
            self.turns = (self.turns + step * block as f64).fract();
            self.play(&codes);
            each(self.plant.samples());
            left -= block;
        }
    }

    /// Returns the peak phasors of voltage and motional current over `samples` samples, which must
    /// be whole periods.
    fn phasors(&mut self, hz: f64, volts: f64, samples: usize) -> (Complex64, Complex64) {
        let (mut voltage, mut current, mut n) = (Complex64::ZERO, Complex64::ZERO, 0);
        let step = hz * self.plant.sample_s();
        self.sine(hz, volts, samples, |block| {
            for sample in block {
                let turn = Complex64::cis(-TAU * (step * f64::from(n)).fract());
                voltage += turn * sample.voltage_v;
                current += turn * sample.motional_current_a;
                n += 1;
            }
        });
        let scale = 2.0 / samples as f64;
        (voltage * scale, current * scale)
    }
}
