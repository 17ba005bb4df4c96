//! Where the codes of a block stand in the ring that DMA plays, and until when they may be written.
//!
//! A converter fetches a word before it plays it: a DAC with a holding register one trigger before,
//! one behind a buffer as many as the buffer holds. That number is `AHEAD`, and the codes of a half
//! stand so many places early:
//!
//! ```text
//! AHEAD = 1           first half             second half
//! ring of the ADC     a0  a1  a2  a3         b0  b1  b2  b3
//! ring of the DAC     a1  a2  a3  b0         b1  b2  b3  a0
//! ```

use crate::half::Half;

impl<const RING: usize> Half<RING> {
    /// The place of a half's sample in the DAC's ring.
    #[inline]
    pub fn slot<const AHEAD: usize>(self, sample: usize) -> usize {
        (self.start() + sample + RING - AHEAD) % RING
    }

    /// The places of a half's samples in the DAC's ring: those of the first `AHEAD`, and those of
    /// the others.
    #[inline]
    pub fn played<const AHEAD: usize, Place>(self, ring: &[Place; RING]) -> (&[Place; AHEAD], &[Place]) {
        const { assert!(AHEAD < Self::BLOCK, "a converter holds less than a block") };
        let start = self.start();
        // What is early for the first half stands at the end of the ring.
        let end = if start == 0 { RING } else { start };
        let Some(head) = ring[end - AHEAD..end].first_chunk() else { unreachable!("it has as many") };
        (head, &ring[start..start + Self::BLOCK - AHEAD])
    }

    /// Whether the codes written for this half are there before they are fetched, with a sample to
    /// spare. `next` is the place that DMA fetches next.
    #[inline]
    pub fn is_in_time<const AHEAD: usize>(self, next: usize) -> bool {
        Self::at(next + AHEAD) == self.other()
    }
}
