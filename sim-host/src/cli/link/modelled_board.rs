//! `board:SCENE`: the image that is flashed, on a model of its part, with a port for a debugger where one is asked for.

use std::cell::RefCell;
use std::fs;
use std::path::Path;
use std::rc::Rc;

use board::Board;
use board::debugger::Debugged;
use board::update_file::pack;
use link::link_error::LinkError;
use link::modelled_board::DebuggedBoard;
use scene::Driven;
use update::key::DEVELOPMENT_SEED;

use super::{Color, LinkArgs, STOP, listen, note, with_board};

/// Talks to the flashed image on a model of its part, with a port for a debugger where one is asked for.
pub(super) fn talk(args: &LinkArgs, scene: &Driven, color: Color) -> Result<(), LinkError> {
    // Before the image is built.
    let listener = args.gdb.as_deref().map(|address| listen("the port for GDB, ", address, args.allow_remote)).transpose()?;
    let board = started(args, scene)?;
    let Some(listener) = listener else { return with_board(args, Rc::new(RefCell::new(board)), color) };
    let debugged = Debugged::new(board, listener, note)?;
    note(&format!("a debugger finds the board by: target remote {}", debugged.address()?));
    with_board(args, Rc::new(RefCell::new(DebuggedBoard::new(debugged, &STOP))), color)
}

/// The flashed image on a model of its part, with a scene's plant at its pins.
fn started(args: &LinkArgs, scene: &Driven) -> Result<Board, LinkError> {
    if args.slot {
        return in_slot(args, scene);
    }
    let image = match &args.image {
        Some(file) => file.clone(),
        None => pil::board_image().map_err(|error| lost(args, &error))?,
    };
    Board::start(&read(&image)?, scene, options(args)).map_err(|error| LinkError::Input(error.to_string()))
}

/// The same behind the first stage, signed by the development key.
fn in_slot(args: &LinkArgs, scene: &Driven) -> Result<Board, LinkError> {
    let refused = |error: &dyn std::fmt::Display| LinkError::Input(error.to_string());
    let [first_stage, image] = pil::field_images().map_err(|error| lost(args, &error))?;
    let elf = read(args.image.as_ref().unwrap_or(&image))?;
    let slot = pack(&elf, Some(&DEVELOPMENT_SEED)).map_err(|error| refused(&error))?;
    Board::start_in_slot(&read(&first_stage)?, &slot, &elf, scene, options(args)).map_err(|error| refused(&error))
}

/// The error for an image that cannot be built here.
fn lost(args: &LinkArgs, error: &pil::PilError) -> LinkError {
    LinkError::Open { port: args.port.clone(), why: error.to_string() }
}

fn read(file: &Path) -> Result<Vec<u8>, LinkError> {
    fs::read(file).map_err(|error| LinkError::Input(format!("{} cannot be read: {error}", file.display())))
}

fn options(args: &LinkArgs) -> board::Options {
    board::Options { rate: args.board_speed.map(|times| 1.0 / times), ..board::Options::default() }
}
