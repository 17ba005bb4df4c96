//! A duplex byte link in memory.
//!
//! [`duplex`] returns two [`End`]s; bytes written to one are read from the other. Each direction is
//! a [`Wire`] of unlimited or limited capacity. [`crate::noise`] damages the bytes of a link.
//!
//! By the contract of embedded-io, reading from an empty wire and writing to a full one may wait. A
//! mock cannot wait: reading from an empty wire returns an error, and a full wire follows its
//! [`WhenFull`].

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write, WriteReady};

/// Error of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkError {
    /// Nothing to read, or no room: a real link would wait here.
    WouldWait,
    /// The link is cut.
    Cut,
}

impl std::fmt::Display for LinkError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            LinkError::WouldWait => "would wait",
            LinkError::Cut => "the link is cut",
        })
    }
}

impl std::error::Error for LinkError {}

impl embedded_io::Error for LinkError {
    fn kind(&self) -> ErrorKind {
        match self {
            LinkError::WouldWait => ErrorKind::TimedOut,
            LinkError::Cut => ErrorKind::BrokenPipe,
        }
    }
}

/// Behaviour of a wire without room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WhenFull {
    /// The writer gets [`LinkError::WouldWait`].
    #[default]
    Refuses,
    /// The writer waits until there is room. No time passes, but these bytes are counted.
    Waits,
}

/// One direction of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wire {
    /// Number of bytes that fit before the reader takes some; `None` is unlimited.
    pub capacity: Option<usize>,
    /// Behaviour when the wire is full.
    pub when_full: WhenFull,
}

#[derive(Debug)]
struct Pipe {
    wire: Wire,
    bytes: VecDeque<u8>,
    waited: u64,
    cut: bool,
}

impl Pipe {
    fn shared(wire: Wire) -> Rc<RefCell<Self>> {
        Rc::new(RefCell::new(Pipe { wire, bytes: VecDeque::new(), waited: 0, cut: false }))
    }

    fn room(&self) -> usize {
        self.wire.capacity.map_or(usize::MAX, |capacity| capacity.saturating_sub(self.bytes.len()))
    }

    fn check(&self) -> Result<(), LinkError> {
        if self.cut { Err(LinkError::Cut) } else { Ok(()) }
    }
}

/// One end of a link.
#[derive(Debug)]
pub struct End {
    inward: Rc<RefCell<Pipe>>,
    outward: Rc<RefCell<Pipe>>,
}

/// Creates a link with one wire for each direction. Returns its two ends.
pub fn duplex(there: Wire, back: Wire) -> (End, End) {
    let (there, back) = (Pipe::shared(there), Pipe::shared(back));
    (End { inward: back.clone(), outward: there.clone() }, End { inward: there, outward: back })
}

impl End {
    /// Returns the number of bytes that wait to be read at this end.
    pub fn waiting(&self) -> usize {
        self.inward.borrow().bytes.len()
    }

    /// Returns the number of bytes for which the writer at the other end had to wait.
    pub fn write_waits(&self) -> u64 {
        self.inward.borrow().waited
    }

    /// Cuts or restores both directions. Bytes in transit stay.
    pub fn set_cut(&self, cut: bool) {
        self.inward.borrow_mut().cut = cut;
        self.outward.borrow_mut().cut = cut;
    }

    /// Takes up to `count` bytes, to simulate a slow reader.
    pub fn take(&mut self, count: usize) -> Vec<u8> {
        let mut pipe = self.inward.borrow_mut();
        let count = count.min(pipe.bytes.len());
        pipe.bytes.drain(..count).collect()
    }
}

impl ErrorType for End {
    type Error = LinkError;
}

impl Read for End {
    fn read(&mut self, into: &mut [u8]) -> Result<usize, LinkError> {
        let mut pipe = self.inward.borrow_mut();
        pipe.check()?;
        if pipe.bytes.is_empty() && !into.is_empty() {
            return Err(LinkError::WouldWait);
        }
        let count = into.len().min(pipe.bytes.len());
        into.iter_mut().zip(pipe.bytes.drain(..count)).for_each(|(into, byte)| *into = byte);
        Ok(count)
    }
}

impl ReadReady for End {
    fn read_ready(&mut self) -> Result<bool, LinkError> {
        let pipe = self.inward.borrow();
        pipe.check().map(|()| !pipe.bytes.is_empty())
    }
}

impl Write for End {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, LinkError> {
        let mut pipe = self.outward.borrow_mut();
        pipe.check()?;
        let fits = pipe.room().min(bytes.len());
        let waits = fits == 0 && !bytes.is_empty();
        if waits && pipe.wire.when_full == WhenFull::Refuses {
            return Err(LinkError::WouldWait);
        }
        // The writer waits only until there is room for one byte.
        let count = if waits { 1 } else { fits };
        pipe.waited += u64::from(waits);
        pipe.bytes.extend(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> Result<(), LinkError> {
        self.outward.borrow().check()
    }
}

impl WriteReady for End {
    fn write_ready(&mut self) -> Result<bool, LinkError> {
        let pipe = self.outward.borrow();
        pipe.check().map(|()| pipe.room() > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NARROW: Wire = Wire { capacity: Some(4), when_full: WhenFull::Refuses };

    #[test]
    fn both_directions_carry_and_do_not_mix() {
        let (mut board, mut host) = duplex(Wire::default(), Wire::default());
        board.write_all(b"telemetry").unwrap();
        host.write_all(b"run").unwrap();
        let mut bytes = [0; 16];
        assert_eq!((board.read(&mut bytes).unwrap(), &bytes[..3]), (3, &b"run"[..]));
        assert_eq!(host.take(4), b"tele");
        assert_eq!((host.waiting(), host.read(&mut bytes).unwrap(), &bytes[..5]), (5, 5, &b"metry"[..]));
        assert_eq!((host.read_ready(), host.read(&mut bytes)), (Ok(false), Err(LinkError::WouldWait)));
    }

    #[test]
    fn a_full_wire_refuses_until_something_is_taken() {
        let (mut board, mut host) = duplex(NARROW, Wire::default());
        assert_eq!((board.write(b"abcdef"), board.write_ready()), (Ok(4), Ok(false)));
        assert_eq!(board.write(b"e"), Err(LinkError::WouldWait));
        assert_eq!(host.take(1), b"a");
        assert_eq!((board.write_ready(), board.write(b"ef")), (Ok(true), Ok(1)));
        assert_eq!(host.take(9), b"bcde");
    }

    #[test]
    fn waits_of_a_writer_are_counted() {
        let (mut board, mut host) = duplex(Wire { when_full: WhenFull::Waits, ..NARROW }, Wire::default());
        board.write_all(b"abcdef").unwrap();
        assert_eq!((host.write_waits(), board.write_ready()), (2, Ok(false)));
        assert_eq!(host.take(9), b"abcdef");
    }

    #[test]
    fn a_cut_link_fails_both_ways_until_restored() {
        let (mut board, mut host) = duplex(Wire::default(), Wire::default());
        board.write_all(b"x").unwrap();
        host.set_cut(true);
        assert_eq!((board.write(b"y"), board.read_ready()), (Err(LinkError::Cut), Err(LinkError::Cut)));
        assert_eq!(host.read(&mut [0; 4]), Err(LinkError::Cut));
        host.set_cut(false);
        assert_eq!(host.read(&mut [0; 4]), Ok(1));
    }
}
