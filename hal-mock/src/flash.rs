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
    /// Beyond the end.
    OutOfBounds,
    /// The word has been written since its page was erased.
    NotErased,
    /// The power is off.
    PowerCut,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            FlashError::NotAligned => NorFlashErrorKind::NotAligned,
            FlashError::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            FlashError::NotErased | FlashError::PowerCut => NorFlashErrorKind::Other,
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

/// How far an operation comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reach {
    Whole,
    Torn,
}

/// The flash.
#[derive(Clone, Debug)]
pub struct Flash {
    bytes: Vec<u8>,
    /// For each word, whether it must not be written before the next erase.
    written: Vec<bool>,
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
            erases: vec![0; pages],
            words_written: 0,
            power: Power::On,
            chance: Chance::new(seed),
        }
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
        self.written[page * WORDS_PER_PAGE..(page + 1) * WORDS_PER_PAGE].fill(reach == Reach::Torn);
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
mod tests {
    use super::*;

    const PAGE: u32 = PAGE_BYTES as u32;

    fn read<const N: usize>(flash: &mut Flash, offset: u32) -> [u8; N] {
        let mut bytes = [0; N];
        flash.read(offset, &mut bytes).unwrap();
        bytes
    }

    #[test]
    fn what_is_written_is_read_and_an_erase_takes_one_page() {
        let mut flash = Flash::new(3, 1);
        flash.write(PAGE - 8, &[0x11; 16]).unwrap();
        assert_eq!(read::<18>(&mut flash, PAGE - 9)[..2], [0xFF, 0x11]);
        flash.erase(PAGE, 2 * PAGE).unwrap();
        assert_eq!((read(&mut flash, PAGE - 8), read(&mut flash, PAGE)), ([0x11; 8], [0xFF; 8]));
        assert_eq!(([0, 1, 2].map(|page| flash.erases(page)), flash.words_written(), flash.operations()), ([0, 1, 0], 2, 3));
    }

    #[test]
    fn a_word_is_written_once_after_an_erase_even_with_the_same_value() {
        let mut flash = Flash::new(1, 1);
        for value in [[0xFF; 8], [0x5A; 8]] {
            flash.erase(0, PAGE).unwrap();
            flash.write(8, &value).unwrap();
            assert_eq!(flash.write(8, &value), Err(FlashError::NotErased));
            assert_eq!(flash.write(8, &[0; 8]), Err(FlashError::NotErased));
            assert_eq!(read(&mut flash, 8), value);
        }
        // A run of words stops at the first that is not erased; the rest stays as it was.
        assert_eq!(flash.write(0, &[0x33; 24]), Err(FlashError::NotErased));
        assert_eq!((read(&mut flash, 0), read(&mut flash, 8), read(&mut flash, 16)), ([0x33; 8], [0x5A; 8], [0xFF; 8]));
    }

    #[test]
    fn addresses_are_checked_and_a_refused_call_changes_nothing() {
        let mut flash = Flash::new(2, 1);
        assert_eq!(flash.write(4, &[0; 8]), Err(FlashError::NotAligned));
        assert_eq!(flash.write(0, &[0; 7]), Err(FlashError::NotAligned));
        assert_eq!(flash.write(2 * PAGE - 8, &[0; 16]), Err(FlashError::OutOfBounds));
        assert_eq!(flash.erase(8, PAGE), Err(FlashError::NotAligned));
        assert_eq!(flash.erase(PAGE, 0), Err(FlashError::OutOfBounds));
        assert_eq!(flash.erase(0, 3 * PAGE), Err(FlashError::OutOfBounds));
        assert_eq!(flash.read(2 * PAGE, &mut [0]), Err(FlashError::OutOfBounds));
        assert!(flash.operations() == 0 && flash.bytes().iter().all(|&byte| byte == ERASED));
        assert_eq!((flash.capacity(), FlashError::NotAligned.kind()), (2 * PAGE_BYTES, NorFlashErrorKind::NotAligned));
    }

