//! Settings stored in flash.
//!
//! Two maps of keys to values (`sequential-storage`), each in its half of the flash, and the same record with the same number in both: a store
//! writes it into one, reads it back, and writes it into the other. Whenever power goes, and however often, one half has a record whole, and a
//! word that is damaged later leaves the other copy. Pages are used in turns, which spreads the wear.
//!
//! ```text
//! key: u8 | version of the value: u8 | number of the write: u32, little-endian | value: postcard
//! ```
//!
//! Lane trims and parameters are one value, so that the old of one never meets the new of the other.
//!
//! | version | value |
//! |---|---|
//! | 1 | lane trims |
//! | 2 | lane trims, and the parameters that differ from what is built in |
//!
//! A map falls back to an older value where the latest is damaged: a half whose last value is not the one that is read
//! (`whole.rs`) does not count.
//!
//! | halves | what acts |
//! |---|---|
//! | the same record in both | it |
//! | a record in one, and an older one, nothing, or something that does not count in the other | the latest: [`StoredState::OneCopy`] |
//! | nothing in one, and in the other something that cannot be read | nothing: the first store was cut off, [`StoredState::Unfinished`] |
//! | something that does not count in both, or a record that cannot be | nothing: [`StoredState::Damaged`] |
//! | the latest is of another version | nothing: [`StoredState::Version`] |
//!
//! Looking never writes. A page's erase stalls a processor that runs from the same flash (25 ms on an STM32G4): store in silence only.

mod blocking;
mod whole;

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use serde::{Deserialize, Serialize};

use self::blocking::{Blocking, wait};
use self::whole::{ends_with, is_blank};
use crate::board::parameters::Overrides;
use crate::board::stored_state::StoredState;
use crate::generate::phasing::check_calibration;
use crate::seam::config::LaneTrims;
use crate::seam::error::{Error, in_range};

/// Key of the record in the two maps. A number never changes its meaning.
const RECORD: u8 = 1;
/// Version of the record as it is written now, and of lane trims alone.
const VERSION: u8 = 2;
const TRIMS_ALONE: u8 = 1;
/// Version and number.
const HEAD: usize = 5;
/// Room for the longest value with its key and version, bytes: a multiple of any flash's word.
const LONGEST: usize = 672;

/// The stored settings, which are written as a whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Trims of the lanes, by frequency.
    pub trims: LaneTrims,
    /// Parameters that differ from their defaults.
    pub parameters: Overrides,
}

impl Record {
    /// Whether there is nothing to store.
    pub fn is_empty(&self) -> bool {
        self.trims.is_empty() && self.parameters.is_empty()
    }
}

/// The flash has failed: what is stored is what was stored before, or the new in one of its two copies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotStored;

/// The settings in flash.
pub struct Settings<F> {
    flash: F,
    /// Bytes of each half.
    half: u32,
}

/// One half, for as long as it is read or written.
type Map<'a, F> = MapStorage<u8, Blocking<'a, F>, Cache<Uncached, Uncached, Uncached, u8>>;

/// What a half has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    /// Nothing was ever written to it.
    Blank,
    /// No value can be read in it.
    Unread,
    /// Its last value is damaged, or no record.
    Damaged,
    /// A value of this other version.
    Version(u8),
    /// A record.
    Record,
}

/// Content of a half.
#[derive(Clone, Copy)]
struct Found {
    /// Which write it was; of a half that does not count, that of an earlier one.
    number: u32,
    content: Content,
    /// It is what was expected.
    same: bool,
}

impl Found {
    /// Nothing that has a number.
    fn without(content: Content) -> Self {
        Found { number: 0, content, same: false }
    }

    /// Whether it says what was stored.
    fn counts(&self) -> bool {
        matches!(self.content, Content::Record | Content::Version(_))
    }

    fn is_newer_than(&self, other: &Found) -> bool {
        // Numbers come round.
        self.counts() && (!other.counts() || (self.number.wrapping_sub(other.number) as i32) > 0)
    }
}

/// What both halves have.
struct Halves {
    /// The half that was written last.
    newest: u32,
    found: [Found; 2],
}

impl Halves {
    fn latest(&self) -> &Found {
        &self.found[self.newest as usize]
    }

