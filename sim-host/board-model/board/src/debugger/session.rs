//! The connection of one debugger.

use std::io::{self, Read};
use std::net::TcpStream;
use std::time::Duration;

use gdbstub::stub::state_machine::GdbStubStateMachine as Stub;
use gdbstub::stub::{GdbStub, GdbStubError, SingleThreadStopReason as Reason};

use super::target::Target;
use crate::board::BoardError;

/// How long an answer to GDB may wait for room on the wire before the session ends.
const WRITE_TIMEOUT: Duration = Duration::from_secs(1);

/// A connection, and how far the dialogue on it is.
pub(super) struct Session {
    stub: Stub<'static, Target, TcpStream>,
    /// The same connection, to be read.
    stream: TcpStream,
}

/// What has become of a session by a byte.
pub(super) enum Wire {
    /// It goes on.
    Served(Session),
    /// GDB asks for a halt.
    Interrupt(Session),
    /// GDB has detached, or killed what it debugged.
    Left,
}

/// Why a session ends before GDB leaves.
#[derive(Debug, thiserror::Error)]
pub(super) enum SessionError {
    #[error("the connection to the debugger has failed: {0}")]
    Wire(#[from] io::Error),
    #[error("the debugger has sent what cannot be answered: {0}")]
    Protocol(#[from] GdbStubError<BoardError, io::Error>),
    #[error(transparent)]
    Board(#[from] BoardError),
}

impl Session {
    pub(super) fn open(stream: TcpStream, target: &mut Target) -> Result<Self, SessionError> {
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        stream.set_nonblocking(false)?;
        let stub = GdbStub::new(stream.try_clone()?).run_state_machine(target)?;
        Ok(Session { stub, stream })
    }

    /// What has come; `None` if nothing has, 0 at the end.
    pub(super) fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        self.stream.set_nonblocking(true)?;
        let read = self.stream.read(into);
        // Answers wait for room.
        self.stream.set_nonblocking(false)?;
        match read {
            Ok(count) => Ok(Some(count)),
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Whether GDB waits for the processor to stop.
    pub(super) fn runs(&self) -> bool {
        matches!(self.stub, Stub::Running(_))
    }

    /// Takes a byte from GDB, and answers what it completes.
    pub(super) fn take(self, target: &mut Target, byte: u8) -> Result<Wire, SessionError> {
        let Session { stub, stream } = self;
        let stub = match stub {
            Stub::Idle(stub) => stub.incoming_data(target, byte)?,
            Stub::Running(stub) => stub.incoming_data(target, byte)?,
            other => other,
        };
        Ok(match stub {
            Stub::Disconnected(_) => Wire::Left,
            stub @ Stub::CtrlCInterrupt(_) => Wire::Interrupt(Session { stub, stream }),
            stub => Wire::Served(Session { stub, stream }),
        })
    }

    /// The halt that GDB has asked for was made.
    pub(super) fn interrupted(self, target: &mut Target, reason: Reason<u32>) -> Result<Self, SessionError> {
        let stub = match self.stub {
            Stub::CtrlCInterrupt(stub) => stub.interrupt_handled(target, Some(reason))?,
            other => other,
        };
        Ok(Session { stub, ..self })
    }

    /// Tells GDB, where it waits for it, why the processor has stopped.
    pub(super) fn report(self, target: &mut Target, reason: Reason<u32>) -> Result<Self, SessionError> {
        let stub = match self.stub {
            Stub::Running(stub) => stub.report_stop(target, reason)?,
            other => other,
        };
        Ok(Session { stub, ..self })
    }
}
