//! Actions of a debugger on a board: halt, step, and run to a breakpoint.

use std::collections::BTreeSet;
use std::time::Duration;

use cortex_m4::{Cycle, Ended};

use crate::board::{Board, BoardError};

/// Time that passes after a halt of the processor before the board's time stops too, so that the
/// board can react. The image's timer switches the amplifier off 200 us after the last block.
const SETTLE_TIME: Duration = Duration::from_micros(200);

impl Board {
    /// Halts or resumes the processor; a halt stops the peripherals that DBGMCU selects (RM0440
    /// 47.6).
    pub fn hold(&mut self, halted: bool) -> Result<(), BoardError> {
        Ok(self.machine_mut().set_halted(halted)?)
    }

    /// Halts the processor for a time and resumes it.
    pub fn halt_for(&mut self, time: Duration) -> Result<(), BoardError> {
        self.hold(true)?;
        let until = self.machine().cycle() + self.cycles(time);
        self.machine_mut().halt_until(until)?;
        self.hold(false)
    }

    /// Lets chip and plant react to a halted processor for 200 us.
    pub fn settle(&mut self) -> Result<(), BoardError> {
        let until = self.machine().cycle() + self.cycles(SETTLE_TIME);
        Ok(self.machine_mut().halt_until(until)?)
    }

    /// Runs for the duration of a block, or to the next instruction at one of `breakpoints`, which
    /// does not execute. Returns `true` at a breakpoint.
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

    /// Runs one instruction; pending interrupts wait. A sleeping processor continues to sleep for
    /// at most a block. A breakpoint instruction is skipped.
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

    /// Returns the cycle one block from now, unless the clock changes.
    fn block_end(&self) -> Cycle {
        self.machine().cycle() + self.cycles(self.block_time())
    }

    /// Returns the cycles of a time at the current clock.
    fn cycles(&self, time: Duration) -> Cycle {
        ((time.as_secs_f64() * self.machine().chip.hz() as f64).ceil() as Cycle).max(1)
    }
}
