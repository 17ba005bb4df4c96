//! Tests of the guard as the controller calls it: sensors and limits it watches, the power it
//! computes, and the order of its faults.

use super::*;
use crate::board::parameters::tests::config;
use crate::seam::block::BeltSense;
use crate::seam::config::Restraint;
use crate::seam::phasor::Phasor;

const BLOCK_S: f32 = 32e-6;
/// 5.5 W: `Re(V I*) / 2`.
const SENSED: Sensed = Sensed { v: Phasor::new(3.0, 4.0), i: Phasor::new(2.0, 1.25) };
const RUNS: Driven = Driven { volts: Some(5.0), stage: Stage::Following, requested: true, full: true, asked: 3.0 };

fn guard(change: impl FnOnce(&mut Config)) -> Guard {
    let mut config = config();
    change(&mut config);
    Guard::build(&config, BLOCK_S).unwrap()
}

fn convert() -> Convert {
    Convert::build(&config().front_end).unwrap()
}

/// Returns a belt without an encoder.
fn no_belt() -> Belt {
    Belt::of(0.0, BLOCK_S)
}

/// Repeats a block, and returns the first fault with the number of blocks until it.
fn found(guard: &mut Guard, belt: &Belt, driven: &Driven, blocks: usize) -> Option<(usize, Fault)> {
    (1..=blocks).find_map(|n| Some((n, guard.watch(&convert(), &SenseBlock::default(), &SENSED, belt, driven)?)))
}

#[test]
fn each_mode_maps_to_a_stage() {
    let stages = [Mode::Idle, Mode::Fault, Mode::SelfTest, Mode::Scan, Mode::Calibrate, Mode::Clamped, Mode::Lock, Mode::Run]
        .map(Stage::from);
    use Stage::{Following, Measuring, Silent};
    assert_eq!(stages, [Silent, Silent, Measuring, Measuring, Measuring, Measuring, Following, Following]);
}

#[test]
fn any_limit_or_sensor_needs_the_watch() {
    let quiet = SenseBlock::default();
    assert!(!guard(|_| {}).watches(&quiet, &no_belt()));
    assert!(guard(|config| config.limits.power_w = Some(2.0)).watches(&quiet, &no_belt()));
    assert!(guard(|config| config.limits.on_time_s = Some(1.0)).watches(&quiet, &no_belt()));
    // A D-ring whose belt has no scale is refused.
    assert!(guard(|config| config.restraint = Some(Restraint::default())).watches(&quiet, &no_belt()));
    assert!(guard(|_| {}).watches(&quiet, &Belt::of(1e-5, BLOCK_S)));
    let mut warm = SenseBlock::default();
    warm.slow.temperature = Some(25.0);
    assert!(guard(|_| {}).watches(&warm, &no_belt()));
    let mut thermometer = guard(|config| config.thermometer.c0_per_k = 4e-3);
    assert!(!thermometer.watches(&quiet, &no_belt()));
    thermometer.update_temperature(&Thermometers { resonance_hz: 0.0, susceptance: 0.075 });
    assert!(thermometer.watches(&quiet, &no_belt()));
}

#[test]
fn a_d_ring_without_a_belt_scale_is_not_driven() {
    let mut guard = guard(|config| config.restraint = Some(Restraint::default()));
    assert_eq!(found(&mut guard, &no_belt(), &Driven { stage: Stage::Silent, ..RUNS }, 100), None);
    for stage in [Stage::Measuring, Stage::Following] {
        assert_eq!(found(&mut guard, &no_belt(), &Driven { stage, ..RUNS }, 1), Some((1, Fault::BeltScaleMissing)));
    }
}

#[test]
fn the_on_time_is_limited_on_a_board_without_an_encoder() {
    // 1 ms is 31 blocks of 32 us.
    let limited = || guard(|config| config.limits.on_time_s = Some(1e-3));
    let exceeded = Some((32, Fault::OnTimeExceeded));
    assert_eq!(found(&mut limited(), &no_belt(), &RUNS, 100), exceeded);
    // An edge counts as ON; a drive of 0 V and an idle controller do not.
    assert_eq!(found(&mut limited(), &no_belt(), &Driven { volts: None, ..RUNS }, 100), exceeded);
    assert_eq!(found(&mut limited(), &no_belt(), &Driven { stage: Stage::Measuring, ..RUNS }, 100), exceeded);
    assert_eq!(found(&mut limited(), &no_belt(), &Driven { volts: Some(0.0), ..RUNS }, 1000), None);
    assert_eq!(found(&mut limited(), &no_belt(), &Driven { stage: Stage::Silent, ..RUNS }, 1000), None);
    assert_eq!(found(&mut guard(|_| {}), &no_belt(), &RUNS, 1000), None);
}

