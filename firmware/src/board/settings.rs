//! Settings stored in flash.
//!
//! Each half of the flash is a map of keys to values (`sequential-storage`), and both have the same
//! record with the same number. A store writes the record into one half, reads it back, and writes
//! it into the other. Therefore one half is intact whenever power fails, and a word that is damaged
//! later leaves the other copy. Pages are used in turn, which spreads the wear.
//!
//! ```text
//! key: u8 | version of the value: u8 | number of the write: u32, little-endian | value: postcard
//! ```
//!
//! Lane trims and parameters are one value, so that old trims never meet new parameters.
//!
//! | version | value |
//! |---|---|
//! | 1 | lane trims |
//! | 2 | lane trims, and the parameters that differ from the built-in values |
//!
//! A map falls back to an older value if the latest is damaged. Therefore a half is valid only if
//! the value that is read is the last one written (`whole.rs`).
//!
//! | halves | active |
//! |---|---|
//! | the same record in both | this record |
//! | a record in one; an older one, nothing, or an invalid value in the other | the latest record: [`StoredState::OneCopy`] |
//! | nothing in one; unreadable data in the other | nothing: the first store was cut off, [`StoredState::Unfinished`] |
//! | invalid values in both, or a record with invalid content | nothing: [`StoredState::Damaged`] |
//! | the latest is of another version | nothing: [`StoredState::Version`] |
//! | nothing in one or both, although the marker shows a store | nothing: [`StoredState::Damaged`] |
//!
//! The marker is the last word of a page before the halves, and is never erased here. If that page
//! also holds data of others who erase it, the marker is written again.
//!
//! Reading never writes. Erasing a page stalls a processor that runs from the same flash (25 ms on
//! an STM32G4): store in silence only.

mod blocking;
mod whole;

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use serde::{Deserialize, Serialize};

use self::blocking::{Blocking, wait};
use self::whole::{MAX_WORD_BYTES, ends_with, is_blank, is_marked, word};
use crate::board::parameters::Overrides;
use crate::board::stored_state::StoredState;
use crate::generate::phasing::check_calibration;
use crate::seam::config::LaneTrims;
use crate::seam::error::{Error, in_range};

/// Key of the record in the two maps. A key never changes its meaning.
const RECORD_KEY: u8 = 1;
/// Version of the record as it is written now.
const VERSION: u8 = 2;
/// Version of a record of lane trims alone.
const TRIMS_ONLY_VERSION: u8 = 1;
/// Length of version and number, bytes.
const HEAD_BYTES: usize = 5;
/// Length of the longest value with its key and version, bytes: a multiple of any flash's word.
const MAX_VALUE_BYTES: usize = 704;

/// Stored settings, which are written as a whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Trims of the lanes, by frequency.
    pub trims: LaneTrims,
    /// Parameters that differ from their defaults.
    pub parameters: Overrides,
}

impl Record {
    /// Returns `true` if there is nothing to store.
    pub fn is_empty(&self) -> bool {
        self.trims.is_empty() && self.parameters.is_empty()
    }
}

/// Failure of the flash: the previous record remains stored, or one of the two copies has the new
/// one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotStored;

/// The settings in flash.
pub struct Settings<F> {
    flash: F,
    /// Offset of the first half, after the page of the marker; 0 without a marker.
    first: u32,
    /// Length of each half, bytes.
    half: u32,
}

/// Map in one half, for as long as it is read or written.
type Map<'a, F> = MapStorage<u8, Blocking<'a, F>, Cache<Uncached, Uncached, Uncached, u8>>;

/// Content of a half.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    /// The half was never written.
    Blank,
    /// The half contains no readable value.
    Unread,
    /// The last value is damaged, or not a record.
    Damaged,
    /// A value of this other version.
    Version(u8),
    /// A record.
    Record,
}

/// Value found in a half.
#[derive(Clone, Copy)]
struct HalfValue {
    /// Number of the write; in an invalid half, that of an earlier write.
    number: u32,
    content: Content,
    /// `true` if the value is the expected one.
    is_expected: bool,
}

impl HalfValue {
    /// Creates a result for a half without a number.
    fn from_content(content: Content) -> Self {
        HalfValue { number: 0, content, is_expected: false }
    }

    /// Returns `true` if the half is valid.
    fn is_valid(&self) -> bool {
        matches!(self.content, Content::Record | Content::Version(_))
    }

    fn is_newer_than(&self, other: &HalfValue) -> bool {
        // Numbers wrap.
        self.is_valid() && (!other.is_valid() || (self.number.wrapping_sub(other.number) as i32) > 0)
    }
}

/// Content of both halves.
struct Halves {
    /// Half that was written last.
    newest: u32,
    found: [HalfValue; 2],
    /// `true` if the marker shows that settings were stored.
    is_marked: bool,
}

