//! Tests of the whole motor: waves, speeds, directions, energy. The drive is sines as codes,
//! without firmware.

mod assumed;
mod energy;
mod speed;
mod waves;

use super::*;
use crate::truth::MotorTruth;
use scene::Scene;
use scene::load::load_text;

/// Returns a stator whose wave fits the thesis's electrodes.
pub(crate) fn stator() -> Stator {
    usm(&[]).stator.unwrap()
}

/// Returns the rotor on this stator.
pub(crate) fn rotor() -> scene::Rotor {
    usm(&[]).driven().unwrap().rotor().unwrap().clone()
}

/// Loads the built-in scene with changes.
fn usm(sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    load_text("usm", include_str!("../../../scene/scenes/usm.toml"), &sets).unwrap_or_else(|error| panic!("{error}")).scene
}

/// A motor and a generator of four sines with 16 bits.
struct Bench {
    motor: Motor,
    hz: f64,
    volts: f64,
    /// Phase of each lane, turns.
    turns: [f64; 4],
    block: u64,
    sense: SenseBlock,
}

const BLOCK: usize = 32;

/// The truth about a block, with the part that only a motor has.
struct BlockTruth {
    all: Truth,
    motor: MotorTruth,
}

impl Bench {
    fn new(sets: &[&str]) -> Self {
        let fine = [&["sensors.dac_bits=16"], sets].concat();
        let scene = usm(&fine);
        let scene = scene.driven().unwrap();
        let motor = Motor::new(&scene, scene.stator().unwrap(), scene.rotor());
        let hz = scene.stator().unwrap().series_resonance_hz;
        Bench { motor, hz, volts: 10.0, turns: [0.0, 0.25, 0.5, 0.75], block: 0, sense: SenseBlock::default() }
    }

    /// Plays for `seconds` seconds. Returns the truth of every block.
    fn play(&mut self, seconds: f64) -> Vec<BlockTruth> {
        let blocks = (seconds / (BLOCK as f64 * self.motor.sample_s())).round() as u64;
        (0..blocks).map(|_| self.play_block()).collect()
    }

    fn play_block(&mut self) -> BlockTruth {
        let mut drive = DriveBlock::silent(4, BLOCK, self.motor.dac.mid_code());
        let first = self.block * BLOCK as u64;
        for (lane, codes) in drive.lanes.iter_mut().enumerate() {
            for (n, code) in codes.iter_mut().enumerate() {
                let turns = (first + n as u64) as f64 * self.motor.sample_s() * self.hz + self.turns[lane];
                let volts = self.volts * (std::f64::consts::TAU * turns.fract()).sin();
                *code = (f64::from(*code) + volts / self.motor.dac.volt_per_lsb()).round() as u16;
            }
        }
        self.block += 1;
        self.motor.exchange(&drive, &mut self.sense);
        BlockTruth { all: *self.motor.truth(), motor: *self.motor.motor_truth() }
    }
}

/// Returns the mean of a value over the last `last` blocks.
fn mean(truths: &[BlockTruth], last: usize, value: impl Fn(&MotorTruth) -> f64) -> f64 {
    truths[truths.len() - last..].iter().map(|truth| value(&truth.motor)).sum::<f64>() / last as f64
}
