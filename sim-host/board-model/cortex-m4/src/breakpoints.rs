//! Breakpoints and single steps for a debugger: runs end before an instruction at a chosen address.
//! The memories are not changed, and a run without breakpoints does not check for any.

use std::collections::BTreeSet;

use crate::chip::{Chip, Cycle};
use crate::cpu::Trap;
use crate::machine::{Machine, Stop};
use crate::watch::Passage;

/// End of a run with breakpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Time is over.
    Time,
    /// [Watched](Machine::watch) exception was entered, or has returned.
    Passage(Passage),
    /// Next instruction is at one of the addresses.
    Breakpoint,
}

/// Finding that [stops](Stop) a run before a `BKPT` while a [debugger is
/// attached](Machine::attach_debugger).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a breakpoint instruction")]
pub struct BreakpointInstruction;

/// `BKPT`, without its number (A7.7.17).
const BKPT: u16 = 0xBE00;

impl<C: Chip> Machine<C> {
    /// Attaches or detaches a debugger (DHCSR.C_DEBUGEN, C1.6.2). While attached, `BKPT` stops the
    /// run before it executes, instead of causing a hard fault.
    pub fn attach_debugger(&mut self, attached: bool) {
        self.debugged = attached;
    }

    /// Runs as [`run_until`](Machine::run_until), but at most to the next instruction at one of
    /// `addresses`, which does not execute. The first instruction of the run counts: step over it
    /// first.
    pub fn run_to(&mut self, until: Cycle, addresses: &BTreeSet<u32>) -> Result<Ended, Stop> {
        self.cpu.schedule_check();
        let hit = self.run_to_address(until, addresses).map_err(|_| self.stop())?;
        Ok(match self.cpu.watch.take_passage() {
            Some(passage) => Ended::Passage(passage),
            None if hit => Ended::Breakpoint,
            None => Ended::Time,
        })
    }

    /// Runs one instruction, as [`step`](Machine::step), while pending interrupts wait, as in a
    /// debugger's step (DHCSR.C_MASKINTS, C1.6.2). Returns the passage of the watched exception
    /// that ended the step.
    pub fn step_over(&mut self, until: Cycle) -> Result<Option<Passage>, Stop> {
        self.cpu.holds_interrupts = true;
        let stepped = self.step(until);
        self.cpu.holds_interrupts = false;
        stepped?;
        Ok(self.cpu.watch.take_passage())
    }

    /// Skips the next instruction without executing it if it is a `BKPT`; otherwise returns
    /// `false`.
    pub fn skip_breakpoint(&mut self) -> bool {
        let next = self.memory.get(self.cpu.pc, 2).and_then(|bytes| bytes.first_chunk()).map(|bytes| u16::from_le_bytes(*bytes));
        let is_there = next.is_some_and(|half| half & 0xFF00 == BKPT);
        if is_there {
            self.cpu.pc += 2;
            if self.cpu.it != 0 {
                self.cpu.advance_it();
            }
        }
        is_there
    }

    /// Runs; returns `true` if the next instruction is at one of the addresses.
    fn run_to_address(&mut self, until: Cycle, addresses: &BTreeSet<u32>) -> Result<bool, Trap> {
        loop {
            // Exceptions first, because an entry changes the next instruction.
            if self.cpu.cycle >= self.cpu.deadline && !self.check_events(until)? {
                return Ok(false);
            }
            if addresses.contains(&self.cpu.pc) {
                return Ok(true);
            }
            self.instruction::<true>()?;
        }
    }
}
