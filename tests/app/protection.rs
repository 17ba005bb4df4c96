//! Protection during a run: the fault, and the number of blocks until the drive is silent.

use firmware::board::command::Command;
use firmware::controller::Controller;
use firmware::seam::block::{Gate, LATENCY_BLOCKS};
use firmware::seam::config::Restraint;
use firmware::seam::error::Error;
use firmware::seam::fault::{Fault, Limit};
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Bench, Queues, Setup};

use super::*;

/// Number of implausible blocks after which a sensor causes a fault.
const IMPLAUSIBLE_BLOCKS: u64 = 8;

/// Injects `kind` into a healthy run. Returns the fault, and the numbers of blocks from its start
/// to the report and to silence.
fn response_to(kind: FaultKind) -> (Option<Fault>, u64, u64) {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.blocks(100);
    let at = bench.played();
    bench.analog().inner.strike(kind);
    bench.run_until(|report| report.mode == Mode::Fault, 1000);
    let reported = u64::from(bench.latest().unwrap().block);
    bench.blocks(50);
    assert!(!bench.enable.is_high());
    (bench.fault(), reported - at, last_driven(&mut bench).unwrap() + 1 - at)
}

#[test]
fn a_certain_defect_mutes_at_once() {
    let latency = LATENCY_BLOCKS as u64;
    assert_eq!(response_to(FaultKind::LateBlock), (Some(Fault::LateBlock), 0, latency));
    assert_eq!(response_to(FaultKind::Dropout), (Some(Fault::LateBlock), 0, latency));
    assert_eq!(response_to(FaultKind::Saturation), (Some(Fault::SenseSaturated), 0, latency));
    assert_eq!(response_to(FaultKind::OverCurrentTrip), (Some(Fault::OverCurrent), 0, latency));
    assert_eq!(response_to(FaultKind::AmplifierFault), (Some(Fault::AmplifierFault), 0, latency));
    assert_eq!(response_to(FaultKind::Supply), (Some(Fault::AmplifierSupply), 0, latency));
}

#[test]
fn a_lasting_defect_mutes_after_eight_blocks() {
    let (found, silent) = (IMPLAUSIBLE_BLOCKS - 1, IMPLAUSIBLE_BLOCKS - 1 + LATENCY_BLOCKS as u64);
    assert_eq!(response_to(FaultKind::Open), (Some(Fault::LoadOpen), found, silent));
    assert_eq!(response_to(FaultKind::SensorStuck), (Some(Fault::SensorImplausible), found, silent));
}

#[test]
fn a_sensor_may_fail_for_seven_blocks_but_not_for_eight() {
    for kind in [FaultKind::SensorStuck, FaultKind::Open] {
        for (blocks, faulted) in [(1, false), (IMPLAUSIBLE_BLOCKS - 1, false), (IMPLAUSIBLE_BLOCKS, true)] {
            let mut queues = Queues::default();
            let mut bench = running(&mut queues, &Setup::default());
            bench.analog().inner.strike(kind);
            bench.blocks(blocks);
            bench.analog().inner.repair(kind);
            bench.blocks(50);
            assert_eq!(bench.fault().is_some(), faulted, "{kind:?} for {blocks} blocks");
        }
    }
}

#[test]
fn a_few_flipped_bits_do_not_stop_a_run() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.analog().inner.set_bit_flips(1e-3);
    bench.blocks(5000);
    assert_eq!((bench.mode(), bench.fault()), (Mode::Run, None));
}

#[test]
fn more_current_than_the_limit_mutes_once_it_is_measured() {
    // Three volts draw 0.15 A; the self-test draws a fifteenth of that.
    let mut queues = Queues::default();
    let mut bench = ordered_to_run_with(&mut queues, &setup(|config| config.limits.current_a = 0.1), &[]);
    bench.run_until(|report| report.mode == Mode::Fault, STARTS_WITHIN);
    let found = u64::from(bench.latest().unwrap().block);
    bench.blocks(50);
    assert_eq!(bench.fault(), Some(Fault::OverCurrent));
    let loud =
        bench.analog().blocks().find(|exchange| exchange.drive.lanes[0].iter().any(|&code| code > MID_CODE + 60)).unwrap().block;
    assert_eq!((found, last_driven(&mut bench)), (loud, Some(loud + LATENCY_BLOCKS as u64 - 1)));
}

#[test]
fn a_silent_driver_does_not_fault() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    let kinds =
        [FaultKind::LateBlock, FaultKind::OverCurrentTrip, FaultKind::AmplifierFault, FaultKind::Supply, FaultKind::Saturation];
    for kind in kinds.into_iter().chain([FaultKind::BeltStopped]) {
        bench.analog().inner.strike(kind);
        bench.blocks(300);
        assert_eq!((bench.mode(), bench.fault()), (Mode::Idle, None), "{kind:?}");
    }
}

