//! The unmodified flashed image on the model of its microcontroller (crates `cortex-m4`,
//! `stm32g474`, `board`), with a plant at its pins.
//!
//! Skipped, with a message, if the target's core library is not installed.

mod amplifier;
mod belt;
mod bench;
mod commission;
mod power_cut;
mod protection;
mod refusals;
mod silence;
mod start;

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use board::configure::load;
use board::linked::record;
use board::{Board, BoardError, Options};
use firmware::board::command::Command;
use firmware::seam::mode::Mode;
use link::client::Client;
use link::port::Simulated;
use nucleo_g474re::blocks::CYCLES_PER_BLOCK;
use sim::run::{Watch, run_on};

use crate::processor_in_the_loop::is_possible;

static STOP: AtomicBool = AtomicBool::new(false);

/// Returns the image, or `None` after a message if it cannot be built.
fn elf() -> Option<&'static [u8]> {
    static ELF: OnceLock<Vec<u8>> = OnceLock::new();
    if !is_possible("the flashed image on a model of its microcontroller", pil::missing_to_build()) {
        return None;
    }
    let read = || std::fs::read(pil::board_image().expect("the image builds")).expect("the image is readable");
    Some(ELF.get_or_init(read))
}

fn dummy_load() -> scene::load::Loaded {
    load("dummy-load", &[]).expect("a built-in scene")
}

/// Returns a board with the dummy load and these changes of its scene, just after power-on.
pub(crate) fn powered(elf: &[u8], changes: &[&str]) -> Board {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    let loaded = load("dummy-load", &changes).expect("a built-in scene");
    let scene = loaded.scene.driven().expect("a driven scene");
    Board::start(elf, &scene, Options::default()).expect("the board starts")
}

/// Connects a client to a board.
pub(crate) fn connected(board: Board) -> (Rc<RefCell<Board>>, Client) {
    let board = Rc::new(RefCell::new(board));
    let client = Client::new(Box::new(Simulated::new("board", board.clone(), false)), &STOP, |_| ());
    (board, client)
}

/// Returns a board that drives the dummy load, and a client that sends nothing on its own.
fn driving(elf: &[u8]) -> (Rc<RefCell<Board>>, Client) {
    driving_with(elf, &[])
}

/// Like [`driving`], with these changes of the scene.
fn driving_with(elf: &[u8], changes: &[&str]) -> (Rc<RefCell<Board>>, Client) {
    let (board, mut client) = connected(powered(elf, changes));
    client.connect().expect("an answer");
    client.order(Command::Patience(0.0)).expect("acknowledged");
    client.order(Command::Run).expect("acknowledged");
    assert!(reaches(&mut client, &board, Mode::Run, Duration::from_millis(200)), "the board must lock");
    (board, client)
}

/// Runs until the board is in a mode. Returns `false` if this takes longer than `within`.
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
fn the_image_locks_the_dummy_load_bit_for_bit() {
    let Some(elf) = elf() else { return };
    let loaded = dummy_load();
    let scene = loaded.scene.driven().expect("a driven scene");
    let mut replay = record(elf, &scene, Options::default(), &STOP).expect("the image runs the scene");
    let record = run_on(&mut replay, &scene, Watch::default()).expect("the host returns what the image returned");
    assert_eq!(record.last.fault, None);
    assert_eq!(record.last.mode, Mode::Run);
    let frequency_hz = f64::from(record.last.frequency.0);
    assert!((frequency_hz - 40_111.0).abs() < 1.0, "{frequency_hz}");
    let (instructions, cycles) = (record.instructions.expect("counted"), record.cycles.expect("counted"));
    println!("worst block: {} instructions, {} cycles of {CYCLES_PER_BLOCK}", instructions.worst, cycles.worst);
    assert!(cycles.total > instructions.total, "every instruction takes at least one cycle");
}

#[test]
fn an_unsupported_scene_is_refused_with_the_reason() {
    let Some(elf) = elf() else { return };
    let loaded = load("waveforms", &[]).expect("a built-in scene");
    let scene = loaded.scene.driven().expect("a driven scene");
    let Err(BoardError::Misfit(misfit)) = Board::start(elf, &scene, Options::default()) else { panic!("the board starts") };
    assert!(misfit.to_string().contains("block_samples"), "{misfit}");
    assert!(matches!(
        Board::start(b"nothing", &dummy_load().scene.driven().expect("driven"), Options::default()),
        Err(BoardError::Image(_))
    ));
}
