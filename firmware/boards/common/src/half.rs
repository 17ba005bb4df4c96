//! Halves of a ring of two blocks, which DMA and the interrupt use in turn.
//!
//! Two rings of two blocks each, one that DMA fills from the ADC and one that it plays to the DAC,
//! both at the sample rate. While DMA is in one half of both, the other half belongs to the
//! interrupt: it reads the samples there, and writes the codes that play when DMA comes to this
//! half again, which is the latency of [`LATENCY_BLOCKS`](firmware::seam::block::LATENCY_BLOCKS).
//!
//! ```text
//! block           k         k+1        k+2
//! ADC fills     first     second      first
//! DAC plays     first     second      first
//! interrupt           first: reads k, writes k+2
//! ```

/// A half of a ring of `RING` samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half<const RING: usize> {
    /// The first block.
    First,
    /// The second block.
    Second,
}

impl<const RING: usize> Half<RING> {
    /// Samples in a block.
    pub const BLOCK: usize = {
        assert!(RING > 0 && RING.is_multiple_of(2), "a ring has two blocks");
        RING / 2
    };

    /// The half that a position is in.
    #[inline]
    pub fn at(position: usize) -> Self {
        if position % RING < Self::BLOCK { Half::First } else { Half::Second }
    }

    /// The other half.
    #[inline]
    pub fn other(self) -> Self {
        match self {
            Half::First => Half::Second,
            Half::Second => Half::First,
        }
    }

    /// The position of its first sample.
    #[inline]
    pub fn start(self) -> usize {
        match self {
            Half::First => 0,
            Half::Second => Self::BLOCK,
        }
    }

    /// The places of a half's samples in the ADC's ring.
    #[inline]
    pub fn filled<Place>(self, ring: &[Place; RING]) -> &[Place] {
        &ring[self.start()..self.start() + Self::BLOCK]
    }
}
