//! Adapter from a blocking flash to an asynchronous one.

use core::future::Future;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};
use embedded_storage_async::nor_flash as waiting;

/// Flash for reading, or for writing.
pub(super) struct Blocking<'a, F> {
    flash: &'a mut F,
    writes: bool,
}

impl<'a, F> Blocking<'a, F> {
    /// Wraps a flash for reading. A map repairs damage as it reads, by erasing; here it cannot.
    pub(super) fn to_read(flash: &'a mut F) -> Self {
        Blocking { flash, writes: false }
    }

    pub(super) fn to_write(flash: &'a mut F) -> Self {
        Blocking { flash, writes: true }
    }

    /// Returns the flash.
    pub(super) fn release(self) -> &'a mut F {
        self.flash
    }

    fn done<E>(result: Result<(), E>) -> Result<(), Failed> {
        result.map_err(|_| Failed)
    }
}

/// Failure of the flash, or an attempt to write to one that is only for reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Failed;

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl<F> waiting::ErrorType for Blocking<'_, F> {
    type Error = Failed;
}

impl<F: NorFlash> waiting::ReadNorFlash for Blocking<'_, F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        Self::done(self.flash.read(offset, bytes))
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl<F: NorFlash> waiting::NorFlash for Blocking<'_, F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        if self.writes { Self::done(self.flash.erase(from, to)) } else { Err(Failed) }
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        if self.writes { Self::done(self.flash.write(offset, bytes)) } else { Err(Failed) }
    }
}

/// Returns the result of a future. Futures of a blocking flash are ready at the first poll.
pub(super) fn wait<T>(future: impl Future<Output = T>) -> T {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(value) = future.as_mut().poll(&mut context) {
            return value;
        }
    }
}
