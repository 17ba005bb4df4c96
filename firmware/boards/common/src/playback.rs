//! Places of a block's codes in the ring that DMA plays, and the deadline for writing them.
//!
//! A converter fetches words before it plays them: a DAC with a holding register fetches one word
//! ahead, a DAC with a buffer as many words as the buffer holds. This number is `AHEAD`. The codes
//! of a half are stored `AHEAD` places early:
//!
//! ```text
//! AHEAD = 1           first half             second half
//! ring of the ADC     a0  a1  a2  a3         b0  b1  b2  b3
//! ring of the DAC     a1  a2  a3  b0         b1  b2  b3  a0
//! ```

use crate::half::Half;

impl<const RING: usize> Half<RING> {
    /// Returns the place of a sample of this half in the DAC's ring.
    #[inline]
    pub fn slot<const AHEAD: usize>(self, sample: usize) -> usize {
        (self.start() + sample + RING - AHEAD) % RING
    }

    /// Returns the places of this half in the DAC's ring: the first `AHEAD` places, then the
    /// others.
    #[inline]
    pub fn played<const AHEAD: usize, Place>(self, ring: &[Place; RING]) -> (&[Place; AHEAD], &[Place]) {
        const { assert!(AHEAD < Self::BLOCK, "a converter holds less than a block") };
        let start = self.start();
        // The early places of the first half are at the end of the ring.
        let end = if start == 0 { RING } else { start };
        let Some(head) = ring[end - AHEAD..end].first_chunk() else { unreachable!("the slice has AHEAD places") };
        (head, &ring[start..start + Self::BLOCK - AHEAD])
    }

    /// Returns `true` if the codes of this half were written before they are fetched, with one
    /// sample to spare. `next` is the place that DMA fetches next.
    #[inline]
    pub fn is_in_time<const AHEAD: usize>(self, next: usize) -> bool {
        Self::at(next + AHEAD) == self.other()
    }
}
