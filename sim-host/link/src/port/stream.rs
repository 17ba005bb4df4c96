//! Anything that reads and writes, as a port: the UART of an emulated board, or a test's.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use super::{Port, chance, within};
use crate::link_error::LinkError;

/// A stream of bytes whose reads come back soon: with `TimedOut` or `WouldBlock` where nothing has come, and with nothing at its end.
pub struct Stream<S> {
    name: String,
    /// Stream that carries the bytes.
    pub inner: S,
    opened: Instant,
}

impl<S: Read + Write> Stream<S> {
    /// A port of this name, in wall-clock time.
    pub fn new(name: &str, inner: S) -> Self {
        Stream { name: name.to_owned(), inner, opened: Instant::now() }
    }
}

impl<S: Read + Write> Port for Stream<S> {
    fn name(&self) -> &str {
        &self.name
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.inner.write_all(bytes)?;
        self.inner.flush()
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        within(wait, |_| self.inner.read(into))
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        Err(LinkError::Lost { port: self.name.clone(), why: "it cannot be opened again".into() })
    }

    fn nonce(&mut self) -> u32 {
        chance()
    }
}
