//! The client against the simulated board: what it says is what the plant did, and whatever goes wrong on the way is said and nothing else.

mod client;
mod commission;
mod dialogue;
mod displaced;
#[cfg(target_os = "linux")]
mod emulated;
mod leaving;
mod settings;
mod strangers;

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;

use link::answer::Answer;
use link::client::Client;
use link::link_error::LinkError;
use link::port::{Port, Simulated};
use link::script::Script;
use link::session::{Session, SessionOptions};
use link::simulated_board::SimulatedBoard;
use scene::load::load;

/// Ctrl-C that is never pressed.
static NEVER: AtomicBool = AtomicBool::new(false);

/// The board of a scene with changes, which keeps the last blocks that went over its converters.
fn board(scene: &str, sets: &[&str], keep: usize) -> Rc<RefCell<SimulatedBoard>> {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = load(scene, &sets).unwrap_or_else(|error| panic!("{error}"));
    Rc::new(RefCell::new(SimulatedBoard::new(&loaded.scene.driven().expect("a driven scene"), keep).expect("a board")))
}

fn port(board: &Rc<RefCell<SimulatedBoard>>) -> Box<dyn Port> {
    Box::new(Simulated::new("sim", board.clone(), false))
}

fn client(port: Box<dyn Port>) -> Client {
    Client::new(port, &NEVER, |_| ())
}

fn session(board: &Rc<RefCell<SimulatedBoard>>) -> Session {
    Session::begin(client(port(board)), SessionOptions::default()).expect("a board that answers")
}

/// Does a script, and gives what each of its lines has come to.
fn run(text: &str, session: &mut Session) -> Result<Vec<(String, Answer)>, LinkError> {
    let mut answers = Vec::new();
    Script::parse("script", text)?.run(session, |line, done| {
        answers.extend(done.as_ref().ok().map(|answer| (line.text.clone(), answer.clone())));
        Ok(())
    })?;
    Ok(answers)
}
