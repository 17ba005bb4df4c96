//! Number of blocks of this run. The time base of everything slower than a block.

use core::sync::atomic::{AtomicU32, Ordering};

static BLOCKS: AtomicU32 = AtomicU32::new(0);

/// Returns the number of completed blocks; it wraps.
pub fn blocks() -> u32 {
    BLOCKS.load(Ordering::Relaxed)
}

/// Counts a completed block.
pub fn count_block() {
    BLOCKS.fetch_add(1, Ordering::Relaxed);
}
