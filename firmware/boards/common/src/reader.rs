//! The reading end of a ring of bytes that DMA fills.
//!
//! DMA does not wait: if more than the ring holds arrives between two reads, whole rounds are lost,
//! and the checksum of the frames shows it.

/// The position of the reader in a ring of `N` bytes.
#[derive(Clone, Debug, Default)]
pub struct Reader<const N: usize> {
    next: usize,
}

impl<const N: usize> Reader<N> {
    /// Bytes that wait to be read, from the [position](crate::position::position) that DMA fills
    /// next.
    #[inline]
    pub fn waiting(&self, filled: usize) -> usize {
        (filled + N - self.next) % N
    }

    /// The place of the next byte; `None` while nothing waits.
    #[inline]
    pub fn take(&mut self, filled: usize) -> Option<usize> {
        if self.waiting(filled) == 0 {
            return None;
        }
        let place = self.next;
        self.next = (place + 1) % N;
        Some(place)
    }
}
