//! Tests that a stack at rest, whose samples are not computed again, gives unchanged results.

use firmware::seam::block::{DriveBlock, SenseBlock};
use hal_mock::analog::Analog;

use crate::Plant;
use scene::load::load;

/// Plays codes in blocks of `block` codes. Returns the codes of the sensors.
fn played(plant: &mut Plant, codes: &[u16], block: usize) -> Vec<(u16, u16)> {
    let mut sense = SenseBlock::default();
    let mut seen = Vec::new();
    for codes in codes.chunks(block) {
        let drive = DriveBlock { lanes: [codes.iter().copied().collect()].into_iter().collect(), listen: 0, drops_queue: false };
        plant.exchange(&drive, &mut sense);
        seen.extend(sense.v.iter().copied().zip(sense.i.iter().copied()));
    }
    seen
}

/// A plant that plays blocks of one sample never rests, as an element may change between any two
/// blocks. Both plants sample the same codes, bit for bit: in silence, at a held voltage and when
/// the drive starts again; with a contact, and with a late drive and a further mode.
#[test]
fn rest_does_not_change_the_samples() {
    let late =
        ["amplifier.delay_s=1.3e-6", "stack.mode.0.series_resonance_hz=43e3", "stack.mode.0.q=100", "stack.mode.0.lm_h=4e-3"];
    let late = late.map(String::from);
    for (name, sets) in [("experiment-1", &[][..]), ("lock", &late)] {
        let loaded = load(name, sets).unwrap_or_else(|error| panic!("{error}"));
        let driven = loaded.scene.driven().unwrap();
        let (mut rests, mut moves) = (Plant::new(&driven), Plant::new(&driven));
        let burst = (0..1290).map(|n| 2048 + if n % 25 < 12 { 300 } else { 0 });
        let codes: Vec<u16> = burst.clone().chain([2048; 64_010]).chain([2300; 64_010]).chain(burst).collect();
        let seen = [played(&mut rests, &codes, 32), played(&mut moves, &codes, 1)];
        assert!(seen[0] == seen[1], "{name}");
        let [rested, moved] = [&rests, &moves].map(Plant::truth);
        let off = rested.tip_velocity_m_per_s - moved.tip_velocity_m_per_s;
        assert!(moved.tip_velocity_m_per_s > 1e-3 && off.abs() < 1e-13, "{name}: {off:e}");
    }
}

#[test]
fn a_stack_comes_to_rest() {
    for name in ["experiment-1", "lock"] {
        let loaded = load(name, &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut plant = Plant::new(&loaded.scene.driven().unwrap());
        played(&mut plant, &[2300; 640], 32);
        let Plant::Stack(stack) = &plant else { panic!("{name}") };
        assert!(!stack.rests(), "{name} moves");
        played(&mut plant, &[2048; 64_000], 32);
        let Plant::Stack(stack) = &plant else { panic!("{name}") };
        assert!(stack.rests(), "{name}");
    }
}
