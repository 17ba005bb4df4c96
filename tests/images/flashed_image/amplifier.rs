//! The amplifier's fault output and its supply, and the status LED that tells of them.

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

/// The pin of the supply's divider.
const SUPPLY: Pin = Pin::new('B', 15);

/// A board that has stored a window of 20 to 28 V behind 1 to 11, whose supply is at so many volts.
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
fn a_supply_that_leaves_its_window_ends_the_drive_within_eleven_milliseconds() {
    let Some(elf) = elf() else { return };
    for volts in [19.9, 28.1, 40.0] {
        let (board, mut client) = with_supply(elf, 24.0);
        assert!(reaches(&mut client, &board, Mode::Run, Duration::from_millis(200)), "it locks");
        let at = board.borrow().machine().cycle() + 1000;
        board.borrow_mut().bench_mut().tie(at, SUPPLY, volts / 11.0);
        board.borrow_mut().run_for(Duration::from_millis(11)).expect("no finding");
        assert!(!board.borrow().bench().is_enabled(), "{volts} V");
        assert_eq!(board.borrow().bench().code(), SILENCE);
        assert_eq!(client.status().expect("an answer").expect("a report").fault, Some(Fault::AmplifierSupply));
    }
}

#[test]
fn without_its_supply_nothing_is_driven() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = with_supply(elf, 12.0);
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(50)), "it drives");
    assert_eq!(client.status().expect("an answer").expect("a report").fault, Some(Fault::AmplifierSupply));
    assert_eq!(board.borrow().bench().last_driven, 0, "no code but silence");
}

#[test]
fn a_die_that_is_too_hot_to_be_read_ends_the_drive() {
    let Some(elf) = elf() else { return };
    let hot = "controller.limits.temperature_c=85";
    let strike = "fault=[{at_s=0.05,kind=\"overtemperature\"}]";
    let (board, mut client) = driving_with(elf, &[hot, strike]);
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(300)), "it drives on");
    assert_eq!(client.status().expect("an answer").expect("a report").fault, Some(Fault::OverTemperature));
}
