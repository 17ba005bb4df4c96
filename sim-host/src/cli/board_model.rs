//! The flashed image on the model of its microcontroller: as the board of `link board:SCENE`, and
//! as the processor of `run --board`.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;

use board::debugger::Debugged;
use board::linked::{DebuggedBoard, record};
use board::{Board, configure};
use columns::file::MAX_DATA_BYTES;
use link::files::read;
use link::link_error::LinkError;
use link::update_file::pack;
use pil::{PilError, board_image};
use scene::Driven;
use sim::processor::Processor;
use sim::run::RunError;
use update::key::DEVELOPMENT_SEED;

use super::link::{LinkArgs, STOP, listen, with_board};
use super::{Color, Exit, mistake, note};

/// Flashed image that is the processor of a run.
pub(super) struct Flashed {
    elf: Vec<u8>,
    options: board::Options,
}

impl Flashed {
    /// Reads the image, or builds it from the current source if no file is named.
    pub(super) fn new(file: Option<&Path>, scene: &Driven, speed: Option<f64>, profile: bool) -> anyhow::Result<Self> {
        configure::stored(scene).map_err(|error| mistake(Exit::Input, error.to_string()))?;
        let file = file.map_or_else(board_image, |file| Ok(file.to_owned()))?;
        let elf = read(&file, MAX_DATA_BYTES)?;
        Ok(Flashed { elf, options: board::Options { profile, ..options(speed) } })
    }

    /// Runs the scene on the image, and returns the replay.
    pub(super) fn start(&self, scene: &Driven, stop: &'static AtomicBool) -> Result<Box<dyn Processor>, RunError> {
        let replay = record(&self.elf, scene, self.options, stop).map_err(|error| RunError::NoProcessor(error.into()))?;
        Ok(Box::new(replay))
    }
}

/// Talks to the flashed image on a model of its microcontroller, with an optional port for GDB.
pub(super) fn talk(args: &LinkArgs, scene: &Driven, color: Color) -> Result<(), LinkError> {
    // A wrong address is reported before the image is built, which takes long.
    let listener = args.gdb.as_deref().map(|address| listen("the GDB port ", address, args.allow_remote)).transpose()?;
    let board = started(args, scene)?;
    let Some(listener) = listener else { return with_board(args, Rc::new(RefCell::new(board)), color) };
    let debugged = Debugged::new(board, listener, note)?;
    note(&format!("GDB connects with: target remote {}", debugged.address()?));
    with_board(args, Rc::new(RefCell::new(DebuggedBoard::new(debugged, &STOP))), color)
}

/// Starts the flashed image on a model of its microcontroller, with a scene's plant at its pins.
fn started(args: &LinkArgs, scene: &Driven) -> Result<Board, LinkError> {
    if args.slot {
        return in_slot(args, scene);
    }
    let image = match &args.image {
        Some(file) => file.clone(),
        None => {
            note("building the image from the current source (cargo fw); this takes up to minutes, unless it is up to date");
            board_image().map_err(|error| lost(args, &error))?
        }
    };
    Board::start(&read(&image, MAX_DATA_BYTES)?, scene, linked(args)).map_err(|error| LinkError::Input(error.to_string()))
}

/// Starts the first stage with the image in its slot, signed by the development key.
fn in_slot(args: &LinkArgs, scene: &Driven) -> Result<Board, LinkError> {
    let refused = |error: &dyn std::fmt::Display| LinkError::Input(error.to_string());
    note("building the first stage (cargo first-stage) and the image for its slot (cargo field), unless they are up to date");
    let [first_stage, image] = pil::field_images().map_err(|error| lost(args, &error))?;
    let elf = read(args.image.as_ref().unwrap_or(&image), MAX_DATA_BYTES)?;
    let slot = pack(&elf, Some(&DEVELOPMENT_SEED)).map_err(|error| refused(&error))?;
    note(&format!(
        "starting the first stage with an update of {} bytes, signed by the development key: it checks digest and signature \
         first, which takes a minute or more of this machine; --board-speed 8 shortens it",
        slot.len()
    ));
    Board::start_in_slot(&read(&first_stage, MAX_DATA_BYTES)?, &slot, &elf, scene, linked(args)).map_err(|error| refused(&error))
}

/// Returns the error for an image that cannot be built here.
fn lost(args: &LinkArgs, error: &PilError) -> LinkError {
    LinkError::Open { port: args.port.clone(), why: error.to_string() }
}

/// Returns the options of a board that a client is connected to.
fn linked(args: &LinkArgs) -> board::Options {
    board::Options { jumper: args.jumper, ..options(args.board_speed) }
}

fn options(speed: Option<f64>) -> board::Options {
    board::Options { rate: speed.map(|times| 1.0 / times), ..board::Options::default() }
}