#[test]
fn the_power_is_limited_on_a_board_without_an_encoder() {
    let after = |limit: f32, driven: &Driven| {
        let mut guard = guard(|config| config.limits.power_w = Some(limit));
        assert_eq!(found(&mut guard, &no_belt(), driven, 20_000), None);
        guard.derating()
    };
    // The test's power stays at 5.5 W: above a limit of 5 W the factor falls to 0.1, below 6 W it
    // stays 1.
    assert_eq!(after(5.0, &RUNS), 0.1);
    assert_eq!((after(6.0, &RUNS), after(5.0, &Driven { volts: Some(0.0), ..RUNS })), (1.0, 1.0));
}

#[test]
fn the_energy_limit_uses_the_electrical_power() {
    // The contact may take the energy of 5.5 W in 100.5 blocks.
    let mut guard = guard(|config| {
        config.front_end.metre_per_count = Some(1e-5);
        config.limits.energy_j_per_m = Some(5.5 * 100.5 * BLOCK_S / 0.01);
    });
    let mut belt = Belt::of(1e-5, BLOCK_S);
    belt.update(Some(BeltSense { counts: 0, broken: false }));
    assert_eq!(found(&mut guard, &belt, &RUNS, 200), Some((101, Fault::EnergyPerLength)));
    assert_eq!(found(&mut guard, &belt, &Driven { volts: Some(0.0), ..RUNS }, 50), None);
}

#[test]
fn belt_faults_precede_heat_precede_on_time() {
    let mut guard = guard(|config| {
        (config.limits.on_time_s, config.limits.temperature_c) = (Some(1e-3), 60.0);
        config.front_end.metre_per_count = Some(1e-5);
    });
    let mut hot = SenseBlock::default();
    let mut belt = Belt::of(1e-5, BLOCK_S);
    belt.update(Some(BeltSense { counts: 0, broken: false }));
    assert!((0..40).all(|_| guard.watch(&convert(), &hot, &SENSED, &belt, &RUNS) != Some(Fault::OverTemperature)));
    assert_eq!(guard.watch(&convert(), &hot, &SENSED, &belt, &RUNS), Some(Fault::OnTimeExceeded));
    hot.slow.temperature = Some(61.0);
    assert_eq!(guard.watch(&convert(), &hot, &SENSED, &belt, &RUNS), Some(Fault::OverTemperature));
    belt.update(None);
    assert_eq!(guard.watch(&convert(), &hot, &SENSED, &belt, &RUNS), Some(Fault::BeltSensorLost));
}

#[test]
fn a_belt_at_rest_mutes_and_a_new_attempt_waits() {
    let mut guard = guard(|config| config.front_end.metre_per_count = Some(1e-5));
    let mut belt = Belt::of(1e-5, BLOCK_S);
    let mut stands = |guard: &mut Guard, driven: &Driven, blocks: usize| {
        (1..=blocks).find_map(|n| {
            belt.update(Some(BeltSense { counts: 0, broken: false }));
            Some((n, guard.watch(&convert(), &SenseBlock::default(), &SENSED, &belt, driven)?))
        })
    };
    assert_eq!(stands(&mut guard, &RUNS, 75), None);
    assert!(!guard.is_muted() && !guard.mutes_request());
    assert_eq!(stands(&mut guard, &RUNS, 1), None);
    assert!(guard.is_muted() && guard.mutes_request());
    // Without a request the guard does not report a mute.
    let muted = Driven { volts: Some(0.0), ..RUNS };
    assert_eq!(stands(&mut guard, &Driven { requested: false, ..muted }, 1), None);
    assert!(guard.is_muted() && !guard.mutes_request());
    // After 100 ms of mute it is a fault; a new attempt waits without a fault.
    let (blocks, fault) = stands(&mut guard, &muted, 5000).unwrap();
    assert!(fault == Fault::BeltStopped && (3120..=3126).contains(&blocks), "{blocks}");
    guard.begin();
    assert_eq!(stands(&mut guard, &muted, 10_000), None);
}

#[test]
fn voltage_and_current_are_judged_above_a_minimum() {
    let (mut guard, convert) = (guard(|_| {}), convert());
    assert!(guard.is_judged(0.2) && !guard.is_judged(0.1) && !guard.is_implausible());
    let codes: crate::seam::block::Codes = (0..32).map(|n| 4096 + n % 2).collect();
    let sense = SenseBlock { v: codes.clone(), i: codes, ..SenseBlock::default() };
    let mut inspect = |sensed: &Sensed| guard.inspect(&convert, &sense, sensed, Some(5.0), Suspect::default());
    assert_eq!(inspect(&SENSED), None);
    assert!((0..7).all(|_| inspect(&Sensed::default()).is_none()));
    assert_eq!(inspect(&Sensed::default()), Some(Fault::SensorImplausible));
    assert!(guard.is_implausible());
}
