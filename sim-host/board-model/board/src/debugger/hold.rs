//! What a debugger makes a board do: halt, step, and run to a breakpoint.

use std::collections::BTreeSet;
use std::time::Duration;

use cortex_m4::{Cycle, Ended};

use crate::board::{Board, BoardError};

/// Time that passes at a halt while the processor stands, before the board's time stands too: what reacts to a halt has reacted by then. The image's
/// timer drops the amplifier 200 us after the last block.
const SETTLES: Duration = Duration::from_micros(200);

impl Board {
    /// A debugger halts the processor, or lets it go on: what DBGMCU names stands meanwhile (RM0440 47.6).
    pub fn hold(&mut self, halted: bool) -> Result<(), BoardError> {
        Ok(self.machine_mut().set_halted(halted)?)
    }

    /// A debugger halts the processor for a time, and lets it go on.
    pub fn halt_for(&mut self, time: Duration) -> Result<(), BoardError> {
        self.hold(true)?;
        let until = self.machine().cycle() + self.cycles(time);
        self.machine_mut().stand_until(until)?;
        self.hold(false)
    }

    /// Lets part and plant react to a halted processor, which stands: 200 us.
    pub fn settle(&mut self) -> Result<(), BoardError> {
        let until = self.machine().cycle() + self.cycles(SETTLES);
        Ok(self.machine_mut().stand_until(until)?)
    }

    /// Runs for the time of a block, or to the next instruction at one of `breakpoints`, which does not execute. True: it is at one.
    pub fn run_block_to(&mut self, breakpoints: &BTreeSet<u32>) -> Result<bool, BoardError> {
        let until = self.block_end();
        while self.machine().cycle() < until {
            match self.machine_mut().run_to(until, breakpoints)? {
                Ended::Breakpoint => return Ok(true),
                Ended::Passage(passage) => self.pass(passage)?,
                Ended::Time => (),
            }
        }
        Ok(false)
    }

    /// Runs one instruction; interrupts that are due wait. A sleeping processor sleeps on, at most for a block. A breakpoint instruction is skipped.
    pub fn step(&mut self) -> Result<(), BoardError> {
        if self.machine_mut().skip_breakpoint() {
            return Ok(());
        }
        let until = self.block_end();
        match self.machine_mut().step_over(until)? {
            Some(passage) => self.pass(passage),
            None => Ok(()),
        }
    }

    /// When a block from now will have ended, unless the clock changes.
    fn block_end(&self) -> Cycle {
        self.machine().cycle() + self.cycles(self.block_time())
    }

    /// Cycles of a time at the present clock.
    fn cycles(&self, time: Duration) -> Cycle {
        ((time.as_secs_f64() * self.machine().chip.hz() as f64).ceil() as Cycle).max(1)
    }
}
