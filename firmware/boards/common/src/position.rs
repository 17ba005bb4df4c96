//! The place in a ring that DMA comes to next.

/// Transfers that DMA has made in this round of a ring of `N`, from the number that remains: it
/// counts down and starts again at `N`.
///
/// A controller of DMA that shows an address instead gives the position by itself: the address less
/// that of the ring, in transfers.
#[inline]
pub fn position<const N: usize>(remaining: usize) -> usize {
    N.wrapping_sub(remaining) % N
}
