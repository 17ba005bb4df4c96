//! The flashed image on the model of its part, as a board that the client talks to, and as a processor that runs a scene.
//!
//! ```text
//! scene, ELF --> board (plant at its pins) <-- serial line --> client: run --> recording --> replay: the processor of a run
//! ```
//!
//! The image is not changed and not observed by itself: it receives its orders over its serial line. What it has seen and answered is recorded, and a
//! run on the host replays it: the same controller returns the same codes to the same input, bit for bit, or the run fails. The rest of the
//! run (metrics, tables, files) is that of any other processor.

use std::cell::RefCell;
use std::io;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use firmware::board::command::Command;
use firmware::seam::block::{Gate, LATENCY_BLOCKS, Target};
use firmware::seam::units::{Hertz, Turns};
use scene::Driven;
use sim::processor::Lost;

use link::client::Client;
use link::link_error::LinkError;
use link::port::{InProcess, Simulated};

use crate::debugger::Debugged;
use crate::recording::{Replay, compare};
use crate::{Board, BoardError, Options, Reset};

impl InProcess for Board {
    fn send(&mut self, bytes: &[u8]) {
        Board::send(self, bytes);
    }

    fn waiting(&self) -> usize {
        self.bench().to_board.len()
    }

    fn receive(&mut self, into: &mut [u8]) -> usize {
        Board::receive(self, into)
    }

    fn now(&self) -> Duration {
        Board::now(self)
    }

    fn block(&mut self) -> io::Result<()> {
        Board::run_block(self).map_err(io::Error::other)
    }
}

/// A modelled board that a debugger can hold. It is let go when the client is asked to end.
pub struct DebuggedBoard {
    debugged: Debugged,
    stop: &'static AtomicBool,
}

impl DebuggedBoard {
    /// The board as a client meets it; `stop` asks that client to end.
    pub fn new(debugged: Debugged, stop: &'static AtomicBool) -> Self {
        DebuggedBoard { debugged, stop }
    }

    /// The board and its debugger.
    pub fn debugged(&self) -> &Debugged {
        &self.debugged
    }

    /// The board and its debugger, to be run by another than a client.
    pub fn debugged_mut(&mut self) -> &mut Debugged {
        &mut self.debugged
    }
}

impl InProcess for DebuggedBoard {
    fn send(&mut self, bytes: &[u8]) {
        self.debugged.board_mut().send(bytes);
    }

    fn waiting(&self) -> usize {
        InProcess::waiting(self.debugged.board())
    }

    fn receive(&mut self, into: &mut [u8]) -> usize {
        self.debugged.board_mut().receive(into)
    }

    fn now(&self) -> Duration {
        self.debugged.board().now()
    }

    fn block(&mut self) -> io::Result<()> {
        self.debugged.run_block().map_err(io::Error::other)
    }

    fn is_held(&mut self) -> io::Result<bool> {
        let looked = if self.stop.load(Ordering::Relaxed) { self.debugged.release() } else { self.debugged.attend() };
        looked.map_err(io::Error::other)?;
        Ok(self.debugged.is_held())
    }
}

/// Why a scene could not be run on the image.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The board could not be started, or has stopped.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// It does not answer as it should.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// It has answered, and never began to drive.
    #[error("the board was ordered to run, and had not begun after {0:?}")]
    Idle(Duration),
    /// It was reset on the way.
    #[error(
        "the board was reset by {cause} before the scene had ended. Its longest block interrupt took {worst_cycles} cycles, and a block has \
         {block_cycles}{}", too_slow(*worst_cycles, *block_cycles)
    )]
    Reset {
        /// What has reset it.
        cause: Reset,
        /// Cycles of its longest block interrupt.
        worst_cycles: u64,
        /// Cycles of a block.
        block_cycles: u64,
    },
    /// Something else than its controller's codes left the DAC.
    #[error("sample {0} that left the DAC is not the code that the controller returned for it")]
    Played(usize),
    /// The host does not return what the image returned.
    #[error(transparent)]
    Lost(#[from] Lost),
}

/// What to do about blocks that are too long.
fn too_slow(worst: u64, block: u64) -> String {
    if worst < block {
        String::new()
    } else {
        format!(": `--board-speed {}` lets it take that part of its time", worst.div_ceil(block) + 1)
    }
}

