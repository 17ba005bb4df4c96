//! Hosts that are slow, that leave, or that die.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use firmware::seam::fault::Fault;
use link::client::Client;
use link::link_error::LinkError;
use link::session::{Session, SessionOptions};
use link::simulated_board::SimulatedBoard;

use super::{board, client, port, run};

/// Returns `true` if the lane is silent.
fn is_silent(board: &SimulatedBoard) -> bool {
    let mid = board.config().front_end.drive_mid_code;
    board.with_rig(|rig| rig.blocks().next_back().is_some_and(|exchange| exchange.drive.lanes[0].iter().all(|&code| code == mid)))
}

#[test]
fn only_a_dead_host_is_lost() {
    let board = board("lock", &[], 4);
    let options = SessionOptions { host_timeout_s: Some(0.1), stay: false };
    let mut session = Session::begin(client(port(&board)), options).unwrap();
    // Ten times the patience of the board.
    run("drive\nwait 1\nstatus\nexpect mode = run\nexpect fault = none", &mut session).unwrap();
    assert!(!is_silent(&board.borrow()));
    // The host dies: it sends no frame when it leaves.
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
fn a_bound_replaces_a_missing_host_timeout() {
    let board = board("lock", &[], 4);
    let mut session = super::session(&board);
    run("settings set link.patience_s 0\nsettings store\nreset", &mut session).unwrap();
    session.bound_host_timeout(0.1);
    run("drive\nwait 0.3\nstatus\nexpect mode = run", &mut session).unwrap();
    std::mem::forget(session);
    let block_s = board.borrow().block_s();
    (0..(0.12 / block_s) as u32).for_each(|_| board.borrow_mut().block());
    assert!(is_silent(&board.borrow()));
}

#[test]
fn leaving_stops_the_drive_unless_stay_is_set() {
    for stay in [false, true] {
        let board = board("lock", &[], 4);
        let mut session = Session::begin(client(port(&board)), SessionOptions { host_timeout_s: None, stay }).unwrap();
        run("drive", &mut session).unwrap();
        let said = session.leave().unwrap().unwrap();
        assert_eq!(said.contains("continues"), stay, "{said}");
        (0..10_000).for_each(|_| board.borrow_mut().block());
        assert_eq!(is_silent(&board.borrow()), !stay);
        // A host that only reads does not change the drive.
        let mut session = super::session(&board);
        run("monitor --every 0.01 --for 0.05", &mut session).unwrap();
        assert_eq!(session.leave().unwrap(), None);
        drop(session);
        (0..10_000).for_each(|_| board.borrow_mut().block());
        assert_eq!(is_silent(&board.borrow()), !stay);
    }
}

#[test]
fn a_failing_program_stops_the_drive() {
    let board = board("lock", &[], 4);
    let mut session = super::session(&board);
    run("drive", &mut session).unwrap();
    assert!(!is_silent(&board.borrow()));
    drop(session);
    (0..4).for_each(|_| board.borrow_mut().block());
    assert!(is_silent(&board.borrow()));
}

#[test]
fn the_next_host_restores_the_host_timeout() {
    let board = board("lock", &[], 4);
    let mut session = super::session(&board);
    run("settings set link.patience_s 0.1\nsettings store\nreset", &mut session).unwrap();
    drop(session);
    let mut session = Session::begin(client(port(&board)), SessionOptions { host_timeout_s: None, stay: true }).unwrap();
    run("drive", &mut session).unwrap();
    session.leave().unwrap();
    drop(session);
    // The next host clears the timeout of the board, drives, and dies.
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
