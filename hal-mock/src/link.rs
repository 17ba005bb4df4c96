//! A duplex byte link in memory.
//!
//! [`duplex`] gives two [`End`]s; what is written to one is read from the other. Each direction is a [`Wire`]: endless, or with
//! room for so many bytes that the reader has not taken yet. [`crate::noise`] damages what goes over it.
//!
//! The contract of embedded-io lets a reader of nothing and a writer into a full wire wait. Nothing here can wait, so a reader of
//! nothing gets an error, and a full wire does as its [`WhenFull`] says.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write, WriteReady};

/// Why an end did not do what it was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinkError {
    /// Nothing to read, or no room: a real one would wait here.
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

/// What a writer meets in a wire without room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WhenFull {
    /// The writer gets [`LinkError::WouldWait`].
    #[default]
    Refuses,
    /// The writer waits until there is room. No time passes, but the bytes that were waited for are counted.
    Waits,
}

/// One direction of a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wire {
    /// Bytes that fit before the reader takes some; `None` is endless.
    pub capacity: Option<usize>,
    /// What happens when they are all in.
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

/// Two ends: what goes from the first to the second, and back.
pub fn duplex(there: Wire, back: Wire) -> (End, End) {
    let (there, back) = (Pipe::shared(there), Pipe::shared(back));
    (End { inward: back.clone(), outward: there.clone() }, End { inward: there, outward: back })
}

impl End {
    /// Bytes that wait to be read here.
    pub fn waiting(&self) -> usize {
        self.inward.borrow().bytes.len()
    }

    /// Bytes that the writer at the other end had to wait with, because this end had not taken enough.
    pub fn write_waits(&self) -> u64 {
        self.inward.borrow().waited
    }

    /// Cuts both directions, or mends them. What is on its way stays.
    pub fn set_cut(&self, cut: bool) {
        self.inward.borrow_mut().cut = cut;
        self.outward.borrow_mut().cut = cut;
    }

    /// Takes up to `count` bytes, or all there are: a reader as slow as the test wants.
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
        // Room for one byte is all that is waited for.
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
    fn a_patient_writer_is_counted() {
        let (mut board, mut host) = duplex(Wire { when_full: WhenFull::Waits, ..NARROW }, Wire::default());
        board.write_all(b"abcdef").unwrap();
        assert_eq!((host.write_waits(), board.write_ready()), (2, Ok(false)));
        assert_eq!(host.take(9), b"abcdef");
    }

    #[test]
    fn a_cut_link_fails_both_ways_and_mends() {
        let (mut board, mut host) = duplex(Wire::default(), Wire::default());
        board.write_all(b"x").unwrap();
        host.set_cut(true);
        assert_eq!((board.write(b"y"), board.read_ready()), (Err(LinkError::Cut), Err(LinkError::Cut)));
        assert_eq!(host.read(&mut [0; 4]), Err(LinkError::Cut));
        host.set_cut(false);
        assert_eq!(host.read(&mut [0; 4]), Ok(1));
    }
}
