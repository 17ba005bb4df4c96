//! Self-test: a defect is identified, mutes the drive, and is reported by number over the link.

use firmware::board::command::{Command, Reply};
use firmware::seam::block::LATENCY_BLOCKS;
use firmware::seam::config::{Config, TrackingMode};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use hal_mock::bench::{Bench, Queues, Setup};

use super::*;

/// Orders a run on `load` with these faults, and returns the number of the resulting fault.
fn end_of_self_test(setup: &Setup, load: LoopBack, broken: &[FaultKind]) -> Option<u8> {
    let mut queues = Queues::default();
    let mut bench = Bench::new(&mut queues, setup, load_of(setup, load)).unwrap();
    broken.iter().for_each(|&kind| bench.analog().inner.strike(kind));
    bench.ask(Command::TelemetryEvery(1));
    assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
    bench.run_until(|report| matches!(report.mode, Mode::Fault | Mode::Run), STARTS_WITHIN).unwrap();
    let muted_by = bench.latest().unwrap().block as u64 + LATENCY_BLOCKS as u64;
    bench.blocks(20);
    bench.host.receive(usize::MAX);
    let fault = bench.host.telemetry().last().unwrap().1.fault;
    if fault.is_some() {
        assert!(last_driven(&mut bench).is_none_or(|block| block < muted_by));
        assert!(!bench.enable.is_high());
    }
    assert!(peak(&played(&mut bench, 0)) <= if fault.is_some() { 50 } else { 300 });
    fault.map(Fault::code)
}

fn end_with(broken: &[FaultKind]) -> Option<u8> {
    let setup = Setup::default();
    end_of_self_test(&setup, LoopBack::of(&setup.config), broken)
}

fn end_on(times: f32) -> Option<u8> {
    let setup = Setup::default();
    end_of_self_test(&setup, LoopBack::of(&setup.config).times(times), &[])
}

#[test]
fn a_healthy_load_passes() {
    assert_eq!(end_with(&[]), None);
    assert_eq!((end_on(0.5), end_on(7.0)), (None, None));
}

#[test]
fn an_open_current_channel_is_an_open_load() {
    assert_eq!(end_with(&[FaultKind::Open]), Some(23));
    assert_eq!((end_on(0.25), end_on(0.0)), (Some(23), Some(23)));
}

#[test]
fn a_hundredfold_current_is_a_shorted_load() {
    assert_eq!((end_on(100.0), end_on(9.0)), (Some(22), Some(22)));
}

#[test]
fn a_sensor_at_the_end_of_its_range_is_saturated() {
    assert_eq!(end_with(&[FaultKind::Saturation]), Some(28));
}

#[test]
fn a_stuck_or_offset_sensor_is_implausible() {
    assert_eq!(end_with(&[FaultKind::SensorStuck]), Some(20));
    assert_eq!((end_with(&[FaultKind::SensorOffset(110)]), end_with(&[FaultKind::SensorOffset(-110)])), (Some(20), Some(20)));
}

#[test]
fn a_small_offset_is_removed() {
    assert_eq!((end_with(&[FaultKind::SensorOffset(90)]), end_with(&[FaultKind::SensorOffset(-90)])), (None, None));
    let mut queues = Queues::default();
    let setup = Setup::default();
    let mut bench = ordered_to_run_with(&mut queues, &setup, &[FaultKind::SensorOffset(90)]);
    bench.blocks(STARTS_WITHIN);
    let v = bench.latest().unwrap().v;
    assert!((v.re.hypot(v.im) - 3.0).abs() < 0.02, "{v}");
}

#[test]
fn half_or_twice_the_played_voltage_is_implausible() {
    for factor in [0.5, 2.0] {
        let setup = setup(|config| config.front_end.volt_per_lsb *= factor);
        let load = LoopBack::of(&setup.config);
        assert_eq!(end_of_self_test(&setup, load, &[]), Some(20), "{factor}");
    }
}

#[test]
fn a_scan_finds_no_resonance_in_a_capacitor() {
    let locking = |config: &mut Config| config.tracking.mode = TrackingMode::PhaseLock;
    for (setup, command) in [(Setup::default(), Command::Scan), (setup(locking), Command::Run)] {
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &setup);
        assert_eq!(bench.ask(command), Some(Reply::Ack));
        assert!(bench.run_until(|report| report.mode == Mode::Scan, STARTS_WITHIN).is_some());
        assert!(bench.run_until(|report| report.mode != Mode::Scan, 10_000).is_some());
        assert_eq!((bench.mode(), bench.fault().map(Fault::code)), (Mode::Fault, Some(30)));
        let found = u64::from(bench.latest().unwrap().block);
        bench.blocks(20);
        // The drive has faded when the fault is raised.
        assert_eq!(last_driven(&mut bench), Some(found));
        assert_eq!(peak(&played(&mut bench, 0)), 100);
    }
}
