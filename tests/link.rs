//! The client and the simulated board: reported values agree with the plant, and every failure is
//! reported.

mod client;
mod commission;
mod dialogue;
mod displaced;
mod held;
mod leaving;
mod settings;
mod strangers;

use std::cell::RefCell;
use std::rc::Rc;

use link::port::{Port, Simulated};
use link::session::{Session, SessionOptions};
use link::simulated_board::SimulatedBoard;
use scene::load::load;

use self::held::{client, run};

/// Returns the board of a scene with changes, which records the last blocks at its converters.
fn board(scene: &str, sets: &[&str], keep: usize) -> Rc<RefCell<SimulatedBoard>> {
    let sets: Vec<String> = sets.iter().map(|&set| set.to_owned()).collect();
    let loaded = load(scene, &sets).unwrap_or_else(|error| panic!("{error}"));
    Rc::new(RefCell::new(SimulatedBoard::new(&loaded.scene.driven().expect("a driven scene"), keep).expect("a board")))
}

fn port(board: &Rc<RefCell<SimulatedBoard>>) -> Box<dyn Port> {
    Box::new(Simulated::new("sim", board.clone(), false))
}

fn session(board: &Rc<RefCell<SimulatedBoard>>) -> Session {
    Session::begin(client(port(board)), SessionOptions::default()).expect("a board that answers")
}
