//! Port that hashes all bytes, to show that a page and the command line have the same dialogue.

use std::cell::Cell;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use link::link_error::LinkError;
use link::port::Port;

/// Offset and prime of the 64-bit hash FNV-1a.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0000_0100_0000_01b3;

/// Hashes of the bytes in both directions.
#[derive(Clone, Debug)]
pub struct Hashes {
    sent: Rc<Cell<u64>>,
    received: Rc<Cell<u64>>,
}

impl Hashes {
    /// Returns both hashes as text.
    pub fn text(&self) -> String {
        format!("{:016x} {:016x}", self.sent.get(), self.received.get())
    }
}

/// Port whose bytes are hashed.
pub struct Tapped {
    port: Box<dyn Port>,
    hashes: Hashes,
}

impl Tapped {
    /// Creates the port, and the hashes of its bytes.
    pub fn new(port: Box<dyn Port>) -> (Self, Hashes) {
        let start = || Rc::new(Cell::new(FNV_OFFSET));
        let hashes = Hashes { sent: start(), received: start() };
        (Tapped { port, hashes: hashes.clone() }, hashes)
    }
}

fn add(hash: &Cell<u64>, bytes: &[u8]) {
    hash.set(bytes.iter().fold(hash.get(), |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(FNV_PRIME)));
}

impl Port for Tapped {
    fn name(&self) -> &str {
        self.port.name()
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        add(&self.hashes.sent, bytes);
        self.port.send(bytes)
    }

    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let count = self.port.receive(into, wait)?;
        add(&self.hashes.received, &into[..count]);
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.port.now()
    }

    fn reopen(&mut self) -> Result<(), LinkError> {
        self.port.reopen()
    }

    fn nonce(&mut self) -> u32 {
        self.port.nonce()
    }

    fn can_reopen(&self) -> bool {
        self.port.can_reopen()
    }

    fn stands_still(&self) -> bool {
        self.port.stands_still()
    }
}
