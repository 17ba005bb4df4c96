//! A bare Nucleo, with PA4 wired to the inputs of both sense channels: self-test without an
//! amplifier, captures of a start, and silicon that is refused.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use board::{Board, Options};
use firmware::board::command::Command;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use link::answer::Answer;
use link::script::Script;
use link::session::{Session, SessionOptions};
use stm32g474::Defect;

use super::{connected, dummy_load, elf, powered, reaches};

/// Runs a command as a line of a script, and returns its answer.
fn run(line: &str, session: &mut Session) -> Answer {
    let script = Script::parse("bench", line).unwrap_or_else(|error| panic!("{error}"));
    script.run(session, |_, _| Ok(())).unwrap_or_else(|error| panic!("{line}: {error}"));
    session.last.clone()
}

/// Returns a bare Nucleo after power-on, with a session.
fn bare(elf: &[u8], change: impl FnOnce(&mut Board)) -> (Rc<RefCell<Board>>, Session) {
    let loaded = dummy_load();
    let scene = loaded.scene.driven().expect("a driven scene");
    let mut board = Board::start(elf, &scene, Options { jumper: true, ..Options::default() }).expect("the board starts");
    change(&mut board);
    let (board, client) = connected(board);
    (board, Session::begin(client, SessionOptions::default()).expect("a session"))
}

fn number(answer: &Answer, field: &str) -> f64 {
    answer.fields[field].as_f64().expect("a number")
}

#[test]
fn a_wire_passes_the_selftest_and_the_enable_stays_low() {
    let Some(elf) = elf() else { return };
    let (board, mut session) = bare(elf, |_| ());
    let answer = run("selftest --clock-for 0.05", &mut session);
    assert_eq!(answer.fields["passed"], true, "{}", answer.text);
    assert_eq!((answer.fields["silicon_letter"].as_str(), answer.fields["clock"].as_str()), (Some("X"), Some("crystal")));
    assert!((number(&answer, "v_gain") - 2.0).abs() < 0.01 && number(&answer, "skew_s").abs() < 20e-9, "{}", answer.text);
    assert!(number(&answer, "worst_block_cycles") < 16_320.0, "{}", answer.text);
    assert!(board.borrow().machine().chip.wires.edges.iter().all(|edge| !edge.high), "the enable was high");
    // Afterwards the board drives again: no fault remains, and the enable is released.
    let status = run("status", &mut session);
    assert_eq!((status.fields["fault"].is_null(), &status.fields["muted"]), (true, &false.into()), "{}", status.text);
}

#[test]
fn a_sample_of_skew_fails_the_selftest() {
    let Some(elf) = elf() else { return };
    let (_board, mut session) = bare(elf, |board| board.inject(0, Defect::AdcLate { adc: 2 }));
    let answer = run("selftest --clock-for 0.05", &mut session);
    assert!((number(&answer, "skew_s") - 1e-6).abs() < 20e-9, "{}", answer.text);
    assert_eq!(answer.fields["passed"], false);
    assert!(answer.text.contains("I is not sampled with V"), "{}", answer.text);
}

/// Blocks of 100 samples are copied into an armed capture in the time that a start leaves.
#[test]
fn a_capture_of_a_start_is_in_time() {
    let Some(elf) = elf() else { return };
    let (board, client) = connected(powered(elf, &[]));
    let mut session = Session::begin(client, SessionOptions::default()).expect("a session");
    run("capture --trigger on --arm", &mut session);
    run("scan", &mut session);
    let answer = run("capture --read", &mut session);
    assert!(number(&answer, "peak_drive_v") > 1.0, "{}", answer.text);
    assert!(board.borrow().load.worst < 16_320, "{}", board.borrow().load.worst);
}

#[test]
fn refused_silicon_keeps_the_amplifier_off() {
    let Some(elf) = elf() else { return };
    let mut board = powered(elf, &[]);
    board.machine_mut().chip.config.revision = 0x2001;
    let (board, mut client) = connected(board);
    client.connect().expect("an answer");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Fault, Duration::from_millis(200)), "the order must end in a fault");
    assert_eq!(client.status().expect("an answer").and_then(|report| report.fault), Some(Fault::LoadShorted));
    assert!(board.borrow().machine().chip.wires.edges.iter().all(|edge| !edge.high), "the enable was high");
    let mut session = Session::begin(client, SessionOptions::default()).expect("a session");
    let log = run("fault log", &mut session);
    assert!(log.text.contains("silicon revision 0x2001"), "{}", log.text);
}