    fn other(&self) -> &Found {
        &self.found[1 - self.newest as usize]
    }

    fn state(&self) -> StoredState {
        let (latest, other) = (self.latest(), self.other());
        match (latest.content, other.content) {
            (Content::Record, Content::Record) if latest.number == other.number => StoredState::Stored,
            (Content::Record, _) => StoredState::OneCopy,
            (Content::Version(version), _) => StoredState::Version(version),
            (Content::Blank, Content::Blank) => StoredState::Nothing,
            (Content::Blank, Content::Unread) | (Content::Unread, Content::Blank) => StoredState::Unfinished,
            _ => StoredState::Damaged,
        }
    }

    /// Both have what was expected.
    fn same(&self) -> bool {
        self.state() == StoredState::Stored && self.found.iter().all(|found| found.same)
    }

    /// The number of the next write: what does not count is not to be taken for a later one.
    fn next_number(&self) -> u32 {
        let [first, second] = self.found.map(|found| found.number);
        let latest = match (self.latest().counts(), (first.wrapping_sub(second) as i32) > 0) {
            (true, _) => self.latest().number,
            (false, true) => first,
            (false, false) => second,
        };
        latest.wrapping_add(1)
    }
}

impl<F: NorFlash> Settings<F> {
    /// A store in all of this flash: a board gives the part of its own that is meant for it, four pages at least.
    pub fn new(flash: F) -> Result<Self, Error> {
        let (page, word) = (F::ERASE_SIZE, F::WRITE_SIZE.max(F::READ_SIZE));
        in_range("settings.flash_page_bytes", page as f64, 2.0 * LONGEST as f64, 1e9)?;
        in_range("settings.flash_word_bytes", word as f64, 1.0, 32.0)?;
        let half = flash.capacity() / (2 * page) * page;
        in_range("settings.flash_bytes", 2.0 * half as f64, 4.0 * page as f64, f64::from(u32::MAX))?;
        Ok(Settings { flash, half: half as u32 })
    }

    /// The stored record and its state; an empty record where nothing can be used.
    pub fn record(&mut self) -> (Record, StoredState) {
        let halves = self.look(&[]);
        let state = halves.state();
        let stored = matches!(state, StoredState::Stored | StoredState::OneCopy);
        let pages = self.pages(halves.newest);
        let record = match stored {
            true => read(&mut self.flash, pages, |_, bytes| decode(bytes)).ok().flatten().flatten(),
            false => None,
        };
        let record = record.unwrap_or_default();
        // A stored record may be an empty one.
        let state = if state == StoredState::Stored && record.is_empty() { StoredState::Nothing } else { state };
        (record, state)
    }

    /// How often settings were stored: each time wears the flash.
    pub fn stores(&mut self) -> u32 {
        self.look(&[]).next_number().wrapping_sub(1)
    }

    /// Stores a record, in both halves. A record that is stored already is not written again.
    pub fn store(&mut self, record: &Record) -> Result<(), NotStored> {
        let mut value = [0; LONGEST];
        let length = HEAD + postcard::to_slice(record, &mut value[HEAD..]).map_err(|_| NotStored)?.len();
        let halves = self.look(&value[HEAD..length]);
        if halves.same() || halves.state() == StoredState::Nothing && record.is_empty() {
            return Ok(());
        }
        value[0] = VERSION;
        value[1..HEAD].copy_from_slice(&halves.next_number().to_le_bytes());
        // The half that was written last stands until the other one has the new record.
        [1 - halves.newest, halves.newest].into_iter().try_for_each(|half| self.put(half, &value[..length]))
    }

    /// Writes a value into a half, and reads it back. A half that does not take it is erased first.
    fn put(&mut self, half: u32, value: &[u8]) -> Result<(), NotStored> {
        if self.write(half, value).is_ok() && self.keeps(half, value) {
            return Ok(());
        }
        let pages = self.pages(half);
        let mut map = map(Blocking::to_write(&mut self.flash), pages).ok_or(NotStored)?;
        wait(map.erase_all()).map_err(|_| NotStored)?;
        self.write(half, value)?;
        if self.keeps(half, value) { Ok(()) } else { Err(NotStored) }
    }

