//! Settings: what is kept in flash over power-off.
//!
//! A map of keys to values (`sequential-storage`): a value that is written leaves the one before it as it is until it is whole, so that whenever
//! power goes, one of the two is there. Pages are used in turns, which spreads the wear.
//!
//! ```text
//! key: u8 | version of the value: u8 | value: postcard
//! ```
//!
//! What cannot be read, is of another version, or cannot be trims, is as if there were nothing, and says why. A page's erase stalls a processor
//! that runs from the same flash (25 ms on an STM32G4): store in silence only.

use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_storage::nor_flash::{ErrorType, NorFlash};
use embedded_storage_async::nor_flash as waiting;
use sequential_storage::Error as StoreError;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use serde::{Deserialize, Serialize};

use crate::config::LaneTrims;
use crate::error::{Error, in_range};
use crate::phasing::check_calibration;

/// Keys. A number never changes its meaning.
const LANE_TRIMS: u8 = 1;
/// Version of the lane trims as they are written now.
const VERSION: u8 = 1;
/// Room for the longest value with its key and version, bytes: a multiple of any flash's word.
const LONGEST: usize = 256;

/// What is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kept {
    /// Nothing.
    #[default]
    Nothing,
    /// What acted when it was stored, or came from there at power-up.
    Stored,
    /// Something that cannot be read, or cannot be trims.
    Damaged,
    /// Trims of this other version.
    Version(u8),
    /// What acts is to be kept, as soon as the drive is silent.
    Due,
    /// The flash does not take it.
    Failed,
}

/// The flash has failed, and settings are not kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotKept;

/// The store.
pub struct Settings<F: NorFlash> {
    map: MapStorage<u8, Blocking<F>, Cache<Uncached, Uncached, Uncached, u8>>,
}

impl<F: NorFlash> Settings<F> {
    /// A store in all of this flash: a board gives the part of its own that is meant for it, two pages at least.
    pub fn new(flash: F) -> Result<Self, Error> {
        let (page, word) = (F::ERASE_SIZE, F::WRITE_SIZE.max(F::READ_SIZE));
        in_range("settings.flash_page_bytes", page as f64, 2.0 * LONGEST as f64, 1e9)?;
        in_range("settings.flash_word_bytes", word as f64, 1.0, 32.0)?;
        let bytes = flash.capacity() - flash.capacity() % page;
        let (min, max) = (2.0 * page as f64, f64::from(u32::MAX));
        let value = in_range("settings.flash_bytes", bytes as f64, min, max)?;
        let config = MapConfig::try_new(0..bytes as u32);
        let config = config.map_err(|_| Error::OutOfRange { parameter: "settings.flash_bytes", value, min, max })?;
        Ok(Settings { map: MapStorage::new(Blocking(flash), config, Cache::new_uncached()) })
    }

    /// The lane trims that are kept; none where there is nothing that can be used, and why.
    pub fn lane_trims(&mut self) -> (LaneTrims, Kept) {
        let mut buffer = [0; LONGEST];
        let (trims, kept) = match wait(self.map.fetch_item::<&[u8]>(&mut buffer, &LANE_TRIMS)) {
            Ok(None) => (LaneTrims::new(), Kept::Nothing),
            Ok(Some(bytes)) => read(bytes),
            Err(_) => (LaneTrims::new(), Kept::Damaged),
        };
        // That there are none is kept as such.
        let nothing = kept == Kept::Stored && trims.is_empty();
        (trims, if nothing { Kept::Nothing } else { kept })
    }

    /// Keeps lane trims. What is kept already is not written again.
    pub fn store(&mut self, trims: &LaneTrims) -> Result<(), NotKept> {
        if matches!(self.lane_trims(), (same, Kept::Stored | Kept::Nothing) if same == *trims) {
            return Ok(());
        }
        let (mut value, mut buffer) = ([0; LONGEST], [0; LONGEST]);
        value[0] = VERSION;
        let length = postcard::to_slice(trims, &mut value[1..]).map_err(|_| NotKept)?.len();
        let value: &[u8] = &value[..=length];
        match wait(self.map.store_item(&mut buffer, &LANE_TRIMS, &value)) {
            Ok(()) => return Ok(()),
            // The flash itself has failed: what is there may still be whole.
            Err(StoreError::Storage { .. }) => return Err(NotKept),
            Err(_) => {}
        }
        // Beyond repair: everything is erased, and this is the first to be there again.
        wait(self.map.erase_all()).map_err(|_| NotKept)?;
        wait(self.map.store_item(&mut buffer, &LANE_TRIMS, &value)).map_err(|_| NotKept)
    }

    /// Keeps nothing.
    pub fn clear(&mut self) -> Result<(), NotKept> {
        // Written over by nothing rather than erased: whenever power goes, it is all there or all gone.
        self.store(&LaneTrims::new())
    }

    /// Gives the flash back.
    pub fn release(self) -> F {
        self.map.destroy().0.0
    }
}

/// Version and value.
fn read(bytes: &[u8]) -> (LaneTrims, Kept) {
    let trims = match bytes.split_first() {
        Some((&VERSION, value)) => postcard::from_bytes::<LaneTrims>(value).ok(),
        Some((&other, _)) => return (LaneTrims::new(), Kept::Version(other)),
        None => None,
    };
    match trims.filter(|trims| check_calibration(trims).is_ok()) {
        Some(trims) => (trims, Kept::Stored),
        None => (LaneTrims::new(), Kept::Damaged),
    }
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
