//! Scan and lock ordered over the link, on the simulated transducer, because the loop-back has no
//! resonance.

use firmware::board::command::{Command, Reply, ResonanceReport};
use firmware::seam::block::{Amplitude, Gate};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use hal_mock::bench::{Bench, Queues, Setup};
use hal_mock::tracer::Tracer;
use plant::Plant;
use scene::load::load;
use scene::settings;

use super::STARTS_WITHIN;

/// Number of blocks that is sufficient for a scan or for a lock.
const LOCKS_WITHIN: u64 = 20_000;
/// Series resonance of the scene's stack, Hz.
const RESONANCE_HZ: f32 = 40_520.0;

fn on_transducer(queues: &mut Queues) -> Bench<'_, Tracer<Plant>> {
    let scene = load("lock", &[]).expect("a valid scene").scene;
    let scene = scene.driven().expect("a driven scene");
    let setup = Setup { config: settings::config(&scene), ..Setup::default() };
    Bench::new(queues, &setup, Tracer::new(Plant::new(&scene), 8)).unwrap()
}

/// Returns a bench whose transducer has been scanned.
fn scanned(queues: &mut Queues) -> Bench<'_, Tracer<Plant>> {
    let mut bench = on_transducer(queues);
    assert_eq!(bench.ask(Command::Scan), Some(Reply::Ack));
    assert!(bench.run_until(|report| report.mode == Mode::Scan, STARTS_WITHIN).is_some());
    assert!(bench.run_until(|report| report.mode != Mode::Scan, LOCKS_WITHIN).is_some());
    bench
}

fn is_silent(bench: &mut Bench<Tracer<Plant>>) -> bool {
    bench.blocks(8);
    bench.analog().blocks().all(|exchange| exchange.drive.lanes[0].iter().all(|&code| code == exchange.drive.lanes[0][0]))
}

#[test]
fn a_scan_reports_the_transducer_and_falls_silent() {
    let mut queues = Queues::default();
    let mut bench = scanned(&mut queues);
    let found = bench.latest().unwrap().transducer.unwrap();
    assert!((found.series_resonance_hz - RESONANCE_HZ).abs() < 5.0, "{found:?}");
    bench.blocks(STARTS_WITHIN);
    assert_eq!((bench.mode(), bench.fault(), bench.enable.is_high()), (Mode::Idle, None, false));
    assert!(is_silent(&mut bench));
}

#[test]
fn orders_after_a_scan_cause_no_edge_of_the_enable() {
    let mut queues = Queues::default();
    let mut bench = scanned(&mut queues);
    bench.blocks(STARTS_WITHIN);
    let edges = bench.enable.changes().len();
    for gate in [Gate::Off, Gate::On] {
        assert_eq!(bench.ask(Command::Gate(gate)), Some(Reply::Ack));
        bench.blocks(8);
    }
    assert_eq!(bench.enable.changes().len(), edges);
    // A new attempt raises the pin, before the block that begins it.
    assert_eq!(bench.ask(Command::Scan), Some(Reply::Ack));
    assert!(bench.enable.is_high());
}

#[test]
fn the_resonances_are_listed_over_the_link() {
    let mut queues = Queues::default();
    let mut bench = on_transducer(&mut queues);
    assert_eq!(bench.ask(Command::Resonances), Some(Reply::Resonances(ResonanceReport::default())));
    assert_eq!(bench.ask(Command::Scan), Some(Reply::Ack));
    assert!(bench.run_until(|report| report.transducer.is_some(), LOCKS_WITHIN).is_some());
    bench.blocks(STARTS_WITHIN);
    let Some(Reply::Resonances(report)) = bench.ask(Command::Resonances) else { panic!("no list") };
    let found = report.found[0].unwrap();
    assert!((found.hz - RESONANCE_HZ).abs() < 1.0 && (found.q - 64.6).abs() < 0.5, "{report:?}");
    assert_eq!((report.chosen, report.found[1]), (Some(0), None));
}

#[test]
fn other_orders_do_not_repeat_a_scan() {
    let mut queues = Queues::default();
    let mut bench = scanned(&mut queues);
    for command in [Command::Gate(Gate::On), Command::Amplitude(Some(Amplitude::Volts(1.0))), Command::TelemetryEvery(10)] {
        assert_eq!(bench.ask(command), Some(Reply::Ack));
        bench.blocks(STARTS_WITHIN);
        assert_eq!((bench.mode(), is_silent(&mut bench)), (Mode::Idle, true), "{command:?}");
    }
}

#[test]
fn a_scan_order_repeats_a_scan() {
    let mut queues = Queues::default();
    let mut bench = scanned(&mut queues);
    assert_eq!(bench.ask(Command::Scan), Some(Reply::Ack));
    assert!(bench.run_until(|report| report.mode == Mode::Scan, STARTS_WITHIN).is_some());
}

#[test]
fn a_run_locks_on_the_resonance() {
    let mut queues = Queues::default();
    let mut bench = on_transducer(&mut queues);
    assert_eq!((bench.ask(Command::Gate(Gate::On)), bench.ask(Command::Run)), (Some(Reply::Ack), Some(Reply::Ack)));
    assert!(bench.run_until(|report| report.mode == Mode::Run && report.locked, LOCKS_WITHIN).is_some(), "{:?}", bench.latest());
    bench.blocks(2000);
    let report = bench.latest().unwrap();
    assert!((report.frequency.0 - RESONANCE_HZ).abs() < 5.0 && report.locked && report.fault.is_none(), "{report:?}");
    assert!(bench.enable.is_high());
}

#[test]
fn the_emergency_stop_ends_a_scan() {
    let mut queues = Queues::default();
    let mut bench = on_transducer(&mut queues);
    bench.ask(Command::Scan);
    assert!(bench.run_until(|report| report.mode == Mode::Scan, STARTS_WITHIN).is_some());
    bench.blocks(100);
    bench.press_stop();
    bench.poll();
    assert!(!bench.enable.is_high());
    bench.blocks(2);
    assert_eq!((bench.fault(), is_silent(&mut bench)), (Some(Fault::EmergencyStop), true));
}