impl Halves {
    fn latest(&self) -> &HalfValue {
        &self.found[self.newest as usize]
    }

    fn other(&self) -> &HalfValue {
        &self.found[1 - self.newest as usize]
    }

    fn state(&self) -> StoredState {
        let (latest, other) = (self.latest(), self.other());
        match (latest.content, other.content) {
            (Content::Record, Content::Record) if latest.number == other.number => StoredState::Stored,
            (Content::Record, _) => StoredState::OneCopy,
            (Content::Version(version), _) => StoredState::Version(version),
            _ if self.is_marked => StoredState::Damaged,
            (Content::Blank, Content::Blank) => StoredState::Nothing,
            (Content::Blank, Content::Unread) | (Content::Unread, Content::Blank) => StoredState::Unfinished,
            _ => StoredState::Damaged,
        }
    }

    /// Returns `true` if both halves have the expected record.
    fn match_expected(&self) -> bool {
        self.state() == StoredState::Stored && self.found.iter().all(|found| found.is_expected)
    }

    /// Returns the number of the next write. Ignores the number of an invalid half if the other
    /// half is valid.
    fn next_number(&self) -> u32 {
        let [first, second] = self.found.map(|found| found.number);
        let latest = match (self.latest().is_valid(), (first.wrapping_sub(second) as i32) > 0) {
            (true, _) => self.latest().number,
            (false, true) => first,
            (false, false) => second,
        };
        latest.wrapping_add(1)
    }
}

impl<F: NorFlash> Settings<F> {
    /// Creates a store in all of this flash, which has four pages at least. A board passes the part
    /// that it reserves for settings. If the number of pages is odd, the first one has the marker.
    pub fn new(flash: F) -> Result<Self, Error> {
        let page = F::ERASE_SIZE;
        in_range("settings.flash_page_bytes", page as f64, 2.0 * MAX_VALUE_BYTES as f64, 1e9)?;
        in_range("settings.flash_word_bytes", f64::from(word::<F>()), 1.0, MAX_WORD_BYTES as f64)?;
        let half = flash.capacity() / (2 * page) * page;
        in_range("settings.flash_bytes", 2.0 * half as f64, 4.0 * page as f64, f64::from(u32::MAX))?;
        let first = flash.capacity() / page % 2 * page;
        Ok(Settings { flash, first: first as u32, half: half as u32 })
    }

    /// Returns the stored record and its state; an empty record if none can be used.
    pub fn record(&mut self) -> (Record, StoredState) {
        let halves = self.inspect(&[]);
        let state = halves.state();
        let stored = matches!(state, StoredState::Stored | StoredState::OneCopy);
        let pages = self.pages(halves.newest);
        let record = match stored {
            true => read(&mut self.flash, pages, |_, bytes| decode(bytes)).ok().flatten().flatten(),
            false => None,
        };
        let record = record.unwrap_or_default();
        // A stored record may be empty.
        let state = if state == StoredState::Stored && record.is_empty() { StoredState::Nothing } else { state };
        (record, state)
    }

    /// Returns the number of stores so far; each wears the flash.
    pub fn stores(&mut self) -> u32 {
        self.inspect(&[]).next_number().wrapping_sub(1)
    }

    /// Stores a record in both halves, and then writes the marker. A record that is already stored
    /// is not written again.
    pub fn store(&mut self, record: &Record) -> Result<(), NotStored> {
        let mut value = [0; MAX_VALUE_BYTES];
        let length = HEAD_BYTES + postcard::to_slice(record, &mut value[HEAD_BYTES..]).map_err(|_| NotStored)?.len();
        let halves = self.inspect(&value[HEAD_BYTES..length]);
        if halves.match_expected() {
            return self.mark();
        }
        if halves.state() == StoredState::Nothing && record.is_empty() {
            return Ok(());
        }
        value[0] = VERSION;
        value[1..HEAD_BYTES].copy_from_slice(&halves.next_number().to_le_bytes());
        // The half that was written last stays intact until the other one has the new record.
        [1 - halves.newest, halves.newest].into_iter().try_for_each(|half| self.put(half, &value[..length]))?;
        self.mark()
    }

    /// Writes the marker, if there is a place for it and it is blank.
    pub(crate) fn mark(&mut self) -> Result<(), NotStored> {
        if self.first == 0 || self.read_marker() {
            return Ok(());
        }
        let word = word::<F>();
        self.flash.write(self.first - word, &[0; MAX_WORD_BYTES][..word as usize]).map_err(|_| NotStored)
    }

    /// Reads the marker: `true` if it was written, or cannot be read.
    fn read_marker(&mut self) -> bool {
        self.first > 0 && is_marked(&mut self.flash, self.first - F::READ_SIZE as u32) != Some(false)
    }

