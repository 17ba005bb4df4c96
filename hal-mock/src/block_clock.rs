//! The block clock: plays, samples, and calls the controller, block after block, with the latency of half/complete DMA.

use firmware::seam::block::{DriveBlock, LATENCY_BLOCKS, SenseBlock};

use crate::analog::Analog;

/// Converters and the blocks that are on their way to them.
#[derive(Debug)]
pub struct BlockClock<A> {
    /// What is behind the converters.
    pub analog: A,
    pending: [DriveBlock; LATENCY_BLOCKS],
    sense: SenseBlock,
    block: u64,
}

impl<A: Analog> BlockClock<A> {
    /// Starts with `silence` playing, as a board does before its first interrupt.
    pub fn new(analog: A, silence: &DriveBlock) -> Self {
        BlockClock { analog, pending: std::array::from_fn(|_| silence.clone()), sense: SenseBlock::default(), block: 0 }
    }

    /// Forgets what is on its way: the board was reset, and `silence` plays. The plant goes on.
    pub fn restart(&mut self, silence: &DriveBlock) {
        self.pending.iter_mut().for_each(|pending| pending.clone_from(silence));
    }

    /// Plays one block and hands the sampled codes to `process`, whose codes play [`LATENCY_BLOCKS`] blocks later.
    pub fn tick<T>(&mut self, process: impl FnOnce(&SenseBlock, &mut DriveBlock) -> T) -> T {
        let slot = &mut self.pending[(self.block % LATENCY_BLOCKS as u64) as usize];
        self.analog.exchange(slot, &mut self.sense);
        self.block += 1;
        process(&self.sense, slot)
    }

    /// Blocks played so far.
    pub fn blocks(&self) -> u64 {
        self.block
    }
}
