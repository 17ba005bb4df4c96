//! A debugger halts a board that drives.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use board::linked::DebuggedBoard;
use firmware::board::command::Command;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use link::client::Client;
use link::port::{InProcess, Simulated};

use super::gdb::{Gdb, board, debugged, elf};

/// Time within which a halt drops the amplifier's enable, cycles.
const DROPS_WITHIN_CYCLES: u64 = 201 * 170;

/// Returns a board with a port for a debugger, and its client, which `stop` ends.
fn connected(elf: &[u8], stop: &'static AtomicBool) -> (Rc<RefCell<DebuggedBoard>>, Client) {
    let board = Rc::new(RefCell::new(DebuggedBoard::new(debugged(board(elf, false)), stop)));
    let mut client = Client::new(Box::new(Simulated::new("board", board.clone(), false)), stop, |_| ());
    client.connect().expect("an answer");
    (board, client)
}

/// Orders a run and waits until the board drives.
fn drive(client: &mut Client) {
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    let until = client.now() + Duration::from_millis(400);
    while client.status().expect("an answer").is_none_or(|report| report.mode != Mode::Run) {
        assert!(client.now() < until, "it does not lock");
    }
}

fn levels(board: &DebuggedBoard) -> Vec<bool> {
    board.debugged().board().bench().edges.iter().map(|edge| edge.high).collect()
}

#[test]
fn a_halt_drops_the_enable_permanently() {
    static STOP: AtomicBool = AtomicBool::new(false);
    let Some(elf) = elf() else { return };
    let (board, mut client) = connected(&elf, &STOP);
    drive(&mut client);
    assert_eq!(levels(&board.borrow()), [true], "one rise");
    let halted_at = board.borrow().debugged().board().machine().cycle();
    let mut gdb = Gdb::connect(board.borrow_mut().debugged_mut());
    let fall = *board.borrow().debugged().board().bench().edges.last().expect("an edge");
    assert!(!fall.high && fall.at < halted_at + DROPS_WITHIN_CYCLES, "{fall:?}, halted at {halted_at}");
    let stands_at = board.borrow().debugged().board().now();
    assert!(board.borrow_mut().is_held().expect("no error"));
    assert_eq!(board.borrow().debugged().board().now(), stands_at);
    assert_eq!(gdb.ask(board.borrow_mut().debugged_mut(), "D"), "OK");
    // The first report was sent during the fault-free run, probably for the block before the halt.
    let reports = [(); 2].map(|()| client.status().expect("an answer").expect("a report"));
    assert_eq!((reports[1].mode, reports[1].fault), (Mode::Fault, Some(Fault::LateBlock)), "{reports:?}");
    assert_eq!(levels(&board.borrow()), [true, false]);
}

#[test]
fn a_frozen_halt_does_not_change_the_drive() {
    static STOP: AtomicBool = AtomicBool::new(false);
    let Some(elf) = elf() else { return };
    let (board, mut client) = connected(&elf, &STOP);
    let mut gdb = Gdb::connect(board.borrow_mut().debugged_mut());
    assert!(gdb.monitor(board.borrow_mut().debugged_mut(), "freeze on").contains("all time"));
    gdb.send("c");
    drive(&mut client);
    let handler =
        board.borrow().debugged().board().machine().symbols().address("DMA1_CHANNEL1").expect("the image has a handler");
    gdb.send_raw(&[3]);
    gdb.receive(board.borrow_mut().debugged_mut()).expect("an answer");
    let mut orders = vec![format!("Z0,{handler:x},2")];
    orders.extend(["c", "s", "s", "c", "c"].map(str::to_owned));
    for order in orders {
        let reply = gdb.ask(board.borrow_mut().debugged_mut(), &order);
        assert!(reply == "OK" || reply.starts_with("T05") || reply.starts_with("S05"), "{order}: {reply}");
    }
    assert_eq!(gdb.ask(board.borrow_mut().debugged_mut(), "D"), "OK");
    let report = client.status().expect("an answer").expect("a report");
    assert_eq!((report.mode, report.fault, levels(&board.borrow())), (Mode::Run, None, vec![true]));
}

#[test]
fn a_frozen_board_plays_the_same_codes_as_without_a_debugger() {
    let Some(elf) = elf() else { return };
    let mut plain = board(&elf, true);
    let mut watched = debugged(board(&elf, true));
    for board in [&mut plain, watched.board_mut()] {
        while board.calls.len() < 100 {
            board.run_block().expect("no finding");
        }
    }
    // Both boards stop for the first halt, because time is not frozen yet.
    let mut gdb = Gdb::connect(&mut watched);
    plain.hold(true).and_then(|()| plain.settle()).and_then(|()| plain.hold(false)).expect("no finding");
    gdb.monitor(&mut watched, "freeze on");
    let handler = plain.machine().symbols().address("DMA1_CHANNEL1").expect("the image has a handler");
    assert_eq!(gdb.ask(&mut watched, &format!("Z0,{handler:x},2")), "OK");
    for _ in 0..5 {
        assert!(gdb.ask(&mut watched, "c").starts_with('T'));
    }
    assert_eq!(gdb.ask(&mut watched, "D"), "OK");
    plain.run_for(Duration::from_millis(10)).expect("no finding");
    watched.board_mut().run_for(Duration::from_millis(10)).expect("no finding");
    let calls = plain.calls.len().min(watched.board().calls.len());
    assert!(calls > 190, "{calls}");
    assert_eq!(plain.calls[..calls], watched.board().calls[..calls]);
}

#[test]
fn a_client_that_ends_releases_a_halted_board() {
    static STOP: AtomicBool = AtomicBool::new(false);
    let Some(elf) = elf() else { return };
    let (board, mut client) = connected(&elf, &STOP);
    let mut gdb = Gdb::connect(board.borrow_mut().debugged_mut());
    assert!(board.borrow_mut().is_held().expect("no error"));
    STOP.store(true, Ordering::Relaxed);
    assert!(!board.borrow_mut().is_held().expect("no error"));
    assert_eq!(gdb.receive(board.borrow_mut().debugged_mut()), None, "the session has ended");
    STOP.store(false, Ordering::Relaxed);
    client.status().expect("an answer");
}
