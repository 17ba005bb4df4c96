//! Several lanes: their phase and amplitude, measured from the codes.

use firmware::seam::config::{Config, Direction};
use hal_mock::bench::{Queues, Setup};

use super::*;

/// Returns the amplitude in codes, and the phase in turns relative to lane 0, of each lane of a
/// run.
fn lanes_of(setup: &Setup) -> Vec<(f64, f64)> {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, setup);
    let from = bench.played() as usize * BLOCK;
    bench.blocks(1000);
    let lanes: Vec<(f64, f64)> =
        (0..usize::from(setup.config.lanes)).map(|lane| tone(&played(&mut bench, lane)[from..], from, 40_400.0)).collect();
    lanes.iter().map(|&(amplitude, phase)| (amplitude, (phase - lanes[0].1 + 2.0).fract())).collect()
}

fn expect(change: impl FnOnce(&mut Config), expected: &[(f64, f64)]) {
    let got = lanes_of(&setup(change));
    let near = |a: f64, b: f64, bound: f64| (a - b).abs() < bound;
    let fits = |((amplitude, phase), &(volts, turns)): (&(f64, f64), &(f64, f64))| {
        let off = (phase - turns + 1.5).fract() - 0.5;
        near(*amplitude, volts * CODES_PER_VOLT, 0.1) && near(off, 0.0, 1e-4)
    };
    assert!(got.len() == expected.len() && got.iter().zip(expected).all(fits), "{got:?}");
}

#[test]
fn four_lanes_lead_one_another_by_a_quarter_turn() {
    expect(|config| config.lanes = 4, &[(3.0, 0.0), (3.0, 0.25), (3.0, 0.5), (3.0, 0.75)]);
}

#[test]
fn reverse_turns_the_other_way() {
    let reverse = |config: &mut Config| {
        config.lanes = 4;
        config.phasing.direction = Direction::Reverse;
    };
    expect(reverse, &[(3.0, 0.0), (3.0, 0.75), (3.0, 0.5), (3.0, 0.25)]);
}

#[test]
fn trims_move_and_scale_their_lane_alone() {
    let trimmed = |config: &mut Config| {
        config.lanes = 3;
        config.phasing.phase_trim_turns = [0.0, -0.01, 0.02].into_iter().collect();
        config.phasing.gain_trim = [1.0, 0.9, 1.1].into_iter().collect();
    };
    expect(trimmed, &[(3.0, 0.0), (2.7, 0.24), (3.3, 0.52)]);
}

#[test]
fn all_lanes_fall_silent_together() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &setup(|config| config.lanes = 4));
    bench.analog().inner.strike(FaultKind::LateBlock);
    bench.blocks(20);
    let silent: Vec<usize> =
        (0..4).map(|lane| played(&mut bench, lane).iter().rposition(|&code| code != MID_CODE).unwrap() / BLOCK).collect();
    assert!(silent.iter().all(|block| block == &silent[0]), "{silent:?}");
}
