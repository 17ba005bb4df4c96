//! The image that is flashed, unmodified, on the model of its part (crates `cortex-m4`, `stm32g474`, `board`), with a plant at its pins.
//!
//! The block interrupt of this image takes longer than a block, so that at the part's own speed its watchdog resets it. Wherever a test drives, the
//! interrupt takes an eighth of its time.
//!
//! Skipped, with a message, where the target's core library is not installed.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use board::{Board, BoardError, Options};
use firmware::board::command::{Command, Reply, Verb};
use firmware::board::start::Start;
use firmware::board::stored_state::StoredState;
use firmware::seam::fault::Fault;
use firmware::seam::mode::Mode;
use link::client::Client;
use link::modelled_board::record;
use link::port::Simulated;
use scene::load::load;
use sim::run::{Watch, run_on};

use crate::processor_in_the_loop::is_possible;

/// The part of its time that the block interrupt takes here.
const RATE: f64 = 1.0 / 8.0;
static STOP: AtomicBool = AtomicBool::new(false);

/// The image; none where it cannot be built, which has then been said.
fn elf() -> Option<&'static [u8]> {
    static ELF: OnceLock<Vec<u8>> = OnceLock::new();
    if !is_possible("the flashed image on a model of its part", pil::missing_to_build()) {
        return None;
    }
    let read = || std::fs::read(pil::board_image().expect("the image builds")).expect("it can be read");
    Some(ELF.get_or_init(read))
}

fn dummy_load() -> scene::load::Loaded {
    load("dummy-load", &[]).expect("a built-in scene")
}

/// A board with the dummy load that was just powered, and a client of it.
fn board(elf: &[u8], rate: f64) -> (Rc<RefCell<Board>>, Client) {
    let loaded = dummy_load();
    let scene = loaded.scene.driven().expect("a driven scene");
    let board = Board::start(elf, &scene, Options { rate: Some(rate), record: false }).expect("it starts");
    let board = Rc::new(RefCell::new(board));
    let client = Client::new(Box::new(Simulated::new("board", board.clone(), false)), &STOP, |_| ());
    (board, client)
}

/// Runs until the board is in a mode, at most `within`.
fn reaches(client: &mut Client, board: &Rc<RefCell<Board>>, mode: Mode, within: Duration) -> bool {
    let until = client.now() + within;
    while client.now() < until {
        if client.status().expect("an answer").is_some_and(|report| report.mode == mode) {
            return true;
        }
        board.borrow_mut().run_for(Duration::from_millis(1)).expect("no finding");
    }
    false
}

#[test]
fn the_image_finds_and_locks_the_dummy_load_bit_for_bit() {
    let Some(elf) = elf() else { return };
    let loaded = dummy_load();
    let scene = loaded.scene.driven().expect("a driven scene");
    let mut replay = record(elf, &scene, Some(RATE), &STOP).expect("the image runs the scene");
    let record = run_on(&mut replay, &scene, Watch::default()).expect("the host returns what the image returned");
    assert_eq!(record.last.fault, None);
    assert_eq!(record.last.mode, Mode::Run);
    let frequency_hz = f64::from(record.last.frequency.0);
    assert!((frequency_hz - 40_111.0).abs() < 1.0, "{frequency_hz}");
    let (instructions, cycles) = (record.instructions.expect("counted"), record.cycles.expect("counted"));
    println!("worst block: {} instructions, {} cycles of 5440", instructions.worst, cycles.worst);
    assert!(cycles.total > instructions.total, "no instruction takes less than a cycle");
}

#[test]
fn blocks_that_are_too_long_end_in_the_watchdog() {
    let Some(elf) = elf() else { return };
    let (board, _) = board(elf, 1.0);
    let mut board = board.borrow_mut();
    while board.was_reset().is_none() && board.now() < Duration::from_millis(60) {
        board.run_block().expect("no finding");
    }
    let worst = u64::from(board.load.worst);
    assert_eq!(
        board.was_reset().map(|reset| reset.to_string()).as_deref(),
        (worst > board.block_cycles()).then_some("the independent watchdog"),
        "{worst}"
    );
    assert!(board.bench().edges.is_empty(), "the amplifier stays off");
}

#[test]
fn the_watchdogs_reset_is_told_to_the_client() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = board(elf, RATE);
    client.connect().expect("an answer");
    // From here on the interrupt takes its own time, and blocks are missed.
    board.borrow_mut().machine_mut().set_rate(4.0);
    while board.borrow().was_reset().is_none() && client.now() < Duration::from_millis(200) {
        board.borrow_mut().run_block().expect("no finding");
    }
    board.borrow_mut().machine_mut().set_rate(RATE);
    board.borrow_mut().run_for(Duration::from_millis(20)).expect("it starts again");
    let answer = client.ask(Command::Faults(0)).expect("an answer");
    assert!(matches!(answer, Reply::Faults(log) if log.last_run == Start::Watchdog), "{answer:?}");
}

#[test]
fn the_emergency_stop_drops_the_enable_at_once() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = board(elf, RATE);
    client.connect().expect("an answer");
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Run, Duration::from_millis(200)), "it locks");
    assert_eq!(
        board.borrow().bench().edges.iter().map(|edge| edge.high).collect::<Vec<_>>(),
        [true],
        "one rise, and no stray pulse"
    );
    let pressed = board.borrow().machine().cycle();
    board.borrow_mut().bench_mut().press_stop(pressed);
    board.borrow_mut().run_for(Duration::from_millis(2)).expect("no finding");
    let edges = board.borrow().bench().edges.clone();
    let fall = edges.last().expect("an edge");
    assert!(!fall.high && fall.at - pressed < 170, "{edges:?}, pressed at {pressed}");
    let report = client.status().expect("an answer").expect("a report");
    assert_eq!((report.mode, report.fault), (Mode::Fault, Some(Fault::EmergencyStop)));
}

#[test]
fn settings_are_stored_in_the_flash_and_are_there_after_a_reset() {
    let Some(elf) = elf() else { return };
    let (board, mut client) = board(elf, RATE);
    client.connect().expect("an answer");
    /// `tracking.nominal_q`.
    const KEY: u8 = 15;
    let get = |client: &mut Client| match client.ask(Command::Settings(Verb::Get(KEY))).expect("an answer") {
        Reply::Parameter(report) => report,
        reply => panic!("{reply:?}"),
    };
    let before = get(&mut client);
    let lower = 0.5 * before.acts;
    client.order(Command::Settings(Verb::Set(KEY, lower))).expect("acknowledged");
    client.order(Command::Settings(Verb::Store)).expect("acknowledged");
    client.order(Command::Reset).expect("acknowledged");
    board.borrow_mut().run_for(Duration::from_millis(40)).expect("it starts again");
    let after = get(&mut client);
    assert_eq!((after.acts, after.stored), (lower, StoredState::Stored));
    assert_eq!(board.borrow().was_reset().map(|reset| reset.to_string()).as_deref(), Some("software"));
}

#[test]
fn a_scene_that_the_image_cannot_do_is_refused_by_name() {
    let Some(elf) = elf() else { return };
    let loaded = load("usm", &[]).expect("a built-in scene");
    let scene = loaded.scene.driven().expect("a driven scene");
    let Err(BoardError::Misfit(misfit)) = Board::start(elf, &scene, Options::default()) else { panic!("it starts") };
    assert!(misfit.to_string().contains("lanes"), "{misfit}");
    assert!(matches!(
        Board::start(b"nothing", &dummy_load().scene.driven().expect("driven"), Options::default()),
        Err(BoardError::Image(_))
    ));
}
