//! Why the last run ended, in RAM that a reset does not clear.
//!
//! At power-on that RAM holds anything: a note counts only if its two marks and its length are right.

use firmware::board::start::{FileName, NAME, Place, Start};

/// Marks a note.
const MARK: u32 = 0x536f_6e6f;

/// What ended a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Cause {
    /// A panic, at a line of a file.
    Panic = 1,
    /// A hard fault; the line is the address of the code.
    HardFault = 2,
    /// An interrupt that nobody has asked for; the line is its number.
    Unexpected = 3,
    /// DMA or a converter has lost a sample, and the streams are out of step.
    StreamLost = 4,
    /// A reset was ordered.
    Ordered = 5,
}

impl Cause {
    /// What it is called in a log.
    pub fn name(self) -> &'static str {
        match self {
            Cause::Panic => "a panic",
            Cause::HardFault => "a hard fault",
            Cause::Unexpected => "an unexpected interrupt",
            Cause::StreamLost => "a stream that was lost",
            Cause::Ordered => "an order to reset",
        }
    }

    fn of(code: u32) -> Option<Cause> {
        let known = [Cause::Panic, Cause::HardFault, Cause::Unexpected, Cause::StreamLost, Cause::Ordered];
        known.into_iter().find(|&cause| cause as u32 == code)
    }
}

/// A note.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Note {
    mark: u32,
    cause: u32,
    /// The line, or what the cause says it is.
    pub line: u32,
    length: u32,
    name: [u8; NAME],
    /// Of the words before.
    seal: u32,
}

impl Note {
    /// No note.
    pub const BLANK: Note = Note { mark: 0, cause: 0, line: 0, length: 0, name: [0; NAME], seal: 0 };

    /// A note of what happened, and where: the end of a long file name is kept.
    pub fn of(cause: Cause, file: &str, line: u32) -> Note {
        let bytes = file.as_bytes();
        let end = &bytes[bytes.len().saturating_sub(NAME)..];
        let mut name = [0; NAME];
        name.iter_mut().zip(end).for_each(|(to, from)| *to = *from);
        let note = Note { mark: MARK, cause: cause as u32, line, length: end.len() as u32, name, seal: 0 };
        Note { seal: note.sum(), ..note }
    }

    /// What happened, in which file, at which line; `None` where there is no note.
    pub fn read(&self) -> Option<(Cause, &str, u32)> {
        let cause = Cause::of(self.cause).filter(|_| self.mark == MARK && self.seal == self.sum())?;
        let name = core::str::from_utf8(self.name.get(..self.length as usize)?).unwrap_or("?");
        Some((cause, name, self.line))
    }

    /// What started the board, by its note.
    pub fn start(&self) -> Option<Start> {
        self.read().map(|(cause, file, line)| match cause {
            Cause::Panic => Start::Panic(Place { file: FileName::of(file), line }),
            Cause::HardFault => Start::HardFault(line),
            Cause::Unexpected => Start::Unexpected(line),
            Cause::StreamLost => Start::StreamLost(line),
            Cause::Ordered => Start::Ordered,
        })
    }

    fn sum(&self) -> u32 {
        !(self.mark ^ self.cause.rotate_left(8) ^ self.line.rotate_left(16) ^ self.length.rotate_left(24))
    }
}
