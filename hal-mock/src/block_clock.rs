//! The block clock: plays, samples, and calls the controller, block after block, with the latency of half/complete DMA.
//!
//! Time is that of the converters: the controller takes none. A queue that it [drops](DriveBlock::drops_queue) is silent from the sample on at which the
//! slowest board has the answer, [`dropped_from`].

use firmware::seam::block::{DriveBlock, LATENCY_BLOCKS, SenseBlock, dropped_from};

use crate::analog::Analog;

/// Converters and the blocks that are on their way to them.
#[derive(Debug)]
pub struct BlockClock<A> {
    /// What is behind the converters.
    pub analog: A,
    pending: [DriveBlock; LATENCY_BLOCKS],
    /// The code of silence.
    silence: u16,
    /// Samples at the end of the block that plays next that were dropped.
    dropped: usize,
    sense: SenseBlock,
    block: u64,
}

impl<A: Analog> BlockClock<A> {
    /// Starts with `silence` playing, as a board does before its first interrupt.
    pub fn new(analog: A, silence: &DriveBlock) -> Self {
        let pending = std::array::from_fn(|_| silence.clone());
        let silence = silence.lanes.first().and_then(|codes| codes.first()).copied().unwrap_or_default();
        BlockClock { analog, pending, silence, dropped: 0, sense: SenseBlock::default(), block: 0 }
    }

    /// Forgets what is on its way: the board was reset, and `silence` plays. The plant goes on.
    pub fn restart(&mut self, silence: &DriveBlock) {
        self.pending.iter_mut().for_each(|pending| pending.clone_from(silence));
    }

    /// Plays one block and hands the sampled codes to `process`, whose codes play [`LATENCY_BLOCKS`] blocks later.
    pub fn tick<T>(&mut self, process: impl FnOnce(&SenseBlock, &mut DriveBlock) -> T) -> T {
        self.tick_with(|sense, drive| (process(sense, drive), None))
    }

    /// The same, where `process` also returns from which sample of the next block on a queue that it drops was silent, if that is known.
    pub fn tick_with<T>(&mut self, process: impl FnOnce(&SenseBlock, &mut DriveBlock) -> (T, Option<usize>)) -> T {
        let (analog, drive, sense) = self.converters();
        analog.exchange(drive, sense);
        self.answer(process)
    }

    /// The converters, the block that plays next, and where to put what is sampled meanwhile: the first half of a tick, for who plays blocks by other
    /// means than [`Analog::exchange`].
    pub fn converters(&mut self) -> (&mut A, &DriveBlock, &mut SenseBlock) {
        (&mut self.analog, &self.pending[(self.block % LATENCY_BLOCKS as u64) as usize], &mut self.sense)
    }

    /// The second half of a tick: hands the codes that were sampled to `process`.
    pub fn answer<T>(&mut self, process: impl FnOnce(&SenseBlock, &mut DriveBlock) -> (T, Option<usize>)) -> T {
        let slot = (self.block % LATENCY_BLOCKS as u64) as usize;
        self.block += 1;
        let answer = &mut self.pending[slot];
        let (answered, silent_from) = process(&self.sense, answer);
        self.dropped = if answer.drops_queue { self.drop_queue(silent_from) } else { 0 };
        answered
    }

    /// Silences the block that plays next from a sample on, and returns how many samples these are. Blocks after it were answered with silence.
    fn drop_queue(&mut self, from: Option<usize>) -> usize {
        let next = &mut self.pending[(self.block % LATENCY_BLOCKS as u64) as usize];
        let samples = next.lanes.first().map_or(0, |codes| codes.len());
        let from = from.unwrap_or(dropped_from(samples)).min(samples);
        next.lanes.iter_mut().for_each(|codes| codes[from..].fill(self.silence));
        samples - from
    }

    /// Samples at the end of the block that plays next that were dropped.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Blocks played so far.
    pub fn blocks(&self) -> u64 {
        self.block
    }
}
