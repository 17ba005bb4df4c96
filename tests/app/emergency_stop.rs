//! Emergency stop: the amplifier is off at once, the controller mutes, and nothing restarts
//! automatically.

use firmware::board::app::AppError;
use firmware::board::command::{Command, Reply};
use firmware::seam::block::{Gate, LATENCY_BLOCKS};
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use hal_mock::bench::{Queues, Setup};

use super::*;

#[test]
fn drops_the_enable_pin_in_the_same_turn() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    let (now, blocks) = (bench.clock.now(), bench.played());
    bench.press_stop();
    bench.poll();
    let last = *bench.enable.changes().last().unwrap();
    assert_eq!((last.at, last.high, bench.played()), (now, false, blocks));
}

#[test]
fn mutes_after_the_latency_and_stays_muted_when_released() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    let pressed = bench.played();
    bench.press_stop();
    bench.poll();
    bench.blocks(50);
    assert_eq!((bench.mode(), bench.fault()), (Mode::Fault, Some(Fault::EmergencyStop)));
    bench.release_stop();
    bench.blocks(STARTS_WITHIN);
    assert_eq!((bench.mode(), bench.fault()), (Mode::Fault, Some(Fault::EmergencyStop)));
    bench.ask(Command::Run);
    bench.blocks(STARTS_WITHIN);
    assert_eq!(bench.mode(), Mode::Fault);
    assert_eq!(last_driven(&mut bench), Some(pressed + LATENCY_BLOCKS as u64 - 1));
    assert!(!bench.enable.is_high());
}

#[test]
fn clear_and_run_start_again_but_clear_alone_does_not() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.press_stop();
    bench.blocks(10);
    bench.release_stop();
    bench.blocks(10);
    assert_eq!(bench.ask(Command::ClearFault), Some(Reply::Ack));
    let silent_from = last_driven(&mut bench);
    bench.blocks(STARTS_WITHIN);
    assert_eq!((bench.mode(), bench.fault(), last_driven(&mut bench)), (Mode::Idle, None, silent_from));
    bench.ask(Command::Run);
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some());
    assert!(bench.enable.is_high());
}

#[test]
fn cannot_be_cleared_while_it_is_pressed() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.press_stop();
    bench.blocks(10);
    let silent_from = last_driven(&mut bench);
    bench.ask(Command::ClearFault);
    bench.ask(Command::Run);
    bench.blocks(STARTS_WITHIN);
    assert_eq!((bench.fault(), last_driven(&mut bench)), (Some(Fault::EmergencyStop), silent_from));
}

#[test]
fn nothing_runs_if_pressed_at_power_up() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    bench.press_stop();
    bench.ask(Command::Run);
    bench.blocks(STARTS_WITHIN);
    assert_eq!((bench.fault(), last_driven(&mut bench)), (Some(Fault::EmergencyStop), None));
    assert!(bench.enable.changes().iter().all(|change| !change.high));
}

#[test]
fn a_press_shorter_than_a_block_is_not_lost() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.press_stop();
    bench.poll();
    bench.release_stop();
    bench.poll();
    bench.blocks(5);
    assert_eq!(bench.fault(), Some(Fault::EmergencyStop));
    // Nor does an older report enable the amplifier again.
    assert_eq!(bench.enable.changes().iter().filter(|change| change.high).count(), 1, "{:?}", bench.enable.changes());
}

#[test]
fn a_stop_works_while_the_block_stream_is_stalled() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    let busy = (0..20).find(|_| bench.ask(Command::Gate(Gate::Off)) == Some(Reply::Nak(Refusal::Busy)));
    assert!(busy.is_some());
    bench.press_stop();
    for _ in 0..3 {
        bench.poll();
        assert!(!bench.enable.is_high());
    }
    // The stream continues after the stop was released: the press was detected nevertheless.
    bench.release_stop();
    bench.poll();
    bench.blocks(40);
    assert_eq!((bench.fault(), bench.enable.is_high()), (Some(Fault::EmergencyStop), false));
}

#[test]
fn a_contact_that_cannot_be_read_drops_the_enable_pin() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.stop.set_failing(true);
    bench.blocks(3);
    assert!(!bench.enable.is_high());
    assert_eq!(bench.errors(), [AppError::Pin; 3]);
}

#[test]
fn does_not_hide_or_clear_an_earlier_fault() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.analog().inner.strike(FaultKind::LateBlock);
    bench.blocks(5);
    bench.press_stop();
    bench.blocks(5);
    bench.release_stop();
    bench.blocks(STARTS_WITHIN);
    assert_eq!((bench.mode(), bench.fault()), (Mode::Fault, Some(Fault::LateBlock)));
}
