//! Fault output and supply of the amplifier, and the status LED that shows their faults.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use board::Board;
use firmware::board::command::{Command, Verb};
use firmware::seam::config::keys::SUPPLY_DIVIDER;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use link::client::Client;
use nucleo_g474re::blocks::{BLOCK, CYCLES_PER_SAMPLE};
use nucleo_g474re::config::SILENCE;
use stm32g474::Pin;

use super::{connected, driving, driving_with, elf, powered, reaches};

/// Processor cycles per millisecond.
const CYCLES_PER_MS: u64 = 1000 * CYCLES_PER_SAMPLE as u64;

#[test]
fn an_amplifier_fault_ends_the_drive_within_two_blocks() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = driving(elf);
    assert!(board.borrow().bench().led.last().is_some_and(|edge| edge.high), "the LED must be lit while the board drives");
    let failed = board.borrow().machine().cycle() + 1000;
    board.borrow_mut().bench_mut().fail_amplifier(Some(failed));
    board.borrow_mut().run_for(Duration::from_micros(2 * BLOCK as u64)).expect("no finding");
    assert!(!board.borrow().bench().is_enabled());
    assert_eq!(board.borrow().bench().code(), SILENCE);
    let report = client.status().expect("an answer").expect("a report");
    assert_eq!((report.mode, report.fault), (Mode::Fault, Some(Fault::AmplifierFault)));
    // Fault 13: one long flash, three short ones.
    board.borrow_mut().run_for(Duration::from_millis(6000)).expect("no finding");
    let edges = board.borrow().bench().led.clone();
    let flashes: Vec<u64> =
        edges.windows(2).filter(|pair| pair[0].high).map(|pair| (pair[1].at - pair[0].at) / CYCLES_PER_MS).collect();
    let number = [500, 100, 100, 100];
    let alike = |flashes: &[u64]| flashes.iter().zip(number).all(|(flash, number)| flash.abs_diff(number) <= 1);
    assert!(flashes.windows(number.len()).any(alike), "{flashes:?} ms");
}

#[test]
fn nothing_is_driven_during_an_amplifier_fault() {
    let Some(elf) = elf() else { return };
    let mut board = powered(elf, &[]);
    board.bench_mut().fail_amplifier(Some(0));
    let (board, mut client) = connected(board);
    client.connect().expect("an answer");
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(50)), "the board must report a fault");
    let report = client.status().expect("an answer").expect("a report");
    assert_eq!(report.fault, Some(Fault::AmplifierFault), "the trips have passed their test");
    assert_eq!(board.borrow().bench().last_driven, 0, "all codes are silence");
    // After the fault has ended, the board drives.
    board.borrow_mut().bench_mut().fail_amplifier(None);
    client.order(Command::ClearFault).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Run, Duration::from_millis(200)), "the board must lock");
}

/// Pin of the divider of the amplifier's supply.
const SUPPLY: Pin = Pin::new('B', 15);

/// Returns a board with a stored supply range of 20 to 28 V and a divider of 11, whose supply is at
/// this voltage.
fn with_supply(elf: &[u8], volts: f64) -> (Rc<RefCell<Board>>, Client) {
    let mut board = powered(elf, &[]);
    board.bench_mut().tie(0, SUPPLY, volts / 11.0);
    let (board, mut client) = connected(board);
    client.connect().expect("an answer");
    client.order(Command::Patience(0.0)).expect("acknowledged");
    let window = [(SUPPLY_DIVIDER, 11.0), (SUPPLY_DIVIDER + 1, 20.0), (SUPPLY_DIVIDER + 2, 28.0)];
    for order in window.map(|(key, value)| Verb::Set(key, value)).into_iter().chain([Verb::Store]) {
        client.order(Command::Settings(order)).expect("acknowledged");
    }
    client.order(Command::Reset).expect("acknowledged");
    client.connect().expect("an answer after the reset");
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    (board, client)
}

#[test]
fn a_supply_out_of_range_ends_the_drive_within_11_ms() {
    let Some(elf) = elf() else { return };
    for volts in [19.9, 28.1, 40.0] {
        let (board, mut client) = with_supply(elf, 24.0);
        assert!(reaches(&mut client, &board, Mode::Run, Duration::from_millis(200)), "the board must lock");
        let at = board.borrow().machine().cycle() + 1000;
        board.borrow_mut().bench_mut().tie(at, SUPPLY, volts / 11.0);
        board.borrow_mut().run_for(Duration::from_millis(11)).expect("no finding");
        assert!(!board.borrow().bench().is_enabled(), "{volts} V");
        assert_eq!(board.borrow().bench().code(), SILENCE);
        assert_eq!(client.status().expect("an answer").expect("a report").fault, Some(Fault::AmplifierSupply));
    }
}

#[test]
fn nothing_is_driven_without_the_amplifier_supply() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = with_supply(elf, 12.0);
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(50)), "the board must report a fault");
    assert_eq!(client.status().expect("an answer").expect("a report").fault, Some(Fault::AmplifierSupply));
    assert_eq!(board.borrow().bench().last_driven, 0, "all codes are silence");
}

#[test]
fn an_implausibly_hot_processor_ends_the_drive() {
    let Some(elf) = elf() else { return };
    let hot = "controller.limits.temperature_c=85";
    let strike = "fault=[{at_s=0.05,kind=\"overtemperature\"}]";
    let (board, mut client) = driving_with(elf, &[hot, strike]);
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(300)), "the board must report a fault");
    assert_eq!(client.status().expect("an answer").expect("a report").fault, Some(Fault::OverTemperature));
}