/// Number of blocks within the 5 ms for which the drive may stay ON over a stopped belt.
const BELT_STOP_BLOCKS: u64 = 156;

fn over_belt<'a>(queues: &'a mut Queues, setup: &Setup) -> Bench<'a, Load> {
    let mut bench = bench(queues, setup);
    set_belt(&mut bench, 1);
    bench.ask(Command::Run);
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some());
    bench.blocks(300);
    assert_eq!(bench.fault(), None);
    bench
}

/// Sets the speed of the belt, counts per block.
fn set_belt(bench: &mut Bench<Load>, counts: i32) {
    bench.analog().inner.inner.set_belt(Some(counts));
}

/// Number of blocks within the 100 ms after which a mute becomes a fault.
const LATCH_BLOCKS: u64 = 3125;

fn limit(bench: &Bench<Load>) -> Option<Limit> {
    bench.latest().and_then(|report| report.limit)
}

#[test]
fn a_stopped_belt_mutes_and_is_a_fault_a_tenth_second_later() {
    for kind in [FaultKind::BeltStopped, FaultKind::EncoderStuck] {
        let mut queues = Queues::default();
        let mut bench = over_belt(&mut queues, &Setup::default());
        let stopped = bench.played();
        bench.analog().inner.strike(kind);
        bench.blocks(BELT_STOP_BLOCKS);
        assert_eq!((limit(&bench), bench.fault()), (None, None));
        bench.block();
        assert_eq!((limit(&bench), bench.fault()), (Some(Limit::BeltMuted), None));
        bench.blocks(LATCH_BLOCKS - 1);
        assert_eq!(bench.fault(), None);
        bench.block();
        assert_eq!(bench.fault(), Some(Fault::BeltStopped));
        // One more block corrects the DC offset left by rounding.
        assert_eq!(last_driven(&mut bench), Some(stopped + BELT_STOP_BLOCKS + LATENCY_BLOCKS as u64));
    }
}

#[test]
fn the_drive_resumes_only_over_a_forward_belt() {
    let mut queues = Queues::default();
    let mut bench = over_belt(&mut queues, &Setup::default());
    for (counts, muted) in [(0, true), (1, false), (-1, true), (1, true), (400, false)] {
        set_belt(&mut bench, counts);
        // The belt is drawn back by at most 200 counts: belt that has already passed does not count
        // as motion.
        bench.blocks(BELT_STOP_BLOCKS + 10);
        assert_eq!(limit(&bench) == Some(Limit::BeltMuted), muted, "{counts}");
        bench.blocks(1 + LATENCY_BLOCKS as u64);
        let now = bench.played();
        assert_eq!(last_driven(&mut bench) == Some(now - 1), !muted, "{counts}");
    }
    assert_eq!(bench.fault(), None);
}

#[test]
fn a_burst_over_a_still_belt_never_begins() {
    let mut queues = Queues::default();
    let mut bench = over_belt(&mut queues, &Setup::default());
    bench.ask(Command::Gate(Gate::Off));
    set_belt(&mut bench, 0);
    bench.blocks(2 * BELT_STOP_BLOCKS);
    let silent = last_driven(&mut bench);
    for _ in 0..20 {
        bench.ask(Command::Gate(Gate::On));
        bench.blocks(50);
        bench.ask(Command::Gate(Gate::Off));
        bench.blocks(50);
    }
    assert_eq!((bench.fault(), last_driven(&mut bench)), (None, silent));
    // A stopped belt is a fault only while a drive is requested.
    bench.blocks(2 * LATCH_BLOCKS);
    assert_eq!((bench.fault(), limit(&bench)), (None, None));
}

#[test]
fn a_lost_belt_sensor_is_a_fault_at_once() {
    let breaks: [fn(&mut Load); 2] = [|load| load.inner.inner.set_belt(None), |load| load.inner.strike(FaultKind::EncoderLost)];
    for breaks in breaks {
        let mut queues = Queues::default();
        let mut bench = over_belt(&mut queues, &Setup::default());
        let lost = bench.played();
        breaks(bench.analog());
        bench.block();
        assert_eq!(bench.fault(), Some(Fault::BeltSensorLost));
        bench.blocks(10);
        assert_eq!(last_driven(&mut bench), Some(lost + LATENCY_BLOCKS as u64 - 1));
    }
}

