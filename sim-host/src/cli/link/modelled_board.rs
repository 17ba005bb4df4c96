//! `board:SCENE`: the image that is flashed, on a model of its part, with a port for a debugger where one is asked for.

use std::fs;
use std::io;
use std::net::TcpListener;

use board::Board;
use board::debugger::Debugged;
use link::link_error::LinkError;
use link::modelled_board::DebuggedBoard;
use scene::Driven;

use super::{LinkArgs, STOP, note, with_board};

/// Talks to the flashed image on a model of its part, with a port for a debugger where one is asked for.
pub(super) fn talk(args: &LinkArgs, scene: &Driven) -> Result<(), LinkError> {
    // Before the image is built.
    let listener = args.gdb.as_deref().map(debugger_port).transpose()?;
    let board = started(args, scene)?;
    let Some(listener) = listener else { return with_board(args, board) };
    let debugged = Debugged::new(board, listener, note)?;
    note(&format!("a debugger finds the board by: target remote {}", debugged.address()?));
    with_board(args, DebuggedBoard::new(debugged, &STOP))
}

fn debugger_port(address: &str) -> Result<TcpListener, LinkError> {
    TcpListener::bind(address).map_err(|error| {
        let why = match error.kind() {
            io::ErrorKind::AddrInUse => "another program listens there; port 0 takes a free one".into(),
            io::ErrorKind::InvalidInput => format!("this is no HOST:PORT: {error}"),
            _ => error.to_string(),
        };
        LinkError::Open { port: format!("the port for GDB, {address}"), why }
    })
}

/// The flashed image on a model of its part, with a scene's plant at its pins.
fn started(args: &LinkArgs, scene: &Driven) -> Result<Board, LinkError> {
    let image = match &args.image {
        Some(file) => file.clone(),
        None => pil::board_image().map_err(|error| LinkError::Usage(error.to_string()))?,
    };
    let elf = fs::read(&image).map_err(|error| LinkError::Usage(format!("{} cannot be read: {error}", image.display())))?;
    let options = board::Options { rate: args.board_speed.map(|times| 1.0 / times), ..board::Options::default() };
    Board::start(&elf, scene, options).map_err(|error| LinkError::Usage(error.to_string()))
}