    /// Writes a value into a half, and reads it back. If that fails, erases the half and tries
    /// again.
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

    /// Returns `true` if this value would be read now: damage elsewhere in the half may hide it.
    fn keeps(&mut self, half: u32, value: &[u8]) -> bool {
        let found = self.inspect_half(half, &value[HEAD_BYTES..]);
        found.content == Content::Record && found.is_expected && value[1..HEAD_BYTES] == found.number.to_le_bytes()
    }

    /// Clears the stored settings.
    pub fn clear(&mut self) -> Result<(), NotStored> {
        // Overwritten with an empty record, not erased: if power fails, either all or nothing is
        // left.
        self.store(&Record::default())
    }

    /// Returns the flash.
    pub fn release(self) -> F {
        self.flash
    }

    /// Reads both halves, and compares their values with `expected`.
    fn inspect(&mut self, expected: &[u8]) -> Halves {
        let found = [0, 1].map(|half| self.inspect_half(half, expected));
        Halves { newest: found[1].is_newer_than(&found[0]).into(), found, is_marked: self.read_marker() }
    }

    fn inspect_half(&mut self, half: u32, expected: &[u8]) -> HalfValue {
        let (pages, flash) = (self.pages(half), &mut self.flash);
        match read(flash, pages.clone(), |flash, bytes| {
            (inspect(bytes, expected), ends_with(flash, pages.clone(), RECORD_KEY, bytes))
        }) {
            Ok(Some((Some(found), true))) => found,
            Ok(Some((found, _))) => {
                HalfValue { content: Content::Damaged, ..found.unwrap_or(HalfValue::from_content(Content::Damaged)) }
            }
            Ok(None) if is_blank(&mut self.flash, pages) => HalfValue::from_content(Content::Blank),
            Ok(None) | Err(NotStored) => HalfValue::from_content(Content::Unread),
        }
    }

    fn pages(&self, half: u32) -> Range<u32> {
        let from = self.first + half * self.half;
        from..from + self.half
    }

    fn write(&mut self, half: u32, value: &[u8]) -> Result<(), NotStored> {
        let mut buffer = [0; MAX_VALUE_BYTES];
        let pages = self.pages(half);
        let mut map = map(Blocking::to_write(&mut self.flash), pages).ok_or(NotStored)?;
        wait(map.store_item(&mut buffer, &RECORD_KEY, &value)).map_err(|_| NotStored)
    }
}

/// Returns a half as a map.
fn map<F: NorFlash>(flash: Blocking<'_, F>, pages: Range<u32>) -> Option<Map<'_, F>> {
    Some(MapStorage::new(flash, MapConfig::try_new(pages).ok()?, Cache::new_uncached()))
}

/// Reads the value in a half, and applies `make` to it. Returns `None` without a value, and an
/// error if none can be read.
fn read<F: NorFlash, T>(flash: &mut F, pages: Range<u32>, make: impl FnOnce(&mut F, &[u8]) -> T) -> Result<Option<T>, NotStored> {
    let mut buffer = [0; MAX_VALUE_BYTES];
    let mut map = map(Blocking::to_read(flash), pages).ok_or(NotStored)?;
    let bytes = wait(map.fetch_item::<&[u8]>(&mut buffer, &RECORD_KEY)).map_err(|_| NotStored)?;
    Ok(bytes.map(|bytes| make(map.destroy().0.release(), bytes)))
}

/// Returns the content of a value, compared with the expected one; `None` if it is too short.
fn inspect(bytes: &[u8], expected: &[u8]) -> Option<HalfValue> {
    let (head, value) = bytes.split_at_checked(HEAD_BYTES)?;
    let number = u32::from_le_bytes(head[1..].try_into().ok()?);
    let content = match head[0] {
        VERSION | TRIMS_ONLY_VERSION if decode(bytes).is_some() => Content::Record,
        VERSION | TRIMS_ONLY_VERSION => Content::Damaged,
        other => Content::Version(other),
    };
    Some(HalfValue { number, content, is_expected: head[0] == VERSION && value == expected })
}

/// Decodes the record in a value; `None` if it is damaged, or of another version. Not inlined, so
/// that the record does not stay on the stack.
#[inline(never)]
fn decode(bytes: &[u8]) -> Option<Record> {
    let (head, value) = bytes.split_at_checked(HEAD_BYTES)?;
    let record = match head[0] {
        VERSION => postcard::from_bytes::<Record>(value).ok()?,
        TRIMS_ONLY_VERSION => Record { trims: postcard::from_bytes(value).ok()?, parameters: Overrides::new() },
        _ => return None,
    };
    check_calibration(&record.trims).is_ok().then_some(record)
}

#[cfg(test)]
mod tests;
