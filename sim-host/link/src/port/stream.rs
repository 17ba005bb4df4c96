//! Any reader and writer as a port, such as the UART of an emulated board or a test double.

use std::io::{self, Read, Write};
use std::time::{Duration, Instant};

use super::{Port, chance, within};
use crate::link_error::LinkError;

/// Port over a stream whose reads return soon: with `TimedOut` or `WouldBlock` if no byte has
/// arrived, and with zero bytes at its end.
pub struct Stream<S> {
    name: String,
    /// Stream that carries the bytes.
    pub inner: S,
    opened: Instant,
}

impl<S: Read + Write> Stream<S> {
    /// Creates a port with this name, in wall-clock time.
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
        Err(LinkError::Lost { port: self.name.clone(), why: "it cannot be reopened".into() })
    }

    fn nonce(&mut self) -> u32 {
        chance()
    }
}
