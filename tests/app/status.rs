//! Status, the fault log, the cause of the start, and resets.

use firmware::board::command::{Command, Reply};
use firmware::board::fault_log::{FaultReport, LOGGED_FAULTS};
use firmware::board::start::{FileName, Place, Start, TripFailure};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Bench, Queues, Setup};
use hal_mock::link::{WhenFull, Wire};

use super::*;

fn faults(bench: &mut Bench<Load>, later: u8) -> FaultReport {
    match bench.ask(Command::Faults(later)) {
        Some(Reply::Faults(report)) => report,
        other => panic!("{other:?}"),
    }
}

#[test]
fn status_is_the_latest_block() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    assert_eq!(bench.ask(Command::Status), Some(Reply::Status(None)));
    bench.ask(Command::Run);
    bench.blocks(STARTS_WITHIN);
    let latest = *bench.latest().unwrap();
    assert_eq!((latest.mode, latest.block), (Mode::Run, STARTS_WITHIN as u32 - 1));
    assert_eq!(bench.ask(Command::Status), Some(Reply::Status(Some(latest))));
}

#[test]
fn a_fault_is_logged_with_drive_and_measurements() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    assert_eq!(faults(&mut bench, 0), FaultReport { count: 0, entry: None, last_run: Start::PowerOn });
    bench.analog().inner.strike(FaultKind::LateBlock);
    let before = *bench.latest().unwrap();
    bench.block();
    let seen = *bench.latest().unwrap();
    assert_eq!((before.mode, seen.fault), (Mode::Run, Some(Fault::LateBlock)));
    bench.blocks(20);
    let report = faults(&mut bench, 0);
    let entry = report.entry.expect("a fault");
    assert_eq!((report.count, entry.fault, entry.block, entry.mode), (1, Fault::LateBlock, seen.block, Mode::Run));
    assert_eq!((entry.frequency, entry.drive, entry.envelope), (before.frequency, before.drive, before.envelope));
    assert_eq!((entry.v, entry.i, entry.motional_current), (seen.v, seen.i, seen.motional_current));
    assert!(entry.drive.0 == 3.0 && entry.envelope == 1.0 && (entry.v.norm_sqr().sqrt() - 3.0).abs() < 0.03, "{entry:?}");
}

#[test]
fn the_newest_fault_is_first_and_none_follows_the_last() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    for n in 0..LOGGED_FAULTS + 2 {
        let kind = if n % 2 == 0 { FaultKind::LateBlock } else { FaultKind::OverCurrentTrip };
        bench.analog().inner.strike(kind);
        bench.blocks(5);
        bench.ask(Command::ClearFault);
        bench.blocks(5);
        bench.ask(Command::Run);
        assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some());
    }
    let entries: Vec<_> = (0..LOGGED_FAULTS as u8 + 1).map(|later| faults(&mut bench, later).entry).collect();
    let kinds: Vec<_> = entries.iter().flatten().map(|entry| entry.fault).collect();
    assert_eq!(kinds, [Fault::OverCurrent, Fault::LateBlock].repeat(LOGGED_FAULTS / 2));
    assert!(entries.iter().flatten().map(|entry| entry.block).is_sorted_by(|newer, older| newer > older));
    assert_eq!((entries[LOGGED_FAULTS], faults(&mut bench, 255).entry), (None, None));
    assert_eq!(usize::from(faults(&mut bench, 0).count), LOGGED_FAULTS + 2);
}

#[test]
fn the_cause_of_the_start_is_reported() {
    let panic = Start::Panic(Place { file: FileName::of("firmware/src/controller.rs"), line: 311 });
    for start in [
        Start::PowerOn,
        Start::Watchdog,
        Start::Ordered,
        Start::HardFault(0x0800_1234),
        Start::TripFailed(TripFailure::Wire),
        panic,
    ] {
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &Setup { start, ..Setup::default() });
        assert_eq!(faults(&mut bench, 0), FaultReport { count: 0, entry: None, last_run: start });
    }
}

#[test]
fn a_reset_is_answered_first_and_only_accepted_in_silence() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    assert_eq!(bench.ask(Command::Reset), Some(Reply::Nak(Refusal::Driving)));
    assert_eq!(bench.ask(Command::Idle), Some(Reply::Ack));
    // The order to be silent has not taken effect yet.
    assert_eq!((bench.ask(Command::Reset), bench.watchdog.resets()), (Some(Reply::Nak(Refusal::Driving)), 0));
    // Queued blocks play, and fade, while the mode is already idle.
    for _ in 0..2 {
        bench.block();
        assert_eq!((bench.mode(), bench.ask(Command::Reset)), (Mode::Idle, Some(Reply::Nak(Refusal::Driving))));
        assert_eq!(bench.ask(Command::Mute(false)), Some(Reply::Nak(Refusal::Driving)));
    }
    bench.blocks(2);
    assert_eq!((bench.ask(Command::Reset), bench.watchdog.resets()), (Some(Reply::Ack), 1));
    // A board in a fault is silent too.
    bench.ask(Command::Run);
    assert_eq!(bench.ask(Command::Reset), Some(Reply::Nak(Refusal::Driving)));
    bench.press_stop();
    bench.blocks(4);
    assert_eq!((bench.ask(Command::Reset), bench.watchdog.resets()), (Some(Reply::Ack), 2));
}

#[test]
fn a_reset_waits_until_its_answer_is_sent() {
    let mut queues = Queues::default();
    let narrow = Wire { capacity: Some(4), when_full: WhenFull::Refuses };
    let mut bench = bench(&mut queues, &Setup { to_host: narrow, ..Setup::default() });
    bench.blocks(4);
    bench.host.send(Command::TelemetryEvery(1)).unwrap();
    let reset = bench.host.send(Command::Reset).unwrap();
    let run = bench.host.send(Command::Run).unwrap();
    for _ in 0..1000 {
        bench.block();
        assert_eq!(bench.host.answer_to(run), None);
        if bench.watchdog.resets() > 0 {
            break;
        }
        bench.host.receive(4);
    }
    bench.host.receive(usize::MAX);
    assert_eq!((bench.watchdog.resets(), bench.host.answer_to(reset)), (1, Some(Reply::Ack)));
    assert_eq!(last_driven(&mut bench), None);
}
