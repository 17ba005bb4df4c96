//! Start of the board: its wait for orders, a reset by the watchdog, and a crystal that does not
//! start.

use std::time::Duration;

use firmware::board::command::{Command, Reply};
use firmware::board::start::Start;
use firmware::seam::mode::Mode;
use link::link_error::LinkError;
use nucleo_g474re::stack::GUARD;
use stm32g474::Defect;
use stm32g474::map::at::rcc;
use stm32g474::map::base::RCC;

use super::{connected, elf, powered, reaches};

#[test]
fn the_board_waits_for_orders() {
    let Some(elf) = elf() else { return };
    let mut board = powered(elf, &[]);
    while board.was_reset().is_none() && board.now() < Duration::from_millis(60) {
        board.run_block().expect("no finding");
    }
    let worst = u64::from(board.load.worst);
    assert!(board.was_reset().is_none() && worst < board.block_cycles(), "{worst}");
    assert!(board.bench().edges.is_empty(), "the amplifier must stay off");
}

#[test]
fn a_watchdog_reset_is_reported_to_the_client() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = connected(powered(elf, &[]));
    client.connect().expect("an answer");
    // The interrupt takes an increasing part of the time, until none remains for the task that
    // feeds the watchdog.
    for tenths in 20..50 {
        board.borrow_mut().machine_mut().set_rate(f64::from(tenths) / 10.0);
        let until = client.now() + Duration::from_millis(15);
        while board.borrow().was_reset().is_none() && client.now() < until {
            board.borrow_mut().run_block().expect("no finding");
        }
    }
    board.borrow_mut().machine_mut().set_rate(1.0);
    board.borrow_mut().run_for(Duration::from_millis(20)).expect("the board restarts");
    // The session has ended with the reset, and the client reports this.
    assert!(matches!(client.ask(Command::Faults(0)), Err(LinkError::Displaced { .. })));
    client.connect().expect("an answer");
    let answer = client.ask(Command::Faults(0)).expect("an answer");
    assert!(matches!(answer, Reply::Faults(log) if log.last_run == Start::Watchdog), "{answer:?}");
}

/// Bytes of the 48 KiB above the guard that are not zero after power-up were written by the
/// power-up.
#[test]
fn power_up_leaves_room_above_the_guard_of_the_stack() {
    /// Address of the end of SRAM2.
    const STACK_TOP: u32 = 0x2001_8000;
    /// Least unused stack, bytes.
    const MIN_FREE_BYTES: u32 = 4096;
    let Some(elf) = elf() else { return };
    let mut board = powered(elf, &[]);
    board.run_for(Duration::from_millis(60)).expect("no finding");
    let (bottom, memory) = (GUARD.end(), &board.machine().memory);
    let stack = memory.get(bottom, (STACK_TOP - bottom) as usize).expect("RAM");
    let left = stack.iter().position(|&byte| byte != 0).expect("a stack") as u32;
    println!("stack at power-up: {} of {} bytes", STACK_TOP - bottom - left, STACK_TOP - bottom);
    assert!((MIN_FREE_BYTES..STACK_TOP - bottom - 16_384).contains(&left), "{left}");
}

/// Value of RCC_PLLCFGR.PLLSRC for the internal oscillator (RM0440 7.4.4).
const HSI: u32 = 2;
/// Value of RCC_PLLCFGR.PLLSRC for the crystal.
const HSE: u32 = 3;

#[test]
fn without_crystal_the_internal_oscillator_is_used() {
    let Some(elf) = elf() else { return };
    for (dead, source) in [(false, HSE), (true, HSI)] {
        let mut board = powered(elf, &[]);
        if dead {
            board.inject(0, Defect::HseStops);
        }
        // 20 ms of waiting for the crystal, then the start.
        board.run_for(Duration::from_millis(30)).expect("no finding");
        let (board, mut client) = connected(board);
        client.connect().expect("an answer");
        client.order(Command::Patience(0.0)).expect("acknowledged");
        client.order(Command::Run).expect("acknowledged");
        assert!(reaches(&mut client, &board, Mode::Run, Duration::from_millis(200)), "the board must lock");
        let board = board.borrow();
        let chip = &board.machine().chip;
        assert_eq!((chip.peek(RCC + rcc::PLLCFGR) & 3, chip.hz()), (source, 170_000_000));
    }
}
