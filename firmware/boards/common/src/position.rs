//! Position of DMA in a ring.

/// Returns the place in a ring of `N` that DMA reaches next, from the number of remaining
/// transfers.
///
/// The counter of DMA counts down and restarts at `N`. A DMA controller that shows an address
/// instead needs no conversion: the position is that address minus the address of the ring, in
/// transfers.
#[inline]
pub fn position<const N: usize>(remaining: usize) -> usize {
    N.wrapping_sub(remaining) % N
}
