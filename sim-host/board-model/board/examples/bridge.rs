//! A modelled board with the flashed image for another program, whose time is that of the board: it
//! advances only while the program waits.
//!
//! ```text
//! cargo run --release -p sonoglide-board --example bridge -- SCENE [SCRIPT]
//! ```
//!
//! Each line of the input, `MS HEX`, sends bytes and waits up to a time for an answer. Each line of
//! the output, `MS HEX`, is the time of the board and the received bytes. With a script, the client
//! of the command line runs it instead; the output is the bytes that it has sent and received.

use std::cell::RefCell;
use std::io::{self, BufRead, Write};
use std::rc::Rc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use link::as_on_board::adapted;
use link::client::Client;
use link::link_error::LinkError;
use link::port::{Port, Simulated};
use link::script::Script;
use link::session::{Session, SessionOptions};
use pil::board_image;
use scene::load::load;
use sonoglide_board::{Board, Options};

static NEVER: AtomicBool = AtomicBool::new(false);

/// Bytes in both directions.
#[derive(Default)]
struct Dialogue {
    sent: Vec<u8>,
    received: Vec<u8>,
}

/// Port that keeps all bytes.
struct Tapped(Simulated<Board>, Rc<RefCell<Dialogue>>);

impl Port for Tapped {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.1.borrow_mut().sent.extend(bytes);
        self.0.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let count = self.0.receive(into, wait)?;
        self.1.borrow_mut().received.extend(&into[..count]);
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.0.now()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        self.0.reopen()
    }

    fn nonce(&mut self) -> u32 {
        self.0.nonce()
    }

    fn stands_still(&self) -> bool {
        self.0.stands_still()
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, script @ ..] = &arguments[..] else { return Err("expected SCENE [SCRIPT]".into()) };
    let (loaded, _) = adapted(load(name, &[])?)?;
    let scene = loaded.scene.driven().ok_or("the scene has no [controller]")?;
    let board = Board::start(&std::fs::read(board_image()?)?, &scene, Options::default())?;
    let mut port = Simulated::new("the modelled board", Rc::new(RefCell::new(board)), false);
    match script.first() {
        Some(path) => {
            let dialogue = Rc::new(RefCell::new(Dialogue::default()));
            let client = Client::new(Box::new(Tapped(port, dialogue.clone())), &NEVER, |note| eprintln!("{note}"));
            let mut session = Session::begin(client, SessionOptions::default())?;
            Script::parse(path, &std::fs::read_to_string(path)?)?.run(&mut session, |_, _| Ok(()))?;
            session.leave()?;
            let dialogue = dialogue.borrow();
            println!("{}\n{}", hex(&dialogue.sent), hex(&dialogue.received));
            Ok(())
        }
        None => serve(&mut port),
    }
}

/// Serves the board to the program at the standard input.
fn serve(port: &mut impl Port) -> Result<(), Box<dyn std::error::Error>> {
    let mut bytes = [0; 1024];
    for line in io::stdin().lock().lines() {
        let line = line?;
        let (wait_ms, sent) = line.split_once(' ').ok_or("expected MS HEX")?;
        port.send(&from_hex(sent)?)?;
        let count = port.receive(&mut bytes, Duration::from_secs_f64(1e-3 * wait_ms.parse::<f64>()?))?;
        println!("{} {}", 1e3 * port.now().as_secs_f64(), hex(&bytes[..count]));
        io::stdout().flush()?;
    }
    Ok(())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn from_hex(text: &str) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let pairs = (0..text.len()).step_by(2).map(|at| text.get(at..at + 2).ok_or("an odd number of digits".into()));
    pairs.map(|pair| pair.and_then(|pair| Ok(u8::from_str_radix(pair, 16)?))).collect()
}
