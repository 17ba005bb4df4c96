//! The reading end of a ring of bytes that DMA fills.
//!
//! DMA does not wait: if more than the ring holds comes between two looks, whole rounds are lost, and the checksum of the frames shows it.

/// Where the reader of a ring of `N` bytes is.
#[derive(Clone, Debug, Default)]
pub struct Reader<const N: usize> {
    next: usize,
}

impl<const N: usize> Reader<N> {
    /// Bytes that wait, of what DMA has filled, by how many it says remain until it begins again at `N`.
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
