//! Loss of the host while the drive is on: the drive stops or continues, as configured.

use firmware::board::command::{Command, Reply};
use firmware::seam::block::{Gate, LATENCY_BLOCKS};
use firmware::seam::config::Link;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Queues, Setup};

use super::*;

/// Patience of 400 blocks of 32 us, which is longer than a self-test, s.
const PATIENCE_S: f32 = 12.8e-3;
/// The same patience, blocks.
const PATIENCE_BLOCKS: u64 = 400;

fn with_host_timeout() -> Setup {
    setup(|config| config.link = Link { patience_s: PATIENCE_S })
}

#[test]
fn the_drive_stops_exactly_after_the_patience() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &with_host_timeout());
    bench.ask(Command::Status);
    let received = u64::from(bench.latest().unwrap().block);
    bench.blocks(PATIENCE_BLOCKS);
    assert_eq!((bench.mode(), bench.fault()), (Mode::Run, None));
    bench.blocks(3);
    assert_eq!((bench.mode(), bench.fault(), Fault::HostLost.code()), (Mode::Fault, Some(Fault::HostLost), 12));
    assert!(!bench.enable.is_high());
    // The report of the block after the patience shows the loss; the next block obeys the order,
    // which plays after the latency.
    let last = last_driven(&mut bench).unwrap();
    assert_eq!(last, received + PATIENCE_BLOCKS + 1 + LATENCY_BLOCKS as u64);
    bench.blocks(STARTS_WITHIN);
    assert_eq!((bench.fault(), last_driven(&mut bench)), (Some(Fault::HostLost), Some(last)));
    assert_eq!(bench.watchdog.bitten(), None);
}

#[test]
fn without_a_timeout_the_drive_continues() {
    for setup in [Setup::default(), with_host_timeout()] {
        let mut queues = Queues::default();
        let mut bench = bench(&mut queues, &setup);
        assert_eq!(bench.ask(Command::Patience(0.0)), Some(Reply::Ack));
        assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
        bench.blocks(40_000);
        assert_eq!((bench.mode(), bench.fault()), (Mode::Run, None));
    }
}

#[test]
fn an_ordered_timeout_acts_at_once() {
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
    bench.blocks(10 * PATIENCE_BLOCKS);
    assert_eq!(bench.fault(), None);
    assert_eq!(bench.ask(Command::Patience(PATIENCE_S)), Some(Reply::Ack));
    bench.blocks(PATIENCE_BLOCKS + 3);
    assert_eq!(bench.fault(), Some(Fault::HostLost));
}

#[test]
fn only_valid_frames_of_the_session_prevent_the_timeout() {
    for (whole, fault) in [(true, None), (false, Some(Fault::HostLost))] {
        let mut queues = Queues::default();
        let mut bench = running(&mut queues, &with_host_timeout());
        for _ in 0..10 {
            let mut frame = firmware::board::link::encode(7, bench.host.session(), Command::Resonances).unwrap();
            if !whole {
                frame[1] ^= 0x10;
            }
            bench.host.send_bytes(&frame).unwrap();
            bench.blocks(PATIENCE_BLOCKS / 2);
        }
        assert_eq!(bench.fault(), fault, "{whole}");
    }
}

#[test]
fn a_silent_board_has_no_timeout() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &with_host_timeout());
    bench.blocks(10 * PATIENCE_BLOCKS);
    assert_eq!((bench.mode(), bench.fault()), (Mode::Idle, None));
    bench.ask(Command::Run);
    assert!(bench.run_until(|report| report.mode == Mode::Run, PATIENCE_BLOCKS).is_some());
}

#[test]
fn a_returning_host_must_clear_the_fault_and_order_a_run() {
    for clears_first in [true, false] {
        let mut queues = Queues::default();
        let mut bench = running(&mut queues, &with_host_timeout());
        bench.blocks(2 * PATIENCE_BLOCKS);
        assert_eq!(bench.fault(), Some(Fault::HostLost));
        let silent_from = last_driven(&mut bench);
        if !clears_first {
            // Queries of the host end the loss, but do not clear the fault.
            assert!(matches!(bench.ask(Command::Identify(1)), Some(Reply::Identity(_))));
            assert!(matches!(bench.ask(Command::Status), Some(Reply::Status(_))));
            bench.blocks(10);
            assert_eq!(bench.ask(Command::Run), Some(Reply::Ack));
            bench.blocks(10);
            assert_eq!(bench.fault(), Some(Fault::HostLost));
        }
        assert_eq!(bench.ask(Command::ClearFault), Some(Reply::Ack));
        bench.blocks(10);
        assert_eq!((bench.mode(), bench.fault(), last_driven(&mut bench)), (Mode::Idle, None, silent_from));
        bench.ask(Command::Run);
        assert!(bench.run_until(|report| report.mode == Mode::Run, PATIENCE_BLOCKS).is_some(), "{:?}", bench.latest());
    }
}

#[test]
fn a_stalled_stream_receives_the_order_later() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &with_host_timeout());
    bench.blocks(PATIENCE_BLOCKS - 10);
    while bench.ask(Command::Gate(Gate::On)) == Some(Reply::Ack) {}
    bench.blocks(2 * PATIENCE_BLOCKS);
    assert_eq!(bench.fault(), Some(Fault::HostLost));
}