    #[test]
    fn a_cut_write_leaves_part_of_one_word_and_the_rest_untouched() {
        let mut torn_words = 0;
        for seed in 0..32 {
            let mut flash = Flash::new(1, seed);
            flash.cut_power_after(2);
            assert_eq!(flash.write(0, &[0x0F; 32]), Err(FlashError::PowerCut));
            assert!(flash.is_off());
            assert_eq!(flash.read(0, &mut [0]), Err(FlashError::PowerCut));
            assert_eq!((flash.write(64, &[0; 8]), flash.erase(0, PAGE)), (Err(FlashError::PowerCut), Err(FlashError::PowerCut)));
            flash.restore_power();
            let [whole, torn, after]: [[u8; 8]; 3] = [0, 16, 24].map(|offset| read(&mut flash, offset));
            assert_eq!((whole, read(&mut flash, 8), after), ([0x0F; 8], [0x0F; 8], [0xFF; 8]));
            // Bits that were not to be cleared stand.
            assert!(torn.iter().all(|byte| byte & 0x0F == 0x0F), "{torn:x?}");
            torn_words += u32::from(torn != [0x0F; 8] && torn != [0xFF; 8]);
            assert_eq!(flash.write(16, &[0x0F; 8]), Err(FlashError::NotErased));
            flash.write(24, &[0x0F; 8]).unwrap();
        }
        assert!(torn_words > 28, "{torn_words}");
    }

    #[test]
    fn a_cut_erase_leaves_a_page_that_must_be_erased_again() {
        let mut flash = Flash::new(3, 9);
        flash.write(0, &[0x00; 3 * PAGE_BYTES]).unwrap();
        flash.cut_power_after(1);
        assert_eq!(flash.erase(0, 3 * PAGE), Err(FlashError::PowerCut));
        flash.restore_power();
        let ones: Vec<u32> =
            flash.bytes().chunks(PAGE_BYTES).map(|page| page.iter().map(|byte| byte.count_ones()).sum()).collect();
        assert!(ones[0] == 8 * PAGE && (2 * PAGE..6 * PAGE).contains(&ones[1]) && ones[2] == 0, "{ones:?}");
        assert_eq!(flash.write(PAGE, &[0; 8]), Err(FlashError::NotErased));
        flash.write(0, &[0x12; 8]).unwrap();
        flash.erase(PAGE, 2 * PAGE).unwrap();
        flash.write(PAGE, &[0x12; 8]).unwrap();
    }

    #[test]
    fn a_cut_that_is_taken_back_does_not_come_and_the_same_seed_tears_alike() {
        let torn = |seed, back: bool| {
            let mut flash = Flash::new(1, seed);
            flash.cut_power_after(0);
            if back {
                flash.restore_power();
            }
            let written = flash.write(0, &[0; 8]);
            (written, flash.bytes()[..8].to_vec())
        };
        assert_eq!(torn(3, true), (Ok(()), vec![0; 8]));
        assert_eq!(torn(3, false), torn(3, false));
        assert_ne!(torn(3, false), torn(4, false));
    }

    #[test]
    fn agrees_with_a_plain_model_whatever_is_done_and_whenever_power_goes() {
        let mut chance = Chance::new(2024);
        for seed in 0..200 {
            let mut flash = Flash::new(2, seed);
            let mut model: Vec<Option<[u8; 8]>> = vec![None; 2 * WORDS_PER_PAGE];
            flash.cut_power_after(chance.below(60));
            for _ in 0..60 {
                let (page, word) = (chance.below(2) as usize, chance.below(2 * WORDS_PER_PAGE as u64) as usize);
                let before = flash.bytes().to_vec();
                let (done, range) = if chance.strikes(0.05) {
                    (flash.erase(page as u32 * PAGE, (page as u32 + 1) * PAGE), page * PAGE_BYTES..(page + 1) * PAGE_BYTES)
                } else {
                    let value = [(); 8].map(|()| chance.byte());
                    let done = flash.write((word * 8) as u32, &value);
                    assert_eq!(done == Err(FlashError::NotErased), model[word].is_some() && !flash.is_off());
                    if done.is_ok() {
                        model[word] = Some(value);
                    }
                    (done, word * 8..word * 8 + 8)
                };
                if done.is_ok() && range.len() == PAGE_BYTES {
                    model[page * WORDS_PER_PAGE..(page + 1) * WORDS_PER_PAGE].fill(None);
                }
                // Whatever happened, it happened nowhere else.
                assert_eq!(
                    (&before[..range.start], &before[range.end..]),
                    (&flash.bytes()[..range.start], &flash.bytes()[range.end..])
                );
                if done == Err(FlashError::PowerCut) {
                    break;
                }
                let expected = model.iter().flat_map(|word| word.unwrap_or([ERASED; 8]));
                assert!(expected.eq(flash.bytes().iter().copied()));
            }
        }
    }
}
