//! Connection of a debugger.

use std::io::{self, Read};
use std::net::TcpStream;
use std::time::Duration;

use gdbstub::stub::state_machine::GdbStubStateMachine as Stub;
use gdbstub::stub::{GdbStub, GdbStubError, SingleThreadStopReason as Reason};

use super::target::Target;
use crate::board::BoardError;

/// Maximum time to send an answer to GDB before the session ends.
const WRITE_TIMEOUT: Duration = Duration::from_secs(1);

/// Connection with the state of its dialogue.
pub(super) struct Session {
    stub: Stub<'static, Target, TcpStream>,
    /// Handle of the same connection for reading.
    stream: TcpStream,
}

/// Result of a received byte.
pub(super) enum Wire {
    /// The session continues.
    Served(Session),
    /// GDB requests a halt.
    Interrupt(Session),
    /// GDB has detached, or killed the target.
    Left,
}

/// Error that ends a session.
#[derive(Debug, thiserror::Error)]
pub(super) enum SessionError {
    #[error("the connection to the debugger failed: {0}")]
    Wire(#[from] io::Error),
    #[error("protocol error of the debugger: {0}")]
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

    /// Reads bytes; `None` if there are none yet, 0 at the end of the connection.
    pub(super) fn receive(&mut self, into: &mut [u8]) -> io::Result<Option<usize>> {
        self.stream.set_nonblocking(true)?;
        let read = self.stream.read(into);
        // Answers block until they are sent.
        self.stream.set_nonblocking(false)?;
        match read {
            Ok(count) => Ok(Some(count)),
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Returns `true` while GDB waits for the processor to stop.
    pub(super) fn runs(&self) -> bool {
        matches!(self.stub, Stub::Running(_))
    }

    /// Processes a byte from GDB, and answers a packet that it completes.
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

    /// Confirms the halt that GDB has requested.
    pub(super) fn interrupted(self, target: &mut Target, reason: Reason<u32>) -> Result<Self, SessionError> {
        let stub = match self.stub {
            Stub::CtrlCInterrupt(stub) => stub.interrupt_handled(target, Some(reason))?,
            other => other,
        };
        Ok(Session { stub, ..self })
    }

    /// Reports the reason of a stop to GDB if it waits for one.
    pub(super) fn report(self, target: &mut Target, reason: Reason<u32>) -> Result<Self, SessionError> {
        let stub = match self.stub {
            Stub::Running(stub) => stub.report_stop(target, reason)?,
            other => other,
        };
        Ok(Session { stub, ..self })
    }
}
