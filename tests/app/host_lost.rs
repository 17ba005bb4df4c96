//! A host that vanishes while the drive is on: the drive stops, or goes on, as configured.

use firmware::board::command::{Command, Reply};
use firmware::seam::block::{Gate, LATENCY_BLOCKS};
use firmware::seam::config::Link;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Queues, Setup};

use super::*;

/// 400 blocks of 32 us, which a self-test is shorter than.
const PATIENCE_S: f32 = 12.8e-3;
const SILENT: u64 = 400;

fn impatient() -> Setup {
    setup(|config| config.link = Link { patience_s: PATIENCE_S })
}

#[test]
fn the_drive_stops_when_the_patience_is_over_and_not_before() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &impatient());
    bench.ask(Command::Status);
    let received = u64::from(bench.latest().unwrap().block);
    bench.blocks(SILENT);
    assert_eq!((bench.mode(), bench.fault()), (Mode::Run, None));
    bench.blocks(3);
    assert_eq!((bench.mode(), bench.fault(), Fault::HostLost.code()), (Mode::Fault, Some(Fault::HostLost), 12));
    assert!(!bench.enable.is_high());
    // Judged with the report of the block after the patience, ordered with the next, and the latency after that.
    let last = last_sounding(&mut bench).unwrap();
    assert_eq!(last, received + SILENT + 1 + LATENCY_BLOCKS as u64);
    bench.blocks(PATIENCE);
    assert_eq!((bench.fault(), last_sounding(&mut bench)), (Some(Fault::HostLost), Some(last)));
    assert_eq!(bench.watchdog.bitten(), None);
}

#[test]
fn configured_to_go_on_it_goes_on() {
    for setup in [Setup::default(), impatient()] {
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &setup);
        assert_eq!(bench.ask(Command::Patience(0.0)), Some(Reply::Ack));
        assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
        bench.blocks(40_000);
        assert_eq!((bench.mode(), bench.fault()), (Mode::Run, None));
    }
}

#[test]
fn an_ordered_timeout_acts_at_once_and_no_number_is_refused() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    for (seconds, refusal) in [
        (f32::NAN, Refusal::NotPlausible),
        (-1.0, Refusal::NotPlausible),
        (f32::INFINITY, Refusal::OutOfRange),
        (3601.0, Refusal::OutOfRange),
    ] {
        assert_eq!(bench.ask(Command::Patience(seconds)), Some(Reply::Nak(refusal)), "{seconds}");
    }
    bench.blocks(10 * SILENT);
    assert_eq!(bench.fault(), None);
    assert_eq!(bench.ask(Command::Patience(PATIENCE_S)), Some(Reply::Ack));
    bench.blocks(SILENT + 3);
    assert_eq!(bench.fault(), Some(Fault::HostLost));
}

#[test]
fn any_good_frame_of_the_session_is_the_host_and_no_damaged_one() {
    for (whole, fault) in [(true, None), (false, Some(Fault::HostLost))] {
        let mut queues = Queues::default();
        let mut bench = running(&mut queues, &impatient());
        for _ in 0..10 {
            let mut frame = firmware::board::link::encode(7, bench.host.session(), Command::Resonances).unwrap();
            if !whole {
                frame[1] ^= 0x10;
            }
            bench.host.send_bytes(&frame).unwrap();
            bench.blocks(SILENT / 2);
        }
        assert_eq!(bench.fault(), fault, "{whole}");
    }
}

#[test]
fn a_silent_drive_waits_for_ever() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &impatient());
    bench.blocks(10 * SILENT);
    assert_eq!((bench.mode(), bench.fault()), (Mode::Idle, None));
    bench.ask(Command::Run);
    assert!(bench.run_until(|report| report.mode == Mode::Run, SILENT).is_some());
}

#[test]
fn one_that_comes_back_clears_it_and_only_an_order_drives_again() {
    for clears_first in [true, false] {
        let mut queues = Queues::default();
        let mut bench = running(&mut queues, &impatient());
        bench.blocks(2 * SILENT);
        assert_eq!(bench.fault(), Some(Fault::HostLost));
        let silent_from = last_sounding(&mut bench);
        if !clears_first {
            // A host that asks is back, and nothing else.
            assert!(matches!(bench.ask(Command::Identify(1)), Some(Reply::Identity(_))));
            assert!(matches!(bench.ask(Command::Status), Some(Reply::Status(_))));
            bench.blocks(10);
            assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
            bench.blocks(10);
            assert_eq!(bench.fault(), Some(Fault::HostLost));
        }
        assert_eq!(bench.ask(Command::ClearFault), Some(Reply::Ack));
        bench.blocks(10);
        assert_eq!((bench.mode(), bench.fault(), last_sounding(&mut bench)), (Mode::Idle, None, silent_from));
        bench.ask(Command::Run);
        assert!(bench.run_until(|report| report.mode == Mode::Run, SILENT).is_some(), "{:?}", bench.latest());
    }
}

#[test]
fn a_stream_that_stood_still_receives_the_order_later() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &impatient());
    bench.blocks(SILENT - 10);
    while bench.ask(Command::Gate(Gate::On)) == Some(Reply::Ack) {}
    bench.blocks(2 * SILENT);
    assert_eq!(bench.fault(), Some(Fault::HostLost));
}