/// The longest that a board may take from its first order to its first block of it.
const BEGINS_WITHIN: Duration = Duration::from_millis(100);

/// Runs a scene on an image, and gives its replay.
pub fn record(elf: &[u8], scene: &Driven, options: Options, stop: &'static AtomicBool) -> Result<Replay, RecordError> {
    record_on(Board::start(elf, scene, Options { record: true, ..options })?, scene, stop)
}

/// Runs a scene on a board that was started with it, and [records](Options::record), and gives its replay.
pub fn record_on(board: Board, scene: &Driven, stop: &'static AtomicBool) -> Result<Replay, RecordError> {
    let board = Rc::new(RefCell::new(board));
    let mut client = Client::new(Box::new(Simulated::new("the modelled board", board.clone(), false)), stop, |_| ());
    let ordered = order(&mut client, scene);
    // A board that is reset answers too late, or not at all: the reset is the cause.
    reset(&board.borrow())?;
    ordered?;
    let ordered = board.borrow().now();
    // What is masked while it starts delays no block.
    board.borrow_mut().take_load();
    let block_s = f64::from(scene.controller.block_samples) / scene.sensors.sample_hz;
    let blocks = (scene.duration_s / block_s).ceil() as usize;
    let mut later = friction_orders(scene);
    loop {
        let played = board.borrow().bench().first_block().map_or(0, |first| board.borrow().calls.len().saturating_sub(first));
        // Those that the run asks for, and those in which their codes play.
        if played > blocks + LATENCY_BLOCKS || stop.load(Ordering::Relaxed) {
            break;
        }
        while let Some((_, order)) = later.pop_if(|(at_s, _)| played > 0 && *at_s <= played as f64 * block_s) {
            client.order(order)?;
        }
        let mut board = board.borrow_mut();
        board.run_block()?;
        reset(&board)?;
        if board.bench().first_block().is_none() && board.now() > ordered + BEGINS_WITHIN {
            return Err(RecordError::Idle(BEGINS_WITHIN));
        }
    }
    let mut board = board.borrow_mut();
    let mut calls = std::mem::take(&mut board.calls);
    if let Some(sample) = compare(&mut calls, board.bench().codes.as_deref().unwrap_or(&[])) {
        return Err(RecordError::Played(sample));
    }
    let load = board.take_load();
    let cut = board.bench().first_lost.map(|sample| (sample / usize::from(scene.controller.block_samples)) as u64);
    Ok(Replay::new(board.config(), calls, board.bench().first_block().unwrap_or(0), load, cut)?)
}

/// Orders the board to run, without a host timeout.
fn order(client: &mut Client, scene: &Driven) -> Result<(), LinkError> {
    client.connect()?;
    let detune = Hertz(scene.controller.drive.detune_hz as f32);
    let occupant = scene.dring().and_then(|dring| dring.seat_reading_kg()).map(|kg| Command::Occupant(Some(kg as f32)));
    let quadrature = scene.controller.phasing.quadrature_turns.map(|turns| Command::Quadrature(Some(Turns(turns as f32))));
    let orders = [Command::Patience(0.0), Command::Detune(detune), Command::Gate(Gate::Scheduled)];
    let orders = orders.into_iter().chain(occupant).chain(quadrature).chain([Command::Run]);
    orders.into_iter().try_for_each(|order| client.order(order))
}

/// Friction ratios that a scene orders while it runs, and when, s; the last one first.
fn friction_orders(scene: &Driven) -> Vec<(f64, Command)> {
    let friction = scene.controller.friction.iter();
    let steps = friction.flat_map(|friction| friction.step_s.iter().zip(&friction.step_ratio).rev());
    steps.map(|(at_s, ratio)| (*at_s, Command::Friction(Some(Target::Ratio(*ratio as f32))))).collect()
}

fn reset(board: &Board) -> Result<(), RecordError> {
    let worst_cycles = board.load.worst.into();
    let cause = board.was_reset();
    cause.map_or(Ok(()), |cause| Err(RecordError::Reset { cause, worst_cycles, block_cycles: board.block_cycles() }))
}
