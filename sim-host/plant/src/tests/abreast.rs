//! Tests that batched stacks equal the same stacks alone, bit for bit.

use firmware::seam::block::{DriveBlock, SenseBlock};
use hal_mock::analog::Analog;
use scene::load::load;

use crate::Plant;
use crate::driven_stack::DrivenStack;
use crate::driven_stack::abreast::{Abreast, Voice};
use crate::quad::LANES;

fn stack(name: &str, sets: &[&str]) -> DrivenStack {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = load(name, &sets).unwrap_or_else(|error| panic!("{error}"));
    match Plant::new(&loaded.scene.driven().unwrap()) {
        Plant::Stack(stack) => *stack,
        _ => panic!("{name} is not a stack"),
    }
}

fn block(codes: impl IntoIterator<Item = u16>) -> DriveBlock {
    DriveBlock { lanes: [codes.into_iter().collect()].into_iter().collect(), listen: 0, drops_queue: false }
}

/// Returns block `number` of lane `lane`: tones of different lengths with silence between, square
/// waves that hold a code, and a burst that ends within a block.
fn drive(lane: u64, number: u64) -> DriveBlock {
    let silent = (number / (700 + 100 * lane)) % 3 == 2;
    block((0..32).map(|n| {
        let sample = 32 * number + n;
        let late = number % 900 == 899 && n > 10 + lane;
        match sample % (25 + lane) {
            _ if silent || late => 2048,
            phase if lane == 2 => {
                if phase < 13 {
                    2348
                } else {
                    1748
                }
            }
            phase => 2048 + (37 * phase * phase % 1000) as u16 - 300,
        }
    }))
}

/// Plays `blocks` blocks of these plants batched and alone. Returns the number of blocks, over all
/// plants, that ended at rest.
fn compare(plants: [Option<DrivenStack>; LANES], blocks: u64, drive: impl Fn(u64, u64) -> DriveBlock) -> usize {
    let (mut alone, mut together) = (plants.clone(), plants);
    let mut abreast = Abreast::default();
    let mut senses: [SenseBlock; LANES] = Default::default();
    let mut rested = 0;
    for number in 0..blocks {
        let drives: [DriveBlock; LANES] = std::array::from_fn(|lane| drive(lane as u64, number));
        let mut voices: [Option<Voice>; LANES] = [const { None }; LANES];
        for (((voice, plant), drive), sense) in voices.iter_mut().zip(&mut together).zip(&drives).zip(&mut senses) {
            *voice = plant.as_mut().map(|plant| Voice { plant, drive, sense });
        }
        abreast.exchange(&mut voices);
        let mut sense = SenseBlock::default();
        for (lane, plant) in alone.iter_mut().enumerate() {
            let Some(plant) = plant else { continue };
            plant.exchange(&drives[lane], &mut sense);
            assert!(sense == senses[lane], "block {number}, lane {lane}");
            let twin = together[lane].as_ref().unwrap();
            assert!(plant.truth() == twin.truth() && plant.energy() == twin.energy(), "block {number}, lane {lane}");
            rested += usize::from(plant.rests());
        }
    }
    rested
}

#[test]
fn batched_stacks_equal_each_one_alone() {
    let plants = [
        stack("lock", &["seed=1"]),
        stack("lock-drift", &["seed=2"]),
        stack("lock", &["seed=3", "stack.bvd.q=150", "sensors.adc_bits=14", "sensors.noise_lsb=3"]),
        stack("lock-step", &["seed=4", "stack.bvd.series_resonance_hz=39e3", "sensors.v_full_scale_v=20"]),
    ];
    let rested = compare(plants.map(Some), 6000, drive);
    assert!(rested > 1000, "{rested} blocks at rest");
}

#[test]
fn an_unsuitable_stack_runs_alone() {
    let mode = ["stack.mode.0.series_resonance_hz=43e3", "stack.mode.0.q=100", "stack.mode.0.lm_h=4e-3"];
    let plants = [
        Some(stack("lock", &mode)),
        Some(stack("lock", &["sensors.oversample=3"])),
        None,
        Some(stack("lock", &["sensors.oversample=3", "sensors.noise_lsb=0"])),
    ];
    compare(plants.clone(), 2000, drive);
    let [_, one, ..] = plants;
    compare([one.clone(), Some(stack("experiment-1", &[])), one, None], 2000, drive);
    let lock = Some(stack("lock", &[]));
    compare([lock.clone(), Some(stack("self-heating", &[])), lock, Some(stack("derating", &["seed=2"]))], 2000, drive);
}
