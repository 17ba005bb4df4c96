//! Why the last run ended, in RAM that a reset does not clear.
//!
//! At power-on that RAM holds anything: a note is valid only if its two marks and its length are
//! right.

use firmware::board::start::{FileName, NAME, Place, Start};

/// Marks a note.
const MARK: u32 = 0x536f_6e6f;

/// A cause that ended a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Cause {
    /// A panic, at a line of a file.
    Panic = 1,
    /// A hard fault; the line is the address of the code.
    HardFault = 2,
    /// An interrupt that the image does not use; the line is its number.
    Unexpected = 3,
    /// DMA or a converter has lost a sample, and the streams are out of step.
    StreamLost = 4,
    /// A reset was ordered.
    Ordered = 5,
    /// A word of the code or of its constants cannot be read; the line is its address.
    DamagedCode = 6,
    /// The crystal has stopped.
    ClockFailed = 7,
    /// The stack has grown into its guard; the line is the address of the code.
    StackOverflow = 8,
    /// The supply has fallen below the level of its detector.
    SupplyLow = 9,
    /// A word of the RAM has a wrong parity bit.
    RamParity = 10,
}

impl Cause {
    /// All causes.
    pub const ALL: [Cause; 10] = [
        Cause::Panic,
        Cause::HardFault,
        Cause::Unexpected,
        Cause::StreamLost,
        Cause::Ordered,
        Cause::DamagedCode,
        Cause::ClockFailed,
        Cause::StackOverflow,
        Cause::SupplyLow,
        Cause::RamParity,
    ];

    /// The name of the cause in the log.
    #[inline]
    pub fn name(self) -> &'static str {
        match self {
            Cause::Panic => "a panic",
            Cause::HardFault => "a hard fault",
            Cause::Unexpected => "an unexpected interrupt",
            Cause::StreamLost => "a stream that was lost",
            Cause::Ordered => "an order to reset",
            Cause::DamagedCode => "a damaged word of the code",
            Cause::ClockFailed => "a failure of the crystal",
            Cause::StackOverflow => "a stack overflow",
            Cause::SupplyLow => "a supply that was too low",
            Cause::RamParity => "a parity error in RAM",
        }
    }

    fn of(code: u32) -> Option<Cause> {
        Cause::ALL.into_iter().find(|&cause| cause as u32 == code)
    }
}

/// A note.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Note {
    mark: u32,
    cause: u32,
    /// The line, or the number that the cause's documentation names.
    pub line: u32,
    length: u32,
    name: [u8; NAME],
    /// Of the words before.
    seal: u32,
}

impl Note {
    /// No note.
    pub const BLANK: Note = Note { mark: 0, cause: 0, line: 0, length: 0, name: [0; NAME], seal: 0 };

    /// A note of a cause and its place: of a long file name the end is stored.
    #[inline]
    pub fn of(cause: Cause, file: &str, line: u32) -> Note {
        let bytes = file.as_bytes();
        let end = &bytes[bytes.len().saturating_sub(NAME)..];
        let mut name = [0; NAME];
        name.iter_mut().zip(end).for_each(|(to, from)| *to = *from);
        let note = Note { mark: MARK, cause: cause as u32, line, length: end.len() as u32, name, seal: 0 };
        Note { seal: note.sum(), ..note }
    }

    /// The cause, the file and the line; `None` where there is no note.
    #[inline]
    pub fn read(&self) -> Option<(Cause, &str, u32)> {
        let cause = Cause::of(self.cause).filter(|_| self.mark == MARK && self.seal == self.sum())?;
        let name = core::str::from_utf8(self.name.get(..self.length as usize)?).unwrap_or("?");
        Some((cause, name, self.line))
    }

    /// What started the board, by its note.
    #[inline]
    pub fn start(&self) -> Option<Start> {
        self.read().map(|(cause, file, line)| match cause {
            Cause::Panic => Start::Panic(Place { file: FileName::of(file), line }),
            Cause::HardFault => Start::HardFault(line),
            Cause::Unexpected => Start::Unexpected(line),
            Cause::StreamLost => Start::StreamLost(line),
            Cause::Ordered => Start::Ordered,
            Cause::DamagedCode => Start::DamagedCode(line),
            Cause::ClockFailed => Start::ClockFailed,
            Cause::StackOverflow => Start::StackOverflow(line),
            Cause::SupplyLow => Start::SupplyLow,
            Cause::RamParity => Start::RamParity,
        })
    }

    fn sum(&self) -> u32 {
        !(self.mark ^ self.cause.rotate_left(8) ^ self.line.rotate_left(16) ^ self.length.rotate_left(24))
    }
}
