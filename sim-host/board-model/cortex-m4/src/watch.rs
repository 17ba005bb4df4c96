//! Watched exception: runs end at its entries and returns, and its time can be scaled.

use crate::chip::{Chip, Cycle};
use crate::machine::Machine;

/// Entry to or return from the watched exception.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passage {
    /// `true` for an entry, `false` for a return.
    pub entered: bool,
    /// Cycle at the beginning of the entry or return.
    pub at: Cycle,
    /// Number of instructions executed before this cycle.
    pub instructions: u64,
    /// Number of fetches before this cycle.
    pub fetches: Fetches,
}

/// Numbers of instruction fetches, each of aligned 8 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fetches {
    /// All fetches.
    pub all: u64,
    /// Fetches from a memory with wait states.
    pub waiting: u64,
}

/// Observations and scaled time of the watched exception; they continue over resets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Watch {
    /// Exception whose entries and returns end a run; 0: none.
    exception: u16,
    passage: Option<Passage>,
    /// Entry that was chained to that return.
    chained: Option<Passage>,
    /// Cycles of time per cycle of cost in that exception, in units of 1/65536.
    rate: u32,
    /// Remaining fraction of a cycle, in units of 1/65536.
    owed: u64,
    pub(crate) fetches: Fetches,
    masked_since: Option<Cycle>,
    longest_masked: Cycle,
}

impl Default for Watch {
    fn default() -> Self {
        let (fetches, longest_masked) = (Fetches::default(), 0);
        Watch { exception: 0, passage: None, chained: None, rate: 1 << 16, owed: 0, fetches, masked_since: None, longest_masked }
    }
}

impl Watch {
    /// Returns the cycles of time for `cost` cycles in `exception`.
    #[inline(always)]
    pub(crate) fn time_of(&mut self, cost: u32, exception: u16) -> Cycle {
        let rate = if exception == self.exception { self.rate } else { 1 << 16 };
        let owed = self.owed + u64::from(cost) * u64::from(rate);
        self.owed = owed & 0xFFFF;
        owed >> 16
    }

    /// Records that PRIMASK is set or cleared.
    pub(crate) fn mask(&mut self, masked: bool, now: Cycle) {
        if let Some(since) = self.masked_since.filter(|_| !masked) {
            self.longest_masked = self.longest_masked.max(now - since);
        }
        self.masked_since = masked.then(|| self.masked_since.unwrap_or(now));
    }

    pub(crate) fn has_passed(&self) -> bool {
        self.passage.is_some()
    }

    /// Returns the first passage that has not ended a run yet.
    pub(crate) fn take_passage(&mut self) -> Option<Passage> {
        std::mem::replace(&mut self.passage, self.chained.take())
    }
}

impl<C: Chip> Machine<C> {
    /// Ends runs at each entry and return of an exception; `None` switches this off.
    pub fn watch(&mut self, exception: Option<u16>) {
        self.cpu.watch.exception = exception.unwrap_or(0);
    }

    /// Scales the [watched](Machine::watch) exception: its instructions take `rate` cycles of time
    /// per cycle of cost. A rate below one makes it faster than the hardware. Everything else,
    /// including delays, takes its real time. The resolution is 1/65536, without drift.
    pub fn set_rate(&mut self, rate: f64) {
        self.cpu.watch.rate = (rate * 65536.0) as u32;
    }

    /// Returns the longest time with PRIMASK set since the last call, or since the beginning,
    /// cycles.
    pub fn take_longest_masked(&mut self) -> Cycle {
        std::mem::take(&mut self.cpu.watch.longest_masked)
    }

    /// Records that an exception is entered or returned from.
    pub(crate) fn pass(&mut self, exception: u16, entered: bool) {
        let cpu = &mut self.cpu;
        if exception == cpu.watch.exception {
            let passage = Some(Passage { entered, at: cpu.cycle, instructions: cpu.instructions, fetches: cpu.watch.fetches });
            // One instruction may cause a return and an entry.
            let place = if cpu.watch.passage.is_none() { &mut cpu.watch.passage } else { &mut cpu.watch.chained };
            *place = passage;
            cpu.schedule_check();
        }
    }
}