#[test]
fn without_the_configured_encoder_nothing_is_driven() {
    let mut queues = Queues::default();
    let with_encoder = setup(|config| config.front_end.metre_per_count = Some(1e-5));
    let mut bench = ordered_to_run_with(&mut queues, &with_encoder, &[]);
    bench.blocks(50);
    assert_eq!((bench.fault(), last_driven(&mut bench)), (Some(Fault::BeltSensorLost), None));
}

#[test]
fn a_d_ring_without_a_belt_scale_is_not_driven() {
    let unscaled = setup(|config| config.restraint = Some(Restraint::default()));
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &unscaled);
    // A counting encoder is not sufficient: the length of belt per count is not configured.
    set_belt(&mut bench, 1);
    for order in [Command::Run, Command::Scan, Command::Calibrate] {
        assert_eq!(bench.ask(order), Some(Reply::Nak(Refusal::NoBeltScale)), "{order:?}");
    }
    bench.blocks(50);
    assert_eq!((bench.mode(), last_driven(&mut bench)), (Mode::Idle, None));
    // With the scale, it drives.
    let scaled = setup(|config| {
        config.restraint = Some(Restraint::default());
        config.front_end.metre_per_count = Some(1e-5);
    });
    let mut queues = Queues::default();
    let mut bench = super::bench(&mut queues, &scaled);
    set_belt(&mut bench, 1);
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some(), "{:?}", bench.fault());
}

#[test]
fn a_run_waits_for_a_belt_at_rest() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    set_belt(&mut bench, 0);
    // The belt counts as at rest after it was measured for as long as the detection of a stop
    // takes.
    bench.blocks(BELT_STOP_BLOCKS + 1);
    bench.ask(Command::Run);
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some());
    // The self-test drives, the run does not.
    bench.blocks(2 * LATCH_BLOCKS);
    assert_eq!((bench.mode(), limit(&bench)), (Mode::Run, Some(Limit::BeltMuted)));
    assert!(last_driven(&mut bench).is_some_and(|block| block < 200 + BELT_STOP_BLOCKS));
    set_belt(&mut bench, 1);
    bench.blocks(20);
    assert_eq!((limit(&bench), last_driven(&mut bench)), (None, Some(bench.played() - 1)));
}

#[test]
fn energy_on_time_and_temperature_have_their_limits() {
    type Change = fn(&mut Config);
    let cases: [(Change, Option<FaultKind>, Fault); 3] = [
        // The loop-back is a capacitor: its apparent power is its phase error, a few milliwatt.
        (|config| config.limits.on_time_s = Some(0.05), None, Fault::OnTimeExceeded),
        (|config| config.limits.temperature_c = 80.0, Some(FaultKind::Overtemperature), Fault::OverTemperature),
        (|config| config.front_end.force_hz = Some(500.0), None, Fault::ForceSensorImplausible),
    ];
    for (change, kind, expected) in cases {
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &setup(change));
        set_belt(&mut bench, 1);
        bench.ask(Command::Run);
        bench.blocks(100);
        kind.into_iter().for_each(|kind| bench.analog().inner.strike(kind));
        bench.blocks(2000);
        assert_eq!(bench.fault(), Some(expected));
    }
}

#[test]
fn limits_out_of_range_are_refused_with_their_name() {
    type Change = fn(&mut Config);
    let cases: [(&str, Change); 7] = [
        ("limits.belt_stop_ms", |config| config.limits.belt_stop_ms = f32::NAN),
        ("limits.energy_j_per_m", |config| config.limits.energy_j_per_m = Some(-1.0)),
        ("limits.on_time_s", |config| config.limits.on_time_s = Some(0.0)),
        ("limits.temperature_c", |config| config.limits.temperature_c = f32::INFINITY),
        ("limits.power_w", |config| config.limits.power_w = Some(0.0)),
        ("thermometer.c0_per_k", |config| config.thermometer.c0_per_k = 1.0),
        ("front_end.metre_per_count", |config| config.front_end.metre_per_count = Some(0.0)),
    ];
    for (name, change) in cases {
        let mut config = Setup::default().config;
        change(&mut config);
        let refused = Controller::build(&config).err();
        assert!(matches!(refused, Some(Error::OutOfRange { parameter, .. }) if parameter == name), "{name}: {refused:?}");
    }
    let mut config = Setup::default().config;
    config.limits.energy_j_per_m = Some(100.0);
    assert_eq!(Controller::build(&config).err(), Some(Error::EnergyWithoutBelt));
}

#[test]
fn without_a_belt_sensor_the_belt_is_ignored() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.blocks(1000);
    assert_eq!(bench.fault(), None);
}
