//! The dialogue with a complete board under QEMU, over its UART.
//!
//! Skipped under the same conditions as the [processor in the loop](crate::processor_in_the_loop).

use std::cell::RefCell;
use std::io::{self, Read as _, Write as _};
use std::rc::Rc;
use std::time::{Duration, Instant};

use link::emulated_board::EmulatedBoard;
use link::link_error::LinkError;
use link::port::Port;
use link::session::{Session, SessionOptions};
use pil::link_image;
use scene::load::load;

use crate::held::{Folder, answer, client, hold, judge_captures, judge_scan, run};
use crate::processor_in_the_loop::is_there;

/// Number of recorded blocks, sufficient for a whole dialogue.
const RECORDED_BLOCKS: usize = 60_000;

/// Largest permitted stack depth during blocks, bytes; measured: 5264.
const MAX_STACK_BYTES: u32 = 6 << 10;

/// Board as a port: its time passes only while the host waits, one block at a time.
struct Emulated(Rc<RefCell<EmulatedBoard>>);

impl Port for Emulated {
    fn name(&self) -> &str {
        "QEMU"
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.borrow_mut().write_all(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let mut board = self.0.borrow_mut();
        let until = board.now() + wait;
        loop {
            let count = board.read(into)?;
            if count > 0 || board.now() >= until {
                return Ok(count);
            }
            board.block().map_err(io::Error::other)?;
        }
    }

    fn now(&self) -> Duration {
        self.0.borrow().now()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        Ok(())
    }

    fn nonce(&mut self) -> u32 {
        self.now().as_nanos() as u32
    }
}

#[test]
fn a_board_in_qemu_is_talked_to_as_one_on_a_bench() {
    if !is_there("link in the loop") {
        return;
    }
    let began = Instant::now();
    let loaded = load("lock", &[]).unwrap_or_else(|error| panic!("{error}"));
    let image = link_image().expect("the image builds");
    let board =
        EmulatedBoard::start(&image, &loaded.scene.driven().expect("a driven scene"), RECORDED_BLOCKS).expect("QEMU starts");
    let board = Rc::new(RefCell::new(board));
    let folder = Folder::new("dialogue-qemu");
    let answers = hold(Box::new(Emulated(board.clone())), &folder.0);
    let stack = board.borrow_mut().stack().expect("QEMU runs");
    let board = board.borrow();
    judge_scan(answer(&answers, "scan"), &board.rig().inner.inner.circuit());

    judge_captures(&answers, &folder.0, board.config(), board.rig().blocks());
    assert!(!board.pins().enable && !board.pins().failed && board.resets() == 0);
    // Block task and background task run one after the other; on a board, the block task interrupts
    // the background task.
    assert!((2000..MAX_STACK_BYTES).contains(&stack.stack_blocks_bytes), "{stack:?}");
    println!("{:.3} s of a dialogue in {:.2?}; {stack:?}", board.now().as_secs_f64(), began.elapsed());
}

/// Commissions the board from a band to tested settings; nothing is stored.
#[test]
fn a_board_in_qemu_is_commissioned() {
    if !is_there("link in the loop") {
        return;
    }
    let began = Instant::now();
    let loaded = load("lock", &[]).unwrap_or_else(|error| panic!("{error}"));
    let scene = loaded.scene.driven().expect("a driven scene");
    let board = EmulatedBoard::start(&link_image().expect("the image builds"), &scene, 4).expect("QEMU starts");
    let board = Rc::new(RefCell::new(board));
    let mut session = Session::begin(client(Box::new(Emulated(board.clone()))), SessionOptions::default()).expect("an answer");
    let answers = run("settings get\ncommission --band 30k:45k --max-volts 3\nsettings get", &mut session);
    let mut answers = answers.unwrap_or_else(|error| panic!("{error}"));
    let true_hz = board.borrow().rig().inner.inner.circuit().series_resonance_hz();
    for name in ["series_resonance_hz", "locked_hz", "after_step_hz", "after_burst_hz"] {
        let hz = answers[1].1.fields[name].as_f64().expect("a number");
        assert!((hz - true_hz).abs() < 1.0, "{name}: {hz} Hz instead of {true_hz} Hz");
    }
    // The number of stores is not compared.
    [0, 2].iter().for_each(|&n| assert!(answers[n].1.fields.remove("stores").is_some()));
    assert_eq!(answers[0].1.fields, answers[2].1.fields, "the settings must not change");
    session.leave().unwrap_or_else(|error| panic!("{error}"));
    let board = board.borrow();
    assert!(!board.pins().enable && !board.pins().failed);
    println!("{:.3} s of a commissioning in {:.2?}", board.now().as_secs_f64(), began.elapsed());
}
