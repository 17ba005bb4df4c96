//! Board under a debugger: GDB's remote serial protocol over TCP.
//!
//! ```text
//! GDB <-- TCP --> Session: gdbstub <--> Target: registers, memories, breakpoints <--> Board
//! ```
//!
//! A halt stops the processor at once. Chip and plant continue for 200 us, so that reactions to the
//! halt occur: the image's timer switches the amplifier off. Then the board's time stops until the
//! debugger resumes it. After `monitor freeze on` all time stops at once, and the board does not
//! notice the halt.

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

/// Board with a port for GDB. It serves one debugger at a time; the next one waits.
pub struct Debugged {
    target: Target,
    listener: TcpListener,
    session: Option<Session>,
    /// `true` if GDB has halted the processor.
    held: bool,
    note: fn(&str),
}

impl Debugged {
    /// Creates a board that listens for a debugger at `listener`, and runs until one connects.
    ///
    /// `note` receives messages about connections and about errors that stop the board.
    pub fn new(board: Board, listener: TcpListener, note: fn(&str)) -> io::Result<Self> {
        listener.set_nonblocking(true)?;
        Ok(Debugged { target: Target::new(board), listener, session: None, held: false, note })
    }

    /// Returns the address for the debugger.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Returns the board.
    pub fn board(&self) -> &Board {
        &self.target.board
    }

    /// Returns the board, mutable.
    pub fn board_mut(&mut self) -> &mut Board {
        &mut self.target.board
    }

    /// Returns `true` if the debugger has halted the processor, which stops the board's time.
    pub fn is_held(&self) -> bool {
        self.held
    }

    /// Accepts a debugger or executes its commands, without waiting.
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

    /// Runs for the duration of a block, or to a breakpoint; does nothing while halted. A finding
    /// of the model halts the processor if a debugger is connected, and is an error otherwise.
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

    /// Ends the session and resumes a halted board.
    pub fn release(&mut self) -> Result<(), BoardError> {
        if self.session.take().is_some() {
            (self.note)("debugger disconnected: the processor runs");
        }
        self.go_without()
    }

    fn accept(&mut self) -> Result<(), BoardError> {
        let Ok((stream, from)) = self.listener.accept() else { return Ok(()) };
        self.target.board.machine_mut().attach_debugger(true);
        self.halt(Reason::Signal(Signal::SIGTRAP))?;
        let opened = Session::open(stream, &mut self.target);
        if opened.is_ok() {
            (self.note)(&format!("debugger connected from {from}: the processor is halted"));
        }
        self.keep(opened.map(Some))
    }

    /// Executes the commands in these bytes; `None` after GDB has left.
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
            // An earlier Ctrl-C has answered the command already: the processor stays halted.
            let Some(resume) = resume.filter(|_| session.runs()) else { continue };
            if let Some(reason) = self.resume(resume)? {
                session = session.report(&mut self.target, reason)?;
            }
        }
        Ok(Some(session))
    }

    /// Resumes the processor or runs one instruction. Returns the reason if it is halted again.
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

    /// Halts the processor. Returns `reason`, or that of a finding during the halt.
    fn halt(&mut self, reason: Reason<u32>) -> Result<Reason<u32>, BoardError> {
        if std::mem::replace(&mut self.held, true) {
            return Ok(reason);
        }
        match self.target.halt() {
            Ok(()) => Ok(reason),
            Err(error) => self.finding(error),
        }
    }

    /// Converts a finding of the model to a stop reason. The instruction of the finding has not
    /// executed.
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

    /// Continues with a session, or without one, in which case the board runs.
    fn keep(&mut self, served: Result<Option<Session>, SessionError>) -> Result<(), BoardError> {
        match served {
            Ok(Some(session)) => {
                self.session = Some(session);
                return Ok(());
            }
            Ok(None) => (self.note)("debugger disconnected: the processor runs"),
            Err(SessionError::Board(error)) => return Err(error),
            Err(error) => (self.note)(&format!("{error}; the processor runs")),
        }
        self.go_without()
    }

    /// Continues as if no debugger had been connected.
    fn go_without(&mut self) -> Result<(), BoardError> {
        self.target.detach();
        if std::mem::take(&mut self.held) { self.target.board.hold(false) } else { Ok(()) }
    }
}
