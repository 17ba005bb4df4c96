//! Ports to a board: a stream of bytes, and the board's clock.

#[cfg(feature = "host")]
mod listed;
#[cfg(feature = "host")]
mod serial;
mod simulated;
#[cfg(feature = "host")]
mod stream;
#[cfg(feature = "host")]
mod tcp;

use std::hash::{BuildHasher, Hasher, RandomState};
use std::io;
use std::time::Duration;
#[cfg(feature = "host")]
use std::time::Instant;

#[cfg(feature = "host")]
pub use listed::listed;
#[cfg(feature = "host")]
pub use serial::Serial;
pub use simulated::{InProcess, Simulated};
#[cfg(feature = "host")]
pub use stream::Stream;
#[cfg(feature = "host")]
pub(crate) use tcp::HELD_MESSAGE;
#[cfg(feature = "host")]
pub use tcp::Tcp;

use crate::link_error::LinkError;

/// Baud rate of the board's UART, bit/s.
pub const BAUD: u32 = 921_600;

/// Stream of bytes to and from a board.
pub trait Port {
    /// Returns the name of the port, as the user gave it.
    fn name(&self) -> &str;

    /// Sends all of these bytes.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Reads received bytes, and waits up to `wait` if there are none. Returns 0 if nothing arrives
    /// in time; a lost port is an error.
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize>;

    /// Returns the time since the port was opened, by the board's clock.
    fn now(&self) -> Duration;

    /// Reopens the port after it was lost.
    fn reopen(&mut self) -> Result<(), LinkError>;

    /// Returns a number for the session that a client is about to begin, by which it recognizes the
    /// answer to its own request. If other clients may use the same board, it is random
    /// ([`chance`]). At a board in this process it depends only on the board's time, so that a
    /// dialogue is reproducible.
    fn nonce(&mut self) -> u32;

    /// Returns `true` if a lost port may be opened again. A board in this process cannot be
    /// restarted.
    fn can_reopen(&self) -> bool {
        !self.stands_still()
    }

    /// Returns `true` if the board's time stops while the client does something else.
    fn stands_still(&self) -> bool {
        false
    }
}

/// Returns a random number from the operating system.
pub fn chance() -> u32 {
    RandomState::new().build_hasher().finish() as u32
}

impl<P: Port + ?Sized> Port for Box<P> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        (**self).receive(into, wait)
    }

    fn now(&self) -> Duration {
        (**self).now()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        (**self).reopen()
    }

    fn nonce(&mut self) -> u32 {
        (**self).nonce()
    }

    fn can_reopen(&self) -> bool {
        (**self).can_reopen()
    }

    fn stands_still(&self) -> bool {
        (**self).stands_still()
    }
}

/// Returns `true` if the error only means that no byte has arrived yet.
#[cfg(feature = "host")]
fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

/// Reads until bytes arrive or `wait` is over. `read` gets the remaining time, and fails with a
/// timeout if no byte has arrived.
#[cfg(feature = "host")]
fn within(wait: Duration, mut read: impl FnMut(Duration) -> io::Result<usize>) -> io::Result<usize> {
    let until = Instant::now() + wait;
    loop {
        match read(until.saturating_duration_since(Instant::now())) {
            Ok(0) => return Err(ended()),
            Err(error) if is_timeout(&error) => std::thread::yield_now(),
            read => return read,
        }
        if Instant::now() >= until {
            return Ok(0);
        }
    }
}

/// Returns the error of a stream whose other end is closed.
#[cfg(feature = "host")]
fn ended() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, "the other end has closed the connection")
}
