//! Protection while running: which fault, and how many blocks later the drive is silent.

use firmware::block::{Gate, LATENCY_BLOCKS};
use firmware::command::Command;
use firmware::supervisor::{Fault, Mode};
use hal_mock::bench::{Bench, Queues, Setup};

use super::*;

/// Blocks for which a sensor must be implausible before that counts.
const IMPLAUSIBLE_BLOCKS: u64 = 8;

/// Lets `kind` strike a healthy run: the fault, the blocks from its first to the report, and from its first to silence.
fn struck(kind: FaultKind) -> (Option<Fault>, u64, u64) {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.blocks(100);
    let at = bench.played();
    bench.analog().inner.strike(kind);
    bench.run_until(|report| report.mode == Mode::Fault, 1000);
    let reported = u64::from(bench.latest().unwrap().block);
    bench.blocks(50);
    assert!(!bench.enable.is_high());
    (bench.fault(), reported - at, last_sounding(&mut bench).unwrap() + 1 - at)
}

#[test]
fn what_is_certain_mutes_at_once() {
    let latency = LATENCY_BLOCKS as u64;
    assert_eq!(struck(FaultKind::LateBlock), (Some(Fault::LateBlock), 0, latency));
    assert_eq!(struck(FaultKind::Dropout), (Some(Fault::LateBlock), 0, latency));
    assert_eq!(struck(FaultKind::Saturation), (Some(Fault::SenseSaturated), 0, latency));
    assert_eq!(struck(FaultKind::OverCurrentTrip), (Some(Fault::OverCurrent), 0, latency));
}

#[test]
fn what_may_be_an_accident_mutes_when_it_lasts() {
    let (found, silent) = (IMPLAUSIBLE_BLOCKS - 1, IMPLAUSIBLE_BLOCKS - 1 + LATENCY_BLOCKS as u64);
    assert_eq!(struck(FaultKind::Open), (Some(Fault::LoadOpen), found, silent));
    assert_eq!(struck(FaultKind::SensorStuck), (Some(Fault::SensorImplausible), found, silent));
}

#[test]
fn a_sensor_that_recovers_in_seven_blocks_is_forgiven_in_eight_it_is_not() {
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
fn more_current_than_the_limit_mutes_when_it_is_heard() {
    // Three volts draw 0.15 A, the self-test a fifteenth of that.
    let mut queues = Queues::default();
    let mut bench = ordered_to_run_with(&mut queues, &setup(|config| config.limits.current_a = 0.1), &[]);
    bench.run_until(|report| report.mode == Mode::Fault, PATIENCE);
    let found = u64::from(bench.latest().unwrap().block);
    bench.blocks(50);
    assert_eq!(bench.fault(), Some(Fault::OverCurrent));
    let loud =
        bench.analog().blocks().find(|exchange| exchange.drive.lanes[0].iter().any(|&code| code > MID + 60)).unwrap().block;
    assert_eq!((found, last_sounding(&mut bench)), (loud, Some(loud + LATENCY_BLOCKS as u64 - 1)));
}

#[test]
fn a_silent_driver_does_not_fault() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    for kind in [FaultKind::LateBlock, FaultKind::OverCurrentTrip, FaultKind::Saturation, FaultKind::BeltStopped] {
        bench.analog().inner.strike(kind);
        bench.blocks(300);
        assert_eq!((bench.mode(), bench.fault()), (Mode::Idle, None), "{kind:?}");
    }
}

/// Blocks that fit into the 5 ms that the drive may stay ON over a stopped belt.
const BELT_BLOCKS: u64 = 156;

fn over_belt<'a>(queues: &'a mut Queues, setup: &Setup) -> Bench<'a, Load> {
    let mut bench = bench(queues, setup);
    set_belt(&mut bench, 1);
    bench.ask(Command::Run);
    assert!(bench.run_until(|report| report.mode == Mode::Run, PATIENCE).is_some());
    bench.blocks(300);
    assert_eq!(bench.fault(), None);
    bench
}

/// Lets the belt move by so many counts in each block.
fn set_belt(bench: &mut Bench<Load>, counts: i32) {
    bench.analog().inner.inner.set_belt(Some(counts));
}

#[test]
fn a_stopped_belt_mutes_after_its_time_and_not_before() {
    for kind in [FaultKind::BeltStopped, FaultKind::EncoderStuck] {
        let mut queues = Queues::default();
        let mut bench = over_belt(&mut queues, &Setup::default());
        let stopped = bench.played();
        bench.analog().inner.strike(kind);
        bench.blocks(BELT_BLOCKS);
        assert_eq!(bench.fault(), None);
        bench.block();
        assert_eq!(bench.fault(), Some(Fault::BeltStopped));
        bench.blocks(10);
        assert_eq!(last_sounding(&mut bench), Some(stopped + BELT_BLOCKS + LATENCY_BLOCKS as u64 - 1));
    }
}

#[test]
fn a_belt_that_moves_on_begins_the_time_anew_and_one_that_is_drawn_back_does_not() {
    let mut queues = Queues::default();
    let mut bench = over_belt(&mut queues, &Setup::default());
    for _ in 0..2 {
        set_belt(&mut bench, 0);
        bench.blocks(BELT_BLOCKS);
        set_belt(&mut bench, 1);
        bench.block();
    }
    set_belt(&mut bench, -1);
    bench.blocks(BELT_BLOCKS);
    assert_eq!(bench.fault(), None);
    bench.block();
    assert_eq!(bench.fault(), Some(Fault::BeltStopped));
}

#[test]
fn short_bursts_over_a_still_belt_add_up() {
    let mut queues = Queues::default();
    let mut bench = over_belt(&mut queues, &Setup::default());
    set_belt(&mut bench, 0);
    // Half of the time ON: it takes twice as long, and no longer.
    for _ in 0..BELT_BLOCKS / 10 {
        bench.ask(Command::Gate(Gate::Off));
        bench.blocks(10);
        bench.ask(Command::Gate(Gate::On));
        bench.blocks(10);
    }
    assert_eq!(bench.fault(), Some(Fault::BeltStopped));
}

#[test]
fn a_belt_sensor_that_is_gone_or_broken_does_not_count_as_moving() {
    let breaks: [fn(&mut Load); 2] = [|load| load.inner.inner.set_belt(None), |load| load.inner.strike(FaultKind::EncoderLost)];
    for breaks in breaks {
        let mut queues = Queues::default();
        let mut bench = over_belt(&mut queues, &Setup::default());
        breaks(bench.analog());
        bench.blocks(BELT_BLOCKS + 1);
        assert_eq!(bench.fault(), Some(Fault::BeltStopped));
    }
}

#[test]
fn without_a_belt_sensor_the_belt_is_not_judged() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.blocks(1000);
    assert_eq!(bench.fault(), None);
}
