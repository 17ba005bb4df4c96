//! Block clock: plays, samples and calls the controller, block after block, with the latency of
//! half/complete DMA.
//!
//! Time is counted by the converters; the controller takes no time. A queue that the controller
//! [drops](DriveBlock::drops_queue) becomes silent at the sample [`dropped_from`], the answer time
//! of the slowest board.

use firmware::seam::block::{DriveBlock, LATENCY_BLOCKS, SenseBlock, dropped_from};

use crate::analog::Analog;

/// Converters with the blocks queued for them.
#[derive(Debug)]
pub struct BlockClock<A> {
    /// Analog side at the converters.
    pub analog: A,
    pending: [DriveBlock; LATENCY_BLOCKS],
    /// Code of silence.
    silence: u16,
    /// Number of dropped samples at the end of the block that plays next.
    dropped: usize,
    sense: SenseBlock,
    block: u64,
}

impl<A: Analog> BlockClock<A> {
    /// Starts with `silence` playing, like a board before its first interrupt.
    pub fn new(analog: A, silence: &DriveBlock) -> Self {
        let pending = std::array::from_fn(|_| silence.clone());
        let silence = silence.lanes.first().and_then(|codes| codes.first()).copied().unwrap_or_default();
        BlockClock { analog, pending, silence, dropped: 0, sense: SenseBlock::default(), block: 0 }
    }

    /// Replaces the queued blocks by `silence`, as after a reset of the board. The analog side
    /// keeps its state.
    pub fn restart(&mut self, silence: &DriveBlock) {
        self.pending.iter_mut().for_each(|pending| pending.clone_from(silence));
    }

    /// Plays one block and hands the sampled codes to `process`, whose codes play
    /// [`LATENCY_BLOCKS`] blocks later.
    pub fn tick<T>(&mut self, process: impl FnOnce(&SenseBlock, &mut DriveBlock) -> T) -> T {
        self.tick_with(|sense, drive| (process(sense, drive), None))
    }

    /// Like [`BlockClock::tick`]. `process` also returns the sample of the next block from which a
    /// dropped queue was silent, if known.
    pub fn tick_with<T>(&mut self, process: impl FnOnce(&SenseBlock, &mut DriveBlock) -> (T, Option<usize>)) -> T {
        let (analog, drive, sense) = self.converters();
        analog.exchange(drive, sense);
        self.answer(process)
    }

    /// Returns the converters, the block that plays next, and the place for the sampled codes.
    ///
    /// This is the first half of a tick, for a caller that plays blocks by other means than
    /// [`Analog::exchange`].
    pub fn converters(&mut self) -> (&mut A, &DriveBlock, &mut SenseBlock) {
        (&mut self.analog, &self.pending[(self.block % LATENCY_BLOCKS as u64) as usize], &mut self.sense)
    }

    /// Passes the sampled codes to `process`: the second half of a tick.
    pub fn answer<T>(&mut self, process: impl FnOnce(&SenseBlock, &mut DriveBlock) -> (T, Option<usize>)) -> T {
        let slot = (self.block % LATENCY_BLOCKS as u64) as usize;
        self.block += 1;
        let answer = &mut self.pending[slot];
        let (answered, silent_from) = process(&self.sense, answer);
        self.dropped = if answer.drops_queue { self.drop_queue(silent_from) } else { 0 };
        answered
    }

    /// Silences the block that plays next from a sample on, and returns the number of silenced
    /// samples. The controller has already answered the later blocks with silence.
    fn drop_queue(&mut self, from: Option<usize>) -> usize {
        let next = &mut self.pending[(self.block % LATENCY_BLOCKS as u64) as usize];
        let samples = next.lanes.first().map_or(0, |codes| codes.len());
        let from = from.unwrap_or(dropped_from(samples)).min(samples);
        next.lanes.iter_mut().for_each(|codes| codes[from..].fill(self.silence));
        samples - from
    }

    /// Returns the number of dropped samples at the end of the block that plays next.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Returns the number of blocks played so far.
    pub fn blocks(&self) -> u64 {
        self.block
    }
}
