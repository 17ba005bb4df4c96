//! Two clients at one line, and what an earlier one has left there: one session is obeyed, and the other client is told.

use firmware::board::command::Command;
use firmware::board::link::{NO_SESSION, encode};
use firmware::seam::mode::Mode;
use link::link_error::LinkError;
use link::simulated_board::SimulatedBoard;

use super::{board, client, port, run, session};

/// Lets so many seconds of the board pass.
fn pass(board: &mut SimulatedBoard, seconds: f64) {
    (0..(seconds / board.block_s()) as u32).for_each(|_| board.block());
}

#[test]
fn a_client_whose_board_another_one_takes_is_told_and_changes_nothing() {
    let board = board("lock", &[], 4);
    let mut first = session(&board);
    run("drive", &mut first).unwrap();
    // The other one only looks.
    let mut second = session(&board);
    let error = first.client.status().unwrap_err();
    assert!(matches!(error, LinkError::Displaced { .. }) && error.is_lost(), "{error}");
    let text = error.to_string();
    assert!(text.starts_with("the board at sim obeys another session now: another client has connected since"), "{text}");
    // Nor does its order to fall silent end a drive which is no more its own; no line of a script may expect that.
    let error = run("! stop", &mut first).unwrap_err();
    assert!(matches!(error.cause(), LinkError::Displaced { .. }), "{error}");
    drop(first);
    pass(&mut board.borrow_mut(), 0.01);
    assert_eq!(second.status().unwrap().mode, Mode::Run);
    run("stop\nstatus\nexpect mode = idle", &mut second).unwrap();
    // It connects again, and the other one is told.
    let mut third = session(&board);
    run("lock\nstop", &mut third).unwrap();
    assert!(matches!(second.client.order(Command::Run).unwrap_err(), LinkError::Displaced { .. }));
    assert_eq!(third.status().unwrap().mode, Mode::Idle);
}

#[test]
fn a_board_that_was_reset_is_named_and_obeys_once_the_client_connects_again() {
    let board = board("lock", &[], 4);
    let mut client = client(port(&board));
    client.connect().unwrap();
    let before = client.session();
    client.order(Command::Run).unwrap();
    board.borrow_mut().power_cycle(|_| ());
    let error = client.order(Command::Run).unwrap_err();
    assert!(matches!(error, LinkError::Displaced { .. }) && error.to_string().contains("or the board was reset"), "{error}");
    pass(&mut board.borrow_mut(), 0.05);
    client.connect().unwrap();
    assert_ne!(client.session(), before);
    assert_eq!(client.status().unwrap().map(|report| report.mode), Some(Mode::Idle));
    client.order(Command::Run).unwrap();
}

#[test]
fn what_an_earlier_client_has_left_on_the_line_neither_acts_nor_answers() {
    let board = board("lock", &[], 4);
    let mut client = client(port(&board));
    client.connect().unwrap();
    let earlier = client.session();
    client.order(Command::TelemetryEvery(20)).unwrap();
    // A request for a session of it, and answers and telemetry that it has not read.
    board.borrow_mut().send(&encode(1, NO_SESSION, Command::Identify(5)).unwrap());
    board.borrow_mut().send(&encode(2, earlier, Command::Status).unwrap());
    pass(&mut board.borrow_mut(), 0.01);
    let mut next = super::client(port(&board));
    next.connect().unwrap();
    assert!(next.counts().late >= 2, "{:?}", next.counts());
    // What it had sent comes only now.
    board.borrow_mut().send(&encode(3, earlier, Command::Run).unwrap());
    next.order(Command::TelemetryEvery(0)).unwrap();
    next.order(Command::Patience(0.0)).unwrap();
    pass(&mut board.borrow_mut(), 0.05);
    let report = next.status().unwrap().expect("a report");
    assert_eq!((report.mode, report.fault), (Mode::Idle, None));
}

#[test]
fn a_reset_by_order_and_another_identity_keep_the_client() {
    let board = board("lock", &[], 4);
    let mut session = session(&board);
    let before = session.client.session();
    run("identify\nreset\nstatus\nidentify\nlock\nstop\nreset\nstatus\nexpect mode = idle", &mut session).unwrap();
    assert_ne!(session.client.session(), before);
}

#[test]
fn a_client_that_is_interrupted_in_its_own_reset_goes_on_in_another_session() {
    let board = board("lock", &[], 4);
    let mut client = client(port(&board));
    client.connect().unwrap();
    let before = client.session();
    client.order(Command::Patience(0.0)).unwrap();
    // The restart is not waited for.
    client.order(Command::Reset).unwrap();
    assert_eq!(client.session(), NO_SESSION);
    client.order(Command::Idle).unwrap();
    assert!(client.session() != NO_SESSION && client.session() != before);
    // A reset that is refused ends nothing.
    client.order(Command::Run).unwrap();
    let session = client.session();
    assert!(matches!(client.order(Command::Reset).unwrap_err(), LinkError::Refused { .. }));
    assert_eq!(client.session(), session);
    client.order(Command::Idle).unwrap();
}
