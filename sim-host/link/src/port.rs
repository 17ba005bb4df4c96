//! Where a board is: a stream of bytes, and the time that passes there.

mod listed;
mod serial;
mod simulated;
mod stream;
mod tcp;

use std::hash::{BuildHasher, Hasher, RandomState};
use std::io;
use std::time::{Duration, Instant};

pub use listed::listed;
pub use serial::{BAUD, Serial};
pub use simulated::{InProcess, Simulated};
pub use stream::Stream;
pub(crate) use tcp::HELD;
pub use tcp::Tcp;

use crate::link_error::LinkError;

/// Bytes to and from a board.
pub trait Port {
    /// What the user calls it.
    fn name(&self) -> &str;

    /// Sends all of these bytes.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Takes what has come, and waits up to `wait` where nothing has. Nothing in time is 0 bytes; a port that is gone is an error.
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize>;

    /// Time since the port was opened, as it passes for the board.
    fn now(&self) -> Duration;

    /// Opens it again after it was lost.
    fn reopen(&mut self) -> Result<(), LinkError>;

    /// A number for the session that a client is about to begin, by which it knows the answer to its own request. Where others may be at the same board it
    /// is drawn by [`chance`]; at a board in this process it depends on the board's time alone, so that a dialogue is the same each time.
    fn nonce(&mut self) -> u32;

    /// Whether the board's time stands still while the client does something else.
    fn stands_still(&self) -> bool {
        false
    }
}

/// A number that no other program draws, but by chance: from the operating system.
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

    fn stands_still(&self) -> bool {
        (**self).stands_still()
    }
}

/// Whether this only means that nothing has come yet.
fn is_timeout(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

/// Reads until something has come or `wait` is over; `read` returns soon, with a timeout where nothing has come, and is given the time left.
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

/// The error of a stream whose other end is closed.
fn ended() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, "the other end has closed the connection")
}