    /// Whether this is what would be read now: damage elsewhere in the half may hide what was written.
    fn keeps(&mut self, half: u32, value: &[u8]) -> bool {
        let found = self.look_at(half, &value[HEAD..]);
        found.content == Content::Record && found.same && value[1..HEAD] == found.number.to_le_bytes()
    }

    /// Clears the stored settings.
    pub fn clear(&mut self) -> Result<(), NotStored> {
        // Written over by nothing rather than erased: whenever power goes, it is all there or all gone.
        self.store(&Record::default())
    }

    /// Gives the flash back.
    pub fn release(self) -> F {
        self.flash
    }

    /// What both halves have; whether that is `expected`.
    fn look(&mut self, expected: &[u8]) -> Halves {
        let found = [0, 1].map(|half| self.look_at(half, expected));
        Halves { newest: found[1].is_newer_than(&found[0]).into(), found }
    }

    fn look_at(&mut self, half: u32, expected: &[u8]) -> Found {
        let (pages, flash) = (self.pages(half), &mut self.flash);
        match read(flash, pages.clone(), |flash, bytes| (look(bytes, expected), ends_with(flash, pages.clone(), RECORD, bytes))) {
            Ok(Some((Some(found), true))) => found,
            Ok(Some((found, _))) => Found { content: Content::Damaged, ..found.unwrap_or(Found::without(Content::Damaged)) },
            Ok(None) if is_blank(&mut self.flash, pages) => Found::without(Content::Blank),
            Ok(None) | Err(NotStored) => Found::without(Content::Unread),
        }
    }

    fn pages(&self, half: u32) -> Range<u32> {
        half * self.half..(half + 1) * self.half
    }

    fn write(&mut self, half: u32, value: &[u8]) -> Result<(), NotStored> {
        let mut buffer = [0; LONGEST];
        let pages = self.pages(half);
        let mut map = map(Blocking::to_write(&mut self.flash), pages).ok_or(NotStored)?;
        wait(map.store_item(&mut buffer, &RECORD, &value)).map_err(|_| NotStored)
    }
}

/// A half as a map.
fn map<F: NorFlash>(flash: Blocking<'_, F>, pages: Range<u32>) -> Option<Map<'_, F>> {
    Some(MapStorage::new(flash, MapConfig::try_new(pages).ok()?, Cache::new_uncached()))
}

/// What is made of the value in a half; none where there is none, and an error where none can be read.
fn read<F: NorFlash, T>(flash: &mut F, pages: Range<u32>, make: impl FnOnce(&mut F, &[u8]) -> T) -> Result<Option<T>, NotStored> {
    let mut buffer = [0; LONGEST];
    let mut map = map(Blocking::to_read(flash), pages).ok_or(NotStored)?;
    let bytes = wait(map.fetch_item::<&[u8]>(&mut buffer, &RECORD)).map_err(|_| NotStored)?;
    Ok(bytes.map(|bytes| make(map.destroy().0.release(), bytes)))
}

/// What a value is, and whether it is the expected one; `None` where it is too short for any.
fn look(bytes: &[u8], expected: &[u8]) -> Option<Found> {
    let (head, value) = bytes.split_at_checked(HEAD)?;
    let number = u32::from_le_bytes(head[1..].try_into().ok()?);
    let content = match head[0] {
        VERSION | TRIMS_ALONE if decode(bytes).is_some() => Content::Record,
        VERSION | TRIMS_ALONE => Content::Damaged,
        other => Content::Version(other),
    };
    Some(Found { number, content, same: head[0] == VERSION && value == expected })
}

/// The record in a value; `None` where it is damaged, or of another version. Not inlined: a record is not to stand on the stack for longer.
#[inline(never)]
fn decode(bytes: &[u8]) -> Option<Record> {
    let (head, value) = bytes.split_at_checked(HEAD)?;
    let record = match head[0] {
        VERSION => postcard::from_bytes::<Record>(value).ok()?,
        TRIMS_ALONE => Record { trims: postcard::from_bytes(value).ok()?, parameters: Overrides::new() },
        _ => return None,
    };
    check_calibration(&record.trims).is_ok().then_some(record)
}

#[cfg(test)]
mod tests;
