//! A host that is slow, that leaves, or that dies.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use firmware::seam::fault::Fault;
use link::client::Client;
use link::link_error::LinkError;
use link::session::{Session, SessionOptions};
use link::simulated_board::SimulatedBoard;

use super::{board, client, port, run};

/// What the lane plays now is silence.
fn is_silent(board: &SimulatedBoard) -> bool {
    let mid = board.config().front_end.drive_mid_code;
    board.with_rig(|rig| rig.blocks().next_back().is_some_and(|exchange| exchange.drive.lanes[0].iter().all(|&code| code == mid)))
}

#[test]
fn a_host_that_waits_is_no_loss_and_one_that_dies_is() {
    let board = board("lock", &[], 4);
    let options = SessionOptions { host_timeout_s: Some(0.1), stay: false };
    let mut session = Session::begin(client(port(&board)), options).unwrap();
    // Ten times the board's patience.
    run("drive\nwait 1\nstatus\nexpect mode = run\nexpect fault = none", &mut session).unwrap();
    assert!(!is_silent(&board.borrow()));
    // It dies: no frame says that it leaves.
    std::mem::forget(session);
    let block_s = board.borrow().block_s();
    let blocks = |seconds: f64| (0..(seconds / block_s) as u32).for_each(|_| board.borrow_mut().block());
    blocks(0.08);
    assert!(!is_silent(&board.borrow()));
    blocks(0.04);
    assert!(is_silent(&board.borrow()));
    let mut session = super::session(&board);
    assert_eq!(session.status().unwrap().fault, Some(Fault::HostLost));
    let error = run("drive", &mut session).unwrap_err().to_string();
    assert!(error.contains("fault 12, host lost"), "{error}");
    run("fault clear\nfault log\nexpect faults.0.fault = 12\ndrive --for 0.01", &mut session).unwrap();
}

#[test]
fn who_leaves_stops_the_drive_unless_it_is_to_stay() {
    for stay in [false, true] {
        let board = board("lock", &[], 4);
        let mut session = Session::begin(client(port(&board)), SessionOptions { host_timeout_s: None, stay }).unwrap();
        run("drive", &mut session).unwrap();
        let said = session.leave().unwrap().unwrap();
        assert_eq!(said.contains("goes on"), stay, "{said}");
        (0..10_000).for_each(|_| board.borrow_mut().block());
        assert_eq!(is_silent(&board.borrow()), !stay);
        // Who only looks leaves it as it is.
        let mut session = super::session(&board);
        run("monitor --every 0.01 --for 0.05", &mut session).unwrap();
        assert_eq!(session.leave().unwrap(), None);
        drop(session);
        (0..10_000).for_each(|_| board.borrow_mut().block());
        assert_eq!(is_silent(&board.borrow()), !stay);
    }
}

#[test]
fn a_program_that_fails_leaves_no_drive_behind() {
    let board = board("lock", &[], 4);
    let mut session = super::session(&board);
    run("drive", &mut session).unwrap();
    assert!(!is_silent(&board.borrow()));
    drop(session);
    (0..4).for_each(|_| board.borrow_mut().block());
    assert!(is_silent(&board.borrow()));
}

#[test]
fn a_drive_left_on_has_its_timeout_again_under_the_next_host() {
    let board = board("lock", &[], 4);
    let mut session = super::session(&board);
    run("settings set link.patience_s 0.1\nsettings store\nreset", &mut session).unwrap();
    drop(session);
    let mut session = Session::begin(client(port(&board)), SessionOptions { host_timeout_s: None, stay: true }).unwrap();
    run("drive", &mut session).unwrap();
    session.leave().unwrap();
    drop(session);
    // The next host finds a board without a host timeout, drives, and dies.
    let mut session = super::session(&board);
    run("drive", &mut session).unwrap();
    std::mem::forget(session);
    (0..10_000).for_each(|_| board.borrow_mut().block());
    assert!(is_silent(&board.borrow()));
}

#[test]
fn ctrl_c_ends_a_wait_and_the_drive() {
    static STOP: AtomicBool = AtomicBool::new(false);
    let board = board("lock", &[], 4);
    let client = Client::new(port(&board), &STOP, |_| ());
    let mut session = Session::begin(client, SessionOptions::default()).unwrap();
    run("drive", &mut session).unwrap();
    let mut reports = 0;
    let error = session.watch(Duration::from_secs(100), 1, |_| {
        reports += 1;
        STOP.store(reports == 3, Ordering::Relaxed);
        None::<()>
    });
    assert!(matches!(error, Err(LinkError::Interrupted)) && reports == 3, "{reports}");
    assert_eq!(session.leave().unwrap(), Some("the drive is silent now"));
    (0..4).for_each(|_| board.borrow_mut().block());
    assert!(is_silent(&board.borrow()));
}
