//! NOR flash with the geometry of an STM32G474: pages of 2 KiB, and words of 8 bytes that can be
//! written once after an erase.
//!
//! The power can be cut during an operation: [`Flash::cut_power_after`] lets a number of operations
//! (a word written, a page erased) finish, and interrupts the next one:
//!
//! * a word whose write is cut has cleared only some of its bits, and counts as written;
//! * a page whose erase is cut has set only some of its bits, and must be erased again before it is
//!   written.
//!
//! The same seed gives the same result. After the cut every call fails until
//! [`Flash::restore_power`]. (The real part checks the error correction code of each word and
//! raises an interrupt for an incomplete one, instead of reading it as it is.)
//!
//! A word can be damaged at any time ([`Flash::damage`]): its bits flip, or it becomes unreadable
//! until its page is erased.
//!
//! A [`Mirror`] keeps the bytes outside the program after each operation, for example in a file.

use std::fmt::Debug;
use std::sync::Arc;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

use crate::chance::Chance;

/// Size of a page, the smallest unit of erasing, bytes.
pub const PAGE_BYTES: usize = 2048;
/// Size of a word, the smallest unit of writing, bytes.
pub const WORD_BYTES: usize = 8;

const ERASED: u8 = 0xFF;
const WORDS_PER_PAGE: usize = PAGE_BYTES / WORD_BYTES;

/// Error of a flash access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// Address or length is not a multiple of the required size.
    NotAligned,
    /// An address is beyond the end of the flash.
    OutOfBounds,
    /// The word has been written since its page was erased.
    NotErased,
    /// The power is off.
    PowerCut,
    /// A word in the range is damaged.
    Unreadable,
    /// The mirror has failed, and the flash is unchanged.
    NotMirrored,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            FlashError::NotAligned => NorFlashErrorKind::NotAligned,
            FlashError::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            FlashError::NotErased | FlashError::PowerCut | FlashError::Unreadable | FlashError::NotMirrored => {
                NorFlashErrorKind::Other
            }
        }
    }
}

impl From<NorFlashErrorKind> for FlashError {
    fn from(kind: NorFlashErrorKind) -> Self {
        match kind {
            NorFlashErrorKind::NotAligned => FlashError::NotAligned,
            // The checks of embedded-storage return only these two.
            _ => FlashError::OutOfBounds,
        }
    }
}

/// State of the power supply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Power {
    On,
    /// Fails during the operation that follows this number of further ones.
    CutAfter(u64),
    Off,
}

/// Damage of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// These bits have flipped, without an error being detected.
    Flips([u8; WORD_BYTES]),
    /// The word cannot be read: its error correction code detects the damage.
    Unreadable,
}

/// Completion of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Completion {
    Whole,
    Interrupted,
}

/// Copy of a flash outside the program.
pub trait Mirror: Debug + Send + Sync {
    /// Keeps these bytes, which are the whole flash. Returns `false` if that fails.
    fn keep(&self, bytes: &[u8]) -> bool;
}

/// Flash of pages and words, in memory.
#[derive(Clone, Debug)]
pub struct Flash {
    bytes: Vec<u8>,
    /// For each word, `true` if it must not be written before the next erase.
    written: Vec<bool>,
    /// For each word, `true` if it cannot be read.
    unreadable: Vec<bool>,
    erases: Vec<u32>,
    words_written: u64,
    power: Power,
    chance: Chance,
    mirror: Option<Arc<dyn Mirror>>,
}

impl Flash {
    /// Creates an erased flash with this number of pages.
    pub fn new(pages: usize, seed: u64) -> Self {
        Flash {
            bytes: vec![ERASED; pages * PAGE_BYTES],
            written: vec![false; pages * WORDS_PER_PAGE],
            unreadable: vec![false; pages * WORDS_PER_PAGE],
            erases: vec![0; pages],
            words_written: 0,
            power: Power::On,
            chance: Chance::new(seed),
            mirror: None,
        }
    }

    /// Keeps the bytes in `mirror` after each later operation. If that fails, the operation fails
    /// without effect.
    pub fn with_mirror(self, mirror: Arc<dyn Mirror>) -> Self {
        Flash { mirror: Some(mirror), ..self }
    }

    /// Performs an operation, and keeps its result in the mirror.
    fn mirrored(&mut self, act: impl FnOnce(&mut Self) -> Result<(), FlashError>) -> Result<(), FlashError> {
        let Some(mirror) = self.mirror.clone() else { return act(self) };
        let before = self.clone();
        let done = act(self);
        if mirror.keep(&self.bytes) {
            return done;
        }
        *self = before;
        Err(FlashError::NotMirrored)
    }

    /// Creates a flash with these bytes, which must be whole pages. A word that is all ones counts
    /// as erased.
    ///
    /// # Panics
    /// If the bytes are not whole pages.
    pub fn holding(bytes: Vec<u8>, seed: u64) -> Self {
        assert!(bytes.len().is_multiple_of(PAGE_BYTES), "{} bytes are not whole pages of {PAGE_BYTES}", bytes.len());
        let written = bytes.chunks_exact(WORD_BYTES).map(|word| word.iter().any(|&byte| byte != ERASED)).collect();
        let pages = bytes.len() / PAGE_BYTES;
        Flash { bytes, written, ..Flash::new(pages, seed) }
    }

