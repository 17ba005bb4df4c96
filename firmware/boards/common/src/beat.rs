//! Counter of missed blocks, derived from the processor's cycle counter.
//!
//! ```text
//! due = round((now - last) / CYCLES_PER_BLOCK),    missed = due - 1      (cycles; the counter wraps)
//! ```

/// Counter of blocks that were due but were not served.
#[derive(Clone, Debug, Default)]
pub struct Beat<const CYCLES_PER_BLOCK: u32> {
    last: Option<u32>,
}

impl<const CYCLES_PER_BLOCK: u32> Beat<CYCLES_PER_BLOCK> {
    /// Returns the number of blocks missed since the last call.
    ///
    /// A call may be late or early by less than half a block.
    #[inline]
    pub fn missed(&mut self, now: u32) -> u32 {
        let last = self.last.replace(now).unwrap_or(now.wrapping_sub(CYCLES_PER_BLOCK));
        let due = (now.wrapping_sub(last) + CYCLES_PER_BLOCK / 2) / CYCLES_PER_BLOCK;
        due.saturating_sub(1)
    }
}
