//! Reading end of a ring of bytes that DMA fills.
//!
//! DMA does not wait. If more bytes than the ring holds arrive between two reads, whole rounds are
//! lost, and the checksums of the frames detect it.

/// Position of the reader in a ring of `N` bytes.
#[derive(Clone, Debug, Default)]
pub struct Reader<const N: usize> {
    next: usize,
}

impl<const N: usize> Reader<N> {
    /// Returns the number of unread bytes. `filled` is the [position](crate::position::position)
    /// that DMA fills next.
    #[inline]
    pub fn waiting(&self, filled: usize) -> usize {
        (filled + N - self.next) % N
    }

    /// Returns the place of the next byte and moves on. Returns `None` if no byte waits.
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