    /// Returns how often a page was erased: its wear.
    pub fn erases(&self, page: usize) -> u32 {
        self.erases.get(page).copied().unwrap_or(0)
    }

    /// Returns the number of words written so far.
    pub fn words_written(&self) -> u64 {
        self.words_written
    }

    /// Returns the number of operations so far, including interrupted ones. The power can be cut
    /// during each.
    pub fn operations(&self) -> u64 {
        self.words_written + self.erases.iter().map(|&count| u64::from(count)).sum::<u64>()
    }

    /// Lets `operations` more operations finish and cuts the power during the next.
    pub fn cut_power_after(&mut self, operations: u64) {
        self.power = Power::CutAfter(operations);
    }

    /// Damages a word.
    pub fn damage(&mut self, word: usize, damage: Damage) {
        match damage {
            Damage::Flips(bits) => {
                let bytes = &mut self.bytes[word * WORD_BYTES..][..WORD_BYTES];
                bytes.iter_mut().zip(bits).for_each(|(byte, bits)| *byte ^= bits);
            }
            Damage::Unreadable => self.unreadable[word] = true,
        }
    }

    /// Returns `true` if the power is off.
    pub fn is_off(&self) -> bool {
        self.power == Power::Off
    }

    /// Switches the power on again, or cancels a pending cut.
    pub fn restore_power(&mut self) {
        self.power = Power::On;
    }

    /// Returns all bytes, with or without power, to inspect the result of a cut.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Flips bits of a byte, with or without power, like a cell that has lost its charge. Does
    /// nothing beyond the end.
    pub fn turn_bits(&mut self, at: usize, bits: u8) {
        if let Some(byte) = self.bytes.get_mut(at) {
            *byte ^= bits;
        }
    }

    fn powered(&self) -> Result<(), FlashError> {
        if self.is_off() { Err(FlashError::PowerCut) } else { Ok(()) }
    }

    /// Counts one operation and returns its completion.
    fn count_operation(&mut self) -> Completion {
        match self.power {
            Power::CutAfter(0) => {
                self.power = Power::Off;
                Completion::Interrupted
            }
            Power::CutAfter(more) => {
                self.power = Power::CutAfter(more - 1);
                Completion::Whole
            }
            Power::On | Power::Off => Completion::Whole,
        }
    }

    /// Returns a byte whose change from `from` to `to` was interrupted: a random part of its bits
    /// has changed.
    fn interrupted(&mut self, from: u8, to: u8) -> u8 {
        from ^ ((from ^ to) & self.chance.byte())
    }

    fn erase_page(&mut self, page: usize) -> Result<(), FlashError> {
        let completion = self.count_operation();
        self.erases[page] += 1;
        for at in page * PAGE_BYTES..(page + 1) * PAGE_BYTES {
            let from = self.bytes[at];
            self.bytes[at] = if completion == Completion::Whole { ERASED } else { self.interrupted(from, ERASED) };
        }
        let words = page * WORDS_PER_PAGE..(page + 1) * WORDS_PER_PAGE;
        self.written[words.clone()].fill(completion == Completion::Interrupted);
        self.unreadable[words].fill(false);
        self.powered()
    }

    fn write_word(&mut self, word: usize, value: &[u8]) -> Result<(), FlashError> {
        if std::mem::replace(&mut self.written[word], true) {
            return Err(FlashError::NotErased);
        }
        let completion = self.count_operation();
        self.words_written += 1;
        for (at, &to) in (word * WORD_BYTES..).zip(value) {
            let from = self.bytes[at];
            self.bytes[at] = if completion == Completion::Whole { to } else { self.interrupted(from, to) };
        }
        self.powered()
    }
}

impl ErrorType for Flash {
    type Error = FlashError;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, into: &mut [u8]) -> Result<(), FlashError> {
        self.powered()?;
        check_read(self, offset, into.len())?;
        let words = offset as usize / WORD_BYTES..(offset as usize + into.len()).div_ceil(WORD_BYTES);
        if self.unreadable[words].contains(&true) {
            return Err(FlashError::Unreadable);
        }
        into.copy_from_slice(&self.bytes[offset as usize..][..into.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = PAGE_BYTES;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.powered()?;
        check_erase(self, from, to)?;
        self.mirrored(|flash| (from as usize / PAGE_BYTES..to as usize / PAGE_BYTES).try_for_each(|page| flash.erase_page(page)))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.powered()?;
        check_write(self, offset, bytes.len())?;
        let words = (offset as usize / WORD_BYTES..).zip(bytes.chunks_exact(WORD_BYTES));
        self.mirrored(|flash| words.into_iter().try_for_each(|(word, value)| flash.write_word(word, value)))
    }
}

#[cfg(test)]
mod tests;
