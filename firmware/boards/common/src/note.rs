//! Note of the reason why the last run ended, in RAM that a reset does not clear.
//!
//! At power-on this RAM has random contents. A note is valid only if its mark, its cause, its
//! length and its checksum are right.

use firmware::board::start::{FileName, NAME, Place, Start};

/// First word of a valid note.
const MARK: u32 = 0x536f_6e6f;

/// Cause of the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Cause {
    /// A panic, at a line of a file.
    Panic = 1,
    /// A hard fault; the line is the address of the code.
    HardFault = 2,
    /// An interrupt that the image does not use; the line is its number.
    Unexpected = 3,
    /// DMA or a converter lost a sample: the streams are out of step.
    StreamLost = 4,
    /// A reset by command.
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

    /// Returns the name of the cause in the log.
    #[inline]
    pub fn name(self) -> &'static str {
        match self {
            Cause::Panic => "a panic",
            Cause::HardFault => "a hard fault",
            Cause::Unexpected => "an unexpected interrupt",
            Cause::StreamLost => "a lost stream",
            Cause::Ordered => "a reset command",
            Cause::DamagedCode => "a damaged word of the code",
            Cause::ClockFailed => "a crystal failure",
            Cause::StackOverflow => "a stack overflow",
            Cause::SupplyLow => "a low supply",
            Cause::RamParity => "a parity error in RAM",
        }
    }

    fn from_code(code: u32) -> Option<Cause> {
        Cause::ALL.into_iter().find(|&cause| cause as u32 == code)
    }
}

/// Note of the cause and the place of the end of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Note {
    mark: u32,
    cause: u32,
    /// Line of the file, or the number described at the [`Cause`].
    pub line: u32,
    length: u32,
    name: [u8; NAME],
    /// Checksum of the words before the name.
    seal: u32,
}

impl Note {
    /// Memory without a note.
    pub const BLANK: Note = Note { mark: 0, cause: 0, line: 0, length: 0, name: [0; NAME], seal: 0 };

    /// Creates a note of a cause and its place. Of a long file name only the end is stored.
    #[inline]
    pub fn new(cause: Cause, file: &str, line: u32) -> Note {
        let bytes = file.as_bytes();
        let end = &bytes[bytes.len().saturating_sub(NAME)..];
        let mut name = [0; NAME];
        name.iter_mut().zip(end).for_each(|(to, from)| *to = *from);
        let note = Note { mark: MARK, cause: cause as u32, line, length: end.len() as u32, name, seal: 0 };
        Note { seal: note.sum(), ..note }
    }

    /// Returns the cause, the file and the line, or `None` if the memory holds no valid note.
    #[inline]
    pub fn read(&self) -> Option<(Cause, &str, u32)> {
        let cause = Cause::from_code(self.cause).filter(|_| self.mark == MARK && self.seal == self.sum())?;
        let name = core::str::from_utf8(self.name.get(..self.length as usize)?).unwrap_or("?");
        Some((cause, name, self.line))
    }

    /// Returns the cause of the start that follows from this note.
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
