//! Halves of a ring of two blocks, which DMA and the block interrupt use in turn.
//!
//! There are two rings of two blocks each, both at the sample rate. DMA fills one from the ADC and
//! plays the other to the DAC. While DMA is in one half of both rings, the interrupt owns the other
//! half: it reads the samples there and writes new codes. These codes play when DMA reaches this
//! half again; this is the latency of [`LATENCY_BLOCKS`](firmware::seam::block::LATENCY_BLOCKS).
//!
//! ```text
//! block           k         k+1        k+2
//! ADC fills     first     second      first
//! DAC plays     first     second      first
//! interrupt           first: reads k, writes k+2
//! ```

/// Half of a ring of `RING` samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half<const RING: usize> {
    /// First block of the ring.
    First,
    /// Second block of the ring.
    Second,
}

impl<const RING: usize> Half<RING> {
    /// Number of samples in a block.
    pub const BLOCK: usize = {
        assert!(RING > 0 && RING.is_multiple_of(2), "a ring has two blocks");
        RING / 2
    };

    /// Returns the half that contains a position.
    #[inline]
    pub fn at(position: usize) -> Self {
        if position % RING < Self::BLOCK { Half::First } else { Half::Second }
    }

    /// Returns the other half.
    #[inline]
    pub fn other(self) -> Self {
        match self {
            Half::First => Half::Second,
            Half::Second => Half::First,
        }
    }

    /// Returns the position of the first sample of this half.
    #[inline]
    pub fn start(self) -> usize {
        match self {
            Half::First => 0,
            Half::Second => Self::BLOCK,
        }
    }

    /// Returns the samples of this half from the ADC's ring.
    #[inline]
    pub fn filled<Place>(self, ring: &[Place; RING]) -> &[Place] {
        &ring[self.start()..self.start() + Self::BLOCK]
    }
}
