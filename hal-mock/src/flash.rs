//! NOR flash with the geometry of an STM32G474: pages of 2 KiB, and words of 8 bytes that can be written once after an erase.
//!
//! Power can be cut in the middle of things: [`Flash::cut_power_after`] lets so many operations (a word written, a page erased)
//! finish, and leaves the next one half done:
//!
//! * a word cut while it is written has some of the bits that were to be cleared cleared, and counts as written;
//! * a page cut while it is erased has some bits set and others not, and must be erased again before anything is written to it.
//!
//! The same seed leaves the same halves. From then on every call fails until [`Flash::restore_power`]. (The real part checks
//! each word's error correction code and raises an interrupt on a torn one, rather than reading it as it is.)
//!
//! A word can be damaged at any time ([`Flash::damage`]): its bits flip, or it cannot be read any more, until its page is erased.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

use crate::chance::Chance;

/// Bytes in a page: the smallest piece that can be erased.
pub const PAGE_BYTES: usize = 2048;
/// Bytes in a word: the smallest piece that can be written.
pub const WORD_BYTES: usize = 8;

const ERASED: u8 = 0xFF;
const WORDS_PER_PAGE: usize = PAGE_BYTES / WORD_BYTES;

/// Why the flash did not do what it was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// Address or length are not multiples of what they must be.
    NotAligned,
    /// An address is beyond the end of the flash.
    OutOfBounds,
    /// The word has been written since its page was erased.
    NotErased,
    /// The power is off.
    PowerCut,
    /// A word in it is damaged.
    Unreadable,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            FlashError::NotAligned => NorFlashErrorKind::NotAligned,
            FlashError::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            FlashError::NotErased | FlashError::PowerCut | FlashError::Unreadable => NorFlashErrorKind::Other,
        }
    }
}

impl From<NorFlashErrorKind> for FlashError {
    fn from(kind: NorFlashErrorKind) -> Self {
        match kind {
            NorFlashErrorKind::NotAligned => FlashError::NotAligned,
            // The checks of embedded-storage know these two.
            _ => FlashError::OutOfBounds,
        }
    }
}

/// The power supply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Power {
    On,
    /// Goes in the middle of the operation after so many more.
    CutAfter(u64),
    Off,
}

/// What has become of a word that is damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Damage {
    /// These bits of it have flipped, and nothing notices.
    Flips([u8; WORD_BYTES]),
    /// It cannot be read: its error correction code says so.
    Unreadable,
}

/// How far an operation comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    Whole,
    Torn,
}

/// A flash of pages and words, in memory.
#[derive(Clone, Debug)]
pub struct Flash {
    bytes: Vec<u8>,
    /// For each word, whether it must not be written before the next erase.
    written: Vec<bool>,
    /// For each word, whether it cannot be read.
    unreadable: Vec<bool>,
    erases: Vec<u32>,
    words_written: u64,
    power: Power,
    chance: Chance,
}

impl Flash {
    /// A flash of so many pages, all erased.
    pub fn new(pages: usize, seed: u64) -> Self {
        Flash {
            bytes: vec![ERASED; pages * PAGE_BYTES],
            written: vec![false; pages * WORDS_PER_PAGE],
            unreadable: vec![false; pages * WORDS_PER_PAGE],
            erases: vec![0; pages],
            words_written: 0,
            power: Power::On,
            chance: Chance::new(seed),
        }
    }

    /// A flash that holds these bytes, whole pages of them. A word that is all ones counts as erased.
    ///
    /// # Panics
    /// If the bytes are not whole pages.
    pub fn holding(bytes: Vec<u8>, seed: u64) -> Self {
        assert!(bytes.len().is_multiple_of(PAGE_BYTES), "{} bytes are not whole pages of {PAGE_BYTES}", bytes.len());
        let written = bytes.chunks_exact(WORD_BYTES).map(|word| word.iter().any(|&byte| byte != ERASED)).collect();
        let pages = bytes.len() / PAGE_BYTES;
        Flash { bytes, written, ..Flash::new(pages, seed) }
    }

    /// How often a page has been erased: its wear.
    pub fn erases(&self, page: usize) -> u32 {
        self.erases.get(page).copied().unwrap_or(0)
    }

    /// Words written so far.
    pub fn words_written(&self) -> u64 {
        self.words_written
    }

    /// Operations so far, those cut in the middle included: how many moments there are to cut power at.
    pub fn operations(&self) -> u64 {
        self.words_written + self.erases.iter().map(|&count| u64::from(count)).sum::<u64>()
    }

    /// Lets `operations` more operations finish and cuts the power in the middle of the next.
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

    /// Whether the power is off.
    pub fn is_off(&self) -> bool {
        self.power == Power::Off
    }

    /// Turns the power on again, or takes back a cut that has not come yet.
    pub fn restore_power(&mut self) {
        self.power = Power::On;
    }

    /// All bytes as they are, power or not: for looking at what a cut has left.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Turns bits of a byte, power or not, as a cell does that has lost its charge. Beyond the end there is nothing to turn.
    pub fn turn_bits(&mut self, at: usize, bits: u8) {
        if let Some(byte) = self.bytes.get_mut(at) {
            *byte ^= bits;
        }
    }

    fn powered(&self) -> Result<(), FlashError> {
        if self.is_off() { Err(FlashError::PowerCut) } else { Ok(()) }
    }

    /// Spends one operation.
    fn spend(&mut self) -> Reach {
        match self.power {
            Power::CutAfter(0) => {
                self.power = Power::Off;
                Reach::Torn
            }
            Power::CutAfter(more) => {
                self.power = Power::CutAfter(more - 1);
                Reach::Whole
            }
            Power::On | Power::Off => Reach::Whole,
        }
    }

    /// What a byte is on its way from `from` to `to`: each bit that changes has done so, or not.
    fn torn(&mut self, from: u8, to: u8) -> u8 {
        from ^ ((from ^ to) & self.chance.byte())
    }

    fn erase_page(&mut self, page: usize) -> Result<(), FlashError> {
        let reach = self.spend();
        self.erases[page] += 1;
        for at in page * PAGE_BYTES..(page + 1) * PAGE_BYTES {
            let from = self.bytes[at];
            self.bytes[at] = if reach == Reach::Whole { ERASED } else { self.torn(from, ERASED) };
        }
        let words = page * WORDS_PER_PAGE..(page + 1) * WORDS_PER_PAGE;
        self.written[words.clone()].fill(reach == Reach::Torn);
        self.unreadable[words].fill(false);
        self.powered()
    }

    fn write_word(&mut self, word: usize, value: &[u8]) -> Result<(), FlashError> {
        if std::mem::replace(&mut self.written[word], true) {
            return Err(FlashError::NotErased);
        }
        let reach = self.spend();
        self.words_written += 1;
        for (at, &to) in (word * WORD_BYTES..).zip(value) {
            let from = self.bytes[at];
            self.bytes[at] = if reach == Reach::Whole { to } else { self.torn(from, to) };
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
        (from as usize / PAGE_BYTES..to as usize / PAGE_BYTES).try_for_each(|page| self.erase_page(page))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.powered()?;
        check_write(self, offset, bytes.len())?;
        (offset as usize / WORD_BYTES..)
            .zip(bytes.chunks_exact(WORD_BYTES))
            .try_for_each(|(word, value)| self.write_word(word, value))
    }
}

#[cfg(test)]
mod tests;
