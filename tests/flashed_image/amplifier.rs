//! The amplifier's fault output, and the status LED that tells of it.

use std::time::Duration;

use firmware::board::command::Command;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use nucleo_g474re::blocks::{BLOCK, CYCLES_PER_SAMPLE};
use nucleo_g474re::config::SILENCE;

use super::{connected, driving, elf, powered, reaches};

/// Cycles of a millisecond.
const MILLISECOND: u64 = 1000 * CYCLES_PER_SAMPLE as u64;

#[test]
fn an_amplifier_that_reports_a_fault_is_silent_and_off_within_two_blocks() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = driving(elf);
    assert!(board.borrow().bench().led.last().is_some_and(|edge| edge.high), "the LED is lit while it drives");
    let failed = board.borrow().machine().cycle() + 1000;
    board.borrow_mut().bench_mut().fail_amplifier(Some(failed));
    board.borrow_mut().run_for(Duration::from_micros(2 * BLOCK as u64)).expect("no finding");
    assert!(!board.borrow().bench().is_enabled());
    assert_eq!(board.borrow().bench().code(), SILENCE);
    let report = client.status().expect("an answer").expect("a report");
    assert_eq!((report.mode, report.fault), (Mode::Fault, Some(Fault::AmplifierFault)));
    // 13: a long flash, three short ones.
    board.borrow_mut().run_for(Duration::from_millis(6000)).expect("no finding");
    let edges = board.borrow().bench().led.clone();
    let flashes: Vec<u64> =
        edges.windows(2).filter(|pair| pair[0].high).map(|pair| (pair[1].at - pair[0].at) / MILLISECOND).collect();
    let number = [500, 100, 100, 100];
    let alike = |flashes: &[u64]| flashes.iter().zip(number).all(|(flash, number)| flash.abs_diff(number) <= 1);
    assert!(flashes.windows(number.len()).any(alike), "{flashes:?} ms");
}

#[test]
fn while_the_amplifier_has_a_fault_nothing_is_driven() {
    let Some(elf) = elf() else { return };
    let mut board = powered(elf, &[]);
    board.bench_mut().fail_amplifier(Some(0));
    let (board, mut client) = connected(board);
    client.connect().expect("an answer");
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(50)), "it drives");
    let report = client.status().expect("an answer").expect("a report");
    assert_eq!(report.fault, Some(Fault::AmplifierFault), "and the trips have passed their test");
    assert_eq!(board.borrow().bench().last_driven, 0, "no code but silence");
    // Once it has gone, the board drives.
    board.borrow_mut().bench_mut().fail_amplifier(None);
    client.order(Command::ClearFault).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Run, Duration::from_millis(200)), "it locks");
}
