//! A board that GDB can hold, by its remote serial protocol over TCP.
//!
//! ```text
//! GDB <-- TCP --> Session: gdbstub <--> Target: registers, memories, breakpoints <--> Board
//! ```
//!
//! At a halt the processor stands at once. The part and the plant go on for 200 us, so that what reacts to a halt is seen: the image's timer drops the
//! amplifier. Then the board's time stands, until the debugger lets it go on. After `monitor freeze on` all time stands at once, and the board does
//! not notice the halt.

mod hold;
mod registers;
mod session;
mod target;

use std::io;
use std::net::{SocketAddr, TcpListener};

use cortex_m4::BreakpointInstruction;
use gdbstub::common::Signal;
use gdbstub::stub::SingleThreadStopReason as Reason;

use crate::board::{Board, BoardError};
use session::{Session, SessionError, Wire};
use target::{Resume, Target};

/// A board with a port for GDB. One debugger at a time; the next waits until the first has gone.
pub struct Debugged {
    target: Target,
    listener: TcpListener,
    session: Option<Session>,
    /// GDB has halted the processor.
    held: bool,
    note: fn(&str),
}

impl Debugged {
    /// A board that a debugger finds at `listener`. It runs until one has come. `note` is called when one comes or goes, and with what stops the board.
    pub fn new(board: Board, listener: TcpListener, note: fn(&str)) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Debugged { target: Target::new(board), listener, session: None, held: false, note })
    }

    /// Where the debugger finds it.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// The board.
    pub fn board(&self) -> &Board {
        &self.target.board
    }

    /// The board, to be talked to.
    pub fn board_mut(&mut self) -> &mut Board {
        &mut self.target.board
    }

    /// Whether the debugger has halted the processor: the board's time stands.
    pub fn is_held(&self) -> bool {
        self.held
    }

    /// Looks after the debugger, without waiting: accepts one that comes, and does what it asks.
    pub fn attend(&mut self) -> Result<(), BoardError> {
        let Some(mut session) = self.session.take() else { return self.accept() };
        let mut bytes = [0; 1024];
        let served = match session.receive(&mut bytes) {
            Ok(Some(0)) => Ok(None),
            Ok(Some(count)) => self.serve(session, &bytes[..count]),
            Ok(None) => Ok(Some(session)),
            Err(error) => Err(error.into()),
        };
        self.keep(served)
    }

    /// Runs for the time of a block, or to a breakpoint; a held board stays where it is. A finding of the model halts the processor where a debugger is
    /// there, and is an error otherwise.
    pub fn run_block(&mut self) -> Result<(), BoardError> {
        if self.held {
            return Ok(());
        }
        let Some(session) = self.session.take() else { return self.target.board.run_block() };
        let reason = match self.target.run_block() {
            Ok(false) => {
                self.session = Some(session);
                return Ok(());
            }
            Ok(true) => Reason::SwBreak(()),
            Err(error) => self.finding(error)?,
        };
        let reported = self.halt(reason).map_err(SessionError::from).and_then(|reason| session.report(&mut self.target, reason));
        self.keep(reported.map(Some))
    }

    /// Ends the session; a board that is held runs on.
    pub fn release(&mut self) -> Result<(), BoardError> {
        if self.session.take().is_some() {
            (self.note)("the debugger is let go: the processor runs");
        }
        self.go_without()
    }

    fn accept(&mut self) -> Result<(), BoardError> {
        let Ok((stream, from)) = self.listener.accept() else { return Ok(()) };
        self.target.board.machine_mut().attach_debugger(true);
        self.halt(Reason::Signal(Signal::SIGTRAP))?;
        let opened = Session::open(stream, &mut self.target);
        if opened.is_ok() {
            (self.note)(&format!("a debugger from {from}: the processor is halted"));
        }
        self.keep(opened.map(Some))
    }

    /// Does what these bytes ask for; `None` once GDB has left.
    fn serve(&mut self, mut session: Session, bytes: &[u8]) -> Result<Option<Session>, SessionError> {
        for byte in bytes {
            session = match session.take(&mut self.target, *byte)? {
                Wire::Served(session) => session,
                Wire::Interrupt(session) => {
                    let reason = self.halt(Reason::Signal(Signal::SIGINT))?;
                    session.interrupted(&mut self.target, reason)?
                }
                Wire::Left => return Ok(None),
            };
            let resume = self.target.resume.take();
            // A Ctrl-C that came before the order answers it: the processor stays where it is.
            let Some(resume) = resume.filter(|_| session.runs()) else { continue };
            if let Some(reason) = self.resume(resume)? {
                session = session.report(&mut self.target, reason)?;
            }
        }
        Ok(Some(session))
    }

    /// Goes on, or runs one instruction; why the processor is halted again, if it is.
    fn resume(&mut self, resume: Resume) -> Result<Option<Reason<u32>>, BoardError> {
        let gone = match resume {
            Resume::Continue => self.target.go(),
            Resume::Step => self.target.step(),
        };
        match (gone, resume) {
            (Ok(()), Resume::Continue) => {
                self.held = false;
                Ok(None)
            }
            (Ok(()), Resume::Step) => Ok(Some(Reason::DoneStep)),
            (Err(error), _) => {
                let reason = self.finding(error)?;
                self.held = false;
                self.halt(reason).map(Some)
            }
        }
    }

    /// Halts the processor; why, or a finding that came with the halt.
    fn halt(&mut self, reason: Reason<u32>) -> Result<Reason<u32>, BoardError> {
        if std::mem::replace(&mut self.held, true) {
            return Ok(reason);
        }
        match self.target.halt() {
            Ok(()) => Ok(reason),
            Err(error) => self.finding(error),
        }
    }

    /// What a finding of the model is to GDB: the instruction that it names has not executed.
    fn finding(&mut self, error: BoardError) -> Result<Reason<u32>, BoardError> {
        match &error {
            BoardError::Stopped(stop) if stop.finding.is::<BreakpointInstruction>() => {
                return Ok(Reason::Signal(Signal::SIGTRAP));
            }
            BoardError::Stopped(_) => (),
            _ => return Err(error),
        }
        (self.note)(&format!("the processor is halted: {error}"));
        Ok(Reason::Signal(Signal::SIGABRT))
    }

    /// Goes on with a session, or without: the board then runs.
    fn keep(&mut self, served: Result<Option<Session>, SessionError>) -> Result<(), BoardError> {
        match served {
            Ok(Some(session)) => {
                self.session = Some(session);
                return Ok(());
            }
            Ok(None) => (self.note)("the debugger has gone: the processor runs"),
            Err(SessionError::Board(error)) => return Err(error),
            Err(error) => (self.note)(&format!("{error}; the processor runs")),
        }
        self.go_without()
    }

    /// Runs on as if no debugger had been there.
    fn go_without(&mut self) -> Result<(), BoardError> {
        self.target.forget();
        if std::mem::take(&mut self.held) { self.target.board.hold(false) } else { Ok(()) }
    }
}
