//! The reading end of a ring of bytes that DMA fills.
//!
//! DMA does not wait: if more than the ring holds arrives between two reads, whole rounds are lost, and the checksum of the frames shows it.

/// The position of the reader in a ring of `N` bytes.
#[derive(Clone, Debug, Default)]
pub struct Reader<const N: usize> {
    next: usize,
}

impl<const N: usize> Reader<N> {
    /// Bytes that wait to be read, from the number of transfers that remain until DMA starts again at `N`.
    pub fn waiting(&self, remaining: u16) -> usize {
        let filled = N.wrapping_sub(remaining.into()) % N;
        (filled + N - self.next) % N
    }

    /// The place of the next byte; `None` while nothing waits.
    pub fn take(&mut self, remaining: u16) -> Option<usize> {
        if self.waiting(remaining) == 0 {
            return None;
        }
        let place = self.next;
        self.next = (place + 1) % N;
        Some(place)
    }
}
