//! Settings stored in flash.
//!
//! Two maps of keys to values (`sequential-storage`), each in its half of the flash, and written in turns: whenever power goes, and however
//! often, the previous record is in the half that was not being written. One map alone survives one cut: what a cut has left it repairs by
//! erasing the page that it was writing to, and a second cut then finds neither the old nor the new. Pages are used in turns too, which spreads
//! the wear.
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
//! What cannot be read, is of another version, or cannot be trims, is as if there were nothing, and says why. A page's erase stalls a processor
//! that runs from the same flash (25 ms on an STM32G4): store in silence only.

use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_storage::nor_flash::{ErrorType, NorFlash};
use embedded_storage_async::nor_flash as waiting;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use serde::{Deserialize, Serialize};

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

/// The flash has failed, and settings are not stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotStored;

/// The settings in flash.
pub struct Settings<F> {
    flash: F,
    /// Bytes of each half.
    half: u32,
}

/// One half, for as long as it is read or written.
type Map<'a, F> = MapStorage<u8, Blocking<&'a mut F>, Cache<Uncached, Uncached, Uncached, u8>>;

/// Content of a half.
struct Found {
    /// Which write it was.
    number: u32,
    state: StoredState,
    /// It is what was expected.
    same: bool,
}

impl Found {
    /// Nothing that has a number.
    fn without(state: StoredState) -> Self {
        Found { number: 0, state, same: false }
    }

    fn is_newer_than(&self, other: &Found) -> bool {
        match (self.state, other.state) {
            // What cannot be read has no number.
            (StoredState::Nothing, _) => false,
            (_, StoredState::Nothing) => true,
            (StoredState::Damaged, _) => false,
            (_, StoredState::Damaged) => true,
            // Numbers come round.
            _ => (self.number.wrapping_sub(other.number) as i32) > 0,
        }
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
        let (half, latest) = self.latest(&[]);
        let stored = latest.state == StoredState::Stored;
        let record = if stored { self.read(half, decode).ok().flatten().unwrap_or_default() } else { Record::default() };
        // A stored record may be an empty one.
        let state = if stored && record.is_empty() { StoredState::Nothing } else { latest.state };
        (record, state)
    }

    /// Stores a record. A record that is stored already is not written again.
    pub fn store(&mut self, record: &Record) -> Result<(), NotStored> {
        let mut value = [0; LONGEST];
        let length = HEAD + postcard::to_slice(record, &mut value[HEAD..]).map_err(|_| NotStored)?.len();
        let (half, latest) = self.latest(&value[HEAD..length]);
        if latest.state == StoredState::Stored && latest.same || latest.state == StoredState::Nothing && record.is_empty() {
            return Ok(());
        }
        value[0] = VERSION;
        value[1..HEAD].copy_from_slice(&latest.number.wrapping_add(1).to_le_bytes());
        let value = &value[..length];
        // Into the other half. If that is beyond repair it is erased first: the previous record is in this one.
        if self.write(1 - half, value).is_ok() && self.keeps(value) {
            return Ok(());
        }
        let mut map = self.map(1 - half).ok_or(NotStored)?;
        wait(map.erase_all()).map_err(|_| NotStored)?;
        self.write(1 - half, value)?;
        if self.keeps(value) { Ok(()) } else { Err(NotStored) }
    }

    /// Whether this is what would be read now: damage elsewhere in the flash may hide what was written.
    fn keeps(&mut self, value: &[u8]) -> bool {
        let latest = self.latest(&value[HEAD..]).1;
        latest.state == StoredState::Stored && latest.same
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

    /// The half that was written last, and what it has; whether that is `expected`.
    fn latest(&mut self, expected: &[u8]) -> (u32, Found) {
        let [first, second] = [0, 1].map(|half| match self.read(half, |bytes| look(bytes, expected)) {
            Ok(Some(found)) => found,
            Ok(None) => Found::without(StoredState::Nothing),
            Err(NotStored) => Found::without(StoredState::Damaged),
        });
        if second.is_newer_than(&first) { (1, second) } else { (0, first) }
    }

    fn map(&mut self, half: u32) -> Option<Map<'_, F>> {
        let config = MapConfig::try_new(half * self.half..(half + 1) * self.half).ok()?;
        Some(MapStorage::new(Blocking(&mut self.flash), config, Cache::new_uncached()))
    }

    /// What is made of the value in a half; none where there is none, and an error where nothing can be made of it.
    fn read<T>(&mut self, half: u32, make: impl FnOnce(&[u8]) -> Option<T>) -> Result<Option<T>, NotStored> {
        let mut buffer = [0; LONGEST];
        let mut map = self.map(half).ok_or(NotStored)?;
        match wait(map.fetch_item::<&[u8]>(&mut buffer, &RECORD)) {
            Ok(Some(bytes)) => make(bytes).map(Some).ok_or(NotStored),
            Ok(None) => Ok(None),
            Err(_) => Err(NotStored),
        }
    }

    fn write(&mut self, half: u32, value: &[u8]) -> Result<(), NotStored> {
        let mut buffer = [0; LONGEST];
        let mut map = self.map(half).ok_or(NotStored)?;
        wait(map.store_item(&mut buffer, &RECORD, &value)).map_err(|_| NotStored)
    }
}

/// What a value is, and whether it is the expected one; `None` where it is damaged.
fn look(bytes: &[u8], expected: &[u8]) -> Option<Found> {
    let (head, value) = bytes.split_at_checked(HEAD)?;
    let number = u32::from_le_bytes(head[1..].try_into().ok()?);
    let state = match head[0] {
        VERSION | TRIMS_ALONE => decode(bytes).map(|_| StoredState::Stored)?,
        other => StoredState::Version(other),
    };
    Some(Found { number, state, same: head[0] == VERSION && value == expected })
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

/// A flash that makes its caller wait, as one that is waited for.
struct Blocking<F>(F);

impl<F: ErrorType> ErrorType for Blocking<F> {
    type Error = F::Error;
}

impl<F: NorFlash> waiting::ReadNorFlash for Blocking<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), F::Error> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl<F: NorFlash> waiting::NorFlash for Blocking<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), F::Error> {
        self.0.erase(from, to)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), F::Error> {
        self.0.write(offset, bytes)
    }
}

/// What a future comes to. Those of a blocking flash never have to be asked twice.
fn wait<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
    }
}

#[cfg(test)]
mod tests;
