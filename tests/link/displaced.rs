//! Two clients on one line, and old bytes on it: the board obeys one session, and the other client
//! is informed.

use firmware::board::command::Command;
use firmware::board::link::{NO_SESSION, encode};
use firmware::seam::mode::Mode;
use link::link_error::LinkError;
use link::simulated_board::SimulatedBoard;

use super::{board, client, port, run, session};

/// Runs the board for this time, s.
fn pass(board: &mut SimulatedBoard, seconds: f64) {
    (0..(seconds / board.block_s()) as u32).for_each(|_| board.block());
}

#[test]
fn a_displaced_client_is_informed_and_changes_nothing() {
    let board = board("lock", &[], 4);
    let mut first = session(&board);
    run("drive", &mut first).unwrap();
    // The other client only reads.
    let mut second = session(&board);
    let error = first.client.status().unwrap_err();
    assert!(matches!(error, LinkError::Displaced { .. }) && error.is_lost(), "{error}");
    let text = error.to_string();
    assert!(text.starts_with("the board at sim obeys another session now: another client has connected since"), "{text}");
    // Its order to stop cannot end the drive of another client, and no line of a script may expect
    // this error.
    let error = run("! stop", &mut first).unwrap_err();
    assert!(matches!(error.cause(), LinkError::Displaced { .. }), "{error}");
    drop(first);
    pass(&mut board.borrow_mut(), 0.01);
    assert_eq!(second.status().unwrap().mode, Mode::Run);
    run("stop\nstatus\nexpect mode = idle", &mut second).unwrap();
    // A further client connects, and the second one is informed.
    let mut third = session(&board);
    run("lock\nstop", &mut third).unwrap();
    assert!(matches!(second.client.order(Command::Run).unwrap_err(), LinkError::Displaced { .. }));
    assert_eq!(third.status().unwrap().mode, Mode::Idle);
}

#[test]
fn a_reset_is_reported_and_a_new_session_is_obeyed() {
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
fn frames_of_an_earlier_client_have_no_effect() {
    let board = board("lock", &[], 4);
    let mut client = client(port(&board));
    client.connect().unwrap();
    let earlier = client.session();
    client.order(Command::TelemetryEvery(20)).unwrap();
    // A request of it for a session, and answers and telemetry that it has not read.
    board.borrow_mut().send(&encode(1, NO_SESSION, Command::Identify(5)).unwrap());
    board.borrow_mut().send(&encode(2, earlier, Command::Status).unwrap());
    pass(&mut board.borrow_mut(), 0.01);
    let mut next = super::client(port(&board));
    next.connect().unwrap();
    assert!(next.counts().late >= 2, "{:?}", next.counts());
    // A frame of the earlier client arrives late.
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
fn a_client_interrupted_in_a_reset_begins_a_new_session() {
    let board = board("lock", &[], 4);
    let mut client = client(port(&board));
    client.connect().unwrap();
    let before = client.session();
    client.order(Command::Patience(0.0)).unwrap();
    // The client does not wait for the restart.
    client.order(Command::Reset).unwrap();
    assert_eq!(client.session(), NO_SESSION);
    client.order(Command::Idle).unwrap();
    assert!(client.session() != NO_SESSION && client.session() != before);
    // A refused reset does not end the session.
    client.order(Command::Run).unwrap();
    let session = client.session();
    assert!(matches!(client.order(Command::Reset).unwrap_err(), LinkError::Refused { .. }));
    assert_eq!(client.session(), session);
    client.order(Command::Idle).unwrap();
}
