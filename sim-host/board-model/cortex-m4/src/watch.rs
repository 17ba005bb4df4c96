//! The watched exception: runs end at its entries and returns, and it may take less time than it costs.

use crate::chip::{Chip, Cycle};
use crate::machine::Machine;

/// The watched exception was entered, or has returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passage {
    /// Entered; otherwise returned.
    pub entered: bool,
    /// When: at the entry's beginning, or the return's.
    pub at: Cycle,
    /// Instructions until then.
    pub instructions: u64,
    /// Fetches until then.
    pub fetches: Fetches,
}

/// Fetches of instructions, each of aligned 8 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fetches {
    /// All of them.
    pub all: u64,
    /// Those from a memory with wait states.
    pub waiting: u64,
}

/// What a run does for its observer, over resets too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Watch {
    /// The exception whose entries and returns end a run; 0: none.
    exception: u16,
    passage: Option<Passage>,
    /// The entry that was chained to that return.
    chained: Option<Passage>,
    /// Cycles of time for a cycle of cost in that exception, in 65536ths, and the part of a cycle that is still owed.
    rate: u32,
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
    /// Cycles of time that `cost` cycles take while `exception` is handled.
    #[inline(always)]
    pub(crate) fn time_of(&mut self, cost: u32, exception: u16) -> Cycle {
        let rate = if exception == self.exception { self.rate } else { 1 << 16 };
        let owed = self.owed + u64::from(cost) * u64::from(rate);
        self.owed = owed & 0xFFFF;
        owed >> 16
    }

    /// Notes that PRIMASK is set or cleared.
    pub(crate) fn mask(&mut self, masked: bool, now: Cycle) {
        if let Some(since) = self.masked_since.filter(|_| !masked) {
            self.longest_masked = self.longest_masked.max(now - since);
        }
        self.masked_since = masked.then(|| self.masked_since.unwrap_or(now));
    }

    pub(crate) fn has_passed(&self) -> bool {
        self.passage.is_some()
    }

    /// The first passage that no run has ended with yet.
    pub(crate) fn take_passage(&mut self) -> Option<Passage> {
        std::mem::replace(&mut self.passage, self.chained.take())
    }
}

impl<C: Chip> Machine<C> {
    /// Ends runs at each entry and return of an exception; `None` at none.
    pub fn watch(&mut self, exception: Option<u16>) {
        self.cpu.watch.exception = exception.unwrap_or(0);
    }

    /// Lets the [watched](Machine::watch) exception take `rate` cycles of time for each cycle that its instructions cost: below one it is shorter than the
    /// part would be at it, while all else, delays among it, takes its time. To a 65536th, without drift.
    pub fn set_rate(&mut self, rate: f64) {
        self.cpu.watch.rate = (rate * 65536.0) as u32;
    }

    /// The longest time with PRIMASK set since this was last asked for, or since the beginning: cycles.
    pub fn take_longest_masked(&mut self) -> Cycle {
        std::mem::take(&mut self.cpu.watch.longest_masked)
    }

    /// Notes that an exception is entered or returned from.
    pub(crate) fn pass(&mut self, exception: u16, entered: bool) {
        let cpu = &mut self.cpu;
        if exception == cpu.watch.exception {
            let passage = Some(Passage { entered, at: cpu.cycle, instructions: cpu.instructions, fetches: cpu.watch.fetches });
            // It may return and be entered again in one go.
            let place = if cpu.watch.passage.is_none() { &mut cpu.watch.passage } else { &mut cpu.watch.chained };
            *place = passage;
            cpu.attend();
        }
    }
}
