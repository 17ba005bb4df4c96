//! A run from its order to silence.

use firmware::board::command::{Command, Reply};
use firmware::seam::block::{Gate, LATENCY_BLOCKS};
use firmware::seam::mode::Mode;
use hal_mock::bench::{Queues, Setup};

use super::*;

#[test]
fn a_run_begins_with_a_self_test_and_ends_in_idle() {
    let mut queues = Queues::default();
    let mut bench = bench(&mut queues, &Setup::default());
    let mut modes = vec![bench.mode()];
    let mut note = |mode| {
        if modes.last() != Some(&mode) {
            modes.push(mode);
        }
    };
    bench.blocks(3);
    bench.ask(Command::Run);
    (0..300).for_each(|_| {
        bench.block();
        note(bench.mode());
    });
    bench.ask(Command::Idle);
    (0..5).for_each(|_| {
        bench.block();
        note(bench.mode());
    });
    assert_eq!(modes, [Mode::Idle, Mode::SelfTest, Mode::Run, Mode::Idle]);
    assert_eq!(bench.errors(), []);
}

#[test]
fn the_enable_pin_is_high_only_while_driving() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.blocks(50);
    bench.ask(Command::Idle);
    bench.blocks(50);
    let edges: Vec<bool> = bench.enable.changes().iter().map(|change| change.high).collect();
    assert_eq!(edges, [false, true, false]);
    // High before the first sample that is not silent, low after the last.
    let first = bench.analog().blocks().find(|exchange| is_driven(exchange)).unwrap().block;
    let at: Vec<u64> = bench.enable.changes().iter().map(|change| change.at.as_micros() as u64 / BLOCK as u64).collect();
    assert!(at[1] <= first, "{at:?} {first}");
    // The drive fades in the last of the queued blocks, and needs its amplifier until then.
    assert_eq!(at[2], last_driven(&mut bench).unwrap() + 1, "{at:?}");
}

#[test]
fn the_self_test_plays_half_the_scan_voltage() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    let began = bench.played() as usize * BLOCK;
    bench.blocks(1000);
    let codes = played(&mut bench, 0);
    // The codes of the run begin two blocks after its first report, which was at least four blocks
    // before `began`.
    let before: Vec<u16> = codes[..began - 8 * BLOCK].to_vec();
    assert!(before[..34 * BLOCK].iter().all(|&code| code == MID_CODE));
    assert_eq!(peak(&before), 50);
    let (amplitude, _) = tone(&codes[began..], began, 40_400.0);
    assert!((amplitude - 3.0 * CODES_PER_VOLT).abs() < 0.05, "{amplitude}");
    assert_eq!(peak(&codes[began..]), 300);
}

#[test]
fn idle_fades_after_the_queued_codes() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    let ordered = bench.played();
    assert_eq!(bench.ask(Command::Idle), Some(Reply::Ack));
    bench.blocks(50);
    assert_eq!(last_driven(&mut bench), Some(ordered + LATENCY_BLOCKS as u64));
}

#[test]
fn the_gate_acts_on_whole_periods_with_continuous_phase() {
    let mut queues = Queues::default();
    let setup = Setup::default();
    let mut bench = running(&mut queues, &setup);
    let mut ordered = Vec::new();
    for gate in [Gate::Off, Gate::On] {
        ordered.push((bench.played() as usize + LATENCY_BLOCKS) * BLOCK);
        assert_eq!(bench.ask(Command::Gate(gate)), Some(Reply::Ack));
        bench.blocks(20);
    }
    assert_eq!(bench.mode(), Mode::Run);
    let codes = played(&mut bench, 0);
    let whole = codes_of_run(&setup, bench.played());
    for (n, (&code, &uninterrupted)) in codes.iter().zip(&whole).enumerate() {
        // It closes within a period, corrects the remaining DC offset, and opens within half a
        // period.
        match n {
            n if (ordered[0]..ordered[0] + 25).contains(&n) => {}
            n if (ordered[0] + 25..ordered[0] + 80).contains(&n) => assert!(code.abs_diff(MID_CODE) <= 32, "sample {n}"),
            n if (ordered[0] + 80..ordered[1]).contains(&n) => assert_eq!(code, MID_CODE, "sample {n}"),
            n if (ordered[1]..ordered[1] + 13).contains(&n) => {}
            _ => assert_eq!(code, uninterrupted, "sample {n}"),
        }
    }
}

#[test]
fn clear_and_run_between_two_blocks_are_both_obeyed() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.analog().inner.strike(FaultKind::LateBlock);
    bench.blocks(5);
    assert_eq!(bench.mode(), Mode::Fault);
    assert_eq!((bench.ask(Command::ClearFault), bench.ask(Command::Run)), (Some(Reply::Ack), Some(Reply::Ack)));
    assert!(bench.run_until(|report| report.mode == Mode::Run, STARTS_WITHIN).is_some());
}

#[test]
fn run_alone_does_not_clear_a_fault() {
    let mut queues = Queues::default();
    let mut bench = running(&mut queues, &Setup::default());
    bench.analog().inner.strike(FaultKind::LateBlock);
    bench.blocks(5);
    let silent_from = last_driven(&mut bench);
    for command in [Command::Run, Command::Idle, Command::Scan, Command::Run] {
        bench.ask(command);
        bench.blocks(STARTS_WITHIN);
    }
    assert_eq!((bench.mode(), last_driven(&mut bench)), (Mode::Fault, silent_from));
}
