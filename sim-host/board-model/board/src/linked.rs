//! The image on the model of its microcontroller, as a board for a client and as the processor of a
//! run.
//!
//! ```text
//! scene, ELF --> board (plant at its pins) <-- serial line --> client: run --> recording --> replay: the processor of a run
//! ```
//!
//! The image is not modified: it receives its commands over its serial line. The input and output
//! of its controller are recorded, and a run on the host replays them. The same controller must
//! return the same codes to the same input, bit for bit, or the run fails. Metrics, tables and
//! files of the run are those of any other processor.

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

/// Modelled board with a debugger, which is disconnected when the client is told to end.
pub struct DebuggedBoard {
    debugged: Debugged,
    stop: &'static AtomicBool,
}

impl DebuggedBoard {
    /// Creates the board for a client; `stop` tells that client to end.
    pub fn new(debugged: Debugged, stop: &'static AtomicBool) -> Self {
        DebuggedBoard { debugged, stop }
    }

    /// Returns the board and its debugger.
    pub fn debugged(&self) -> &Debugged {
        &self.debugged
    }

    /// Returns the board and its debugger, mutable, to be run without a client.
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

/// Error of a scene's run on the image.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// Board that could not be started, or has stopped.
    #[error(transparent)]
    Board(#[from] BoardError),
    /// Missing or wrong answer of the board.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// Board that has answered, but does not drive.
    #[error("the board did not start to drive within {0:?} after the run command")]
    Idle(Duration),
    /// Board that was reset before the end.
    #[error(
        "the board was reset by {cause} before the end of the scene. Its longest block interrupt took {worst_cycles} cycles, and a \
         block has {block_cycles}{}", too_slow(*worst_cycles, *block_cycles)
    )]
    Reset {
        /// Cause of the reset.
        cause: Reset,
        /// Cycles of the longest block interrupt.
        worst_cycles: u64,
        /// Cycles of a block.
        block_cycles: u64,
    },
    /// Sample of the DAC that differs from the controller's code.
    #[error("the DAC played another code at sample {0} than the controller returned")]
    Played(usize),
    /// Difference between the answers of the host and the image.
    #[error(transparent)]
    Lost(#[from] Lost),
}

/// Returns the advice for blocks that are too long.
fn too_slow(worst: u64, block: u64) -> String {
    if worst < block { String::new() } else { format!(": use `--board-speed {}` to scale its time", worst.div_ceil(block) + 1) }
}

/// Maximum time from the run command to the first block of the scene.
const START_TIMEOUT: Duration = Duration::from_millis(100);

/// Runs a scene on an image and returns its replay.
pub fn record(elf: &[u8], scene: &Driven, options: Options, stop: &'static AtomicBool) -> Result<Replay, RecordError> {
    record_on(Board::start(elf, scene, Options { record: true, ..options })?, scene, stop)
}

/// Runs a scene on a board that was started with it and [records](Options::record). Returns its
/// replay.
pub fn record_on(board: Board, scene: &Driven, stop: &'static AtomicBool) -> Result<Replay, RecordError> {
    let board = Rc::new(RefCell::new(board));
    let mut client = Client::new(Box::new(Simulated::new("the modelled board", board.clone(), false)), stop, |_| ());
    let ordered = order(&mut client, scene);
    // After a reset the board answers late or not at all; the reset is the cause to report.
    reset(&board.borrow())?;
    ordered?;
    let ordered = board.borrow().now();
    // Drops masked times of the start, which delay no block.
    board.borrow_mut().take_load();
    let block_s = f64::from(scene.controller.block_samples) / scene.sensors.sample_hz;
    let blocks = (scene.duration_s / block_s).ceil() as usize;
    let mut later = friction_orders(scene);
    loop {
        let played = board.borrow().bench().first_block().map_or(0, |first| board.borrow().calls.len().saturating_sub(first));
        // The blocks of the run, and those in which their codes play.
        if played > blocks + LATENCY_BLOCKS || stop.load(Ordering::Relaxed) {
            break;
        }
        while let Some((_, order)) = later.pop_if(|(at_s, _)| played > 0 && *at_s <= played as f64 * block_s) {
            client.order(order)?;
        }
        let mut board = board.borrow_mut();
        board.run_block()?;
        reset(&board)?;
        if board.bench().first_block().is_none() && board.now() > ordered + START_TIMEOUT {
            return Err(RecordError::Idle(START_TIMEOUT));
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

/// Sends the run command, without a host timeout.
fn order(client: &mut Client, scene: &Driven) -> Result<(), LinkError> {
    client.connect()?;
    let detune = Hertz(scene.controller.drive.detune_hz as f32);
    let occupant = scene.dring().and_then(|dring| dring.seat_reading_kg()).map(|kg| Command::Occupant(Some(kg as f32)));
    let quadrature = scene.controller.phasing.quadrature_turns.map(|turns| Command::Quadrature(Some(Turns(turns as f32))));
    let orders = [Command::Patience(0.0), Command::Detune(detune), Command::Gate(Gate::Scheduled)];
    let orders = orders.into_iter().chain(occupant).chain(quadrature).chain([Command::Run]);
    orders.into_iter().try_for_each(|order| client.order(order))
}

/// Returns the friction ratios that a scene commands during its run, with their times, s; the last
/// one first.
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
