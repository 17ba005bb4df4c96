//! A modelled board with the flashed image for another program, whose time is that of the board: it
//! advances only while the program waits.
//!
//! ```text
//! cargo run --release -p sonoglide-board --example bridge -- SCENE [SCRIPT]
//! ```
//!
//! Each line of the input, `[MS, BYTES]`, sends bytes and waits up to a time for an answer. Each
//! line of the output, `[MS, BYTES]`, is the time of the board and the received bytes. With a
//! script, the client of the command line runs it instead; the output is the bytes that it has sent
//! and received.

use std::cell::RefCell;
use std::error::Error;
use std::io::{self, BufRead};
use std::rc::Rc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use link::as_on_board::adapted;
use link::client::Client;
use link::port::{InProcess, Port, Simulated};
use link::script::Script;
use link::session::{Session, SessionOptions};
use serde_json::json;
use sonoglide_board::{Board, Options};

static NEVER: AtomicBool = AtomicBool::new(false);

/// Board whose bytes in both directions are kept.
struct Tapped {
    board: Board,
    sent: Vec<u8>,
    received: Vec<u8>,
}

impl InProcess for Tapped {
    fn send(&mut self, bytes: &[u8]) {
        self.sent.extend(bytes);
        self.board.send(bytes);
    }

    fn waiting(&self) -> usize {
        self.board.waiting()
    }

    fn receive(&mut self, into: &mut [u8]) -> usize {
        let count = self.board.receive(into);
        self.received.extend(&into[..count]);
        count
    }

    fn now(&self) -> Duration {
        self.board.now()
    }

    fn block(&mut self) -> io::Result<()> {
        self.board.block()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, script @ ..] = &arguments[..] else { return Err("expected SCENE [SCRIPT]".into()) };
    let (loaded, _) = adapted(scene::load::load(name, &[])?)?;
    let scene = loaded.scene.driven().ok_or("the scene has no [controller]")?;
    let board = Board::start(&std::fs::read(pil::board_image()?)?, &scene, Options::default())?;
    let board = Rc::new(RefCell::new(Tapped { board, sent: Vec::new(), received: Vec::new() }));
    let mut port = Simulated::new("the modelled board", board.clone(), false);
    if let Some(path) = script.first() {
        let client = Client::new(Box::new(port), &NEVER, |note| eprintln!("{note}"));
        let mut session = Session::begin(client, SessionOptions::default())?;
        Script::parse(path, &std::fs::read_to_string(path)?)?.run(&mut session, |_, _| Ok(()))?;
        session.leave()?;
        let board = board.borrow();
        println!("{}", json!([board.sent, board.received]));
        return Ok(());
    }
    let mut bytes = [0; 1024];
    for line in io::stdin().lock().lines() {
        let (wait_ms, sent): (f64, Vec<u8>) = serde_json::from_str(&line?)?;
        port.send(&sent)?;
        let count = port.receive(&mut bytes, Duration::from_secs_f64(1e-3 * wait_ms))?;
        println!("{}", json!([1e3 * port.now().as_secs_f64(), bytes[..count]]));
    }
    Ok(())
}
