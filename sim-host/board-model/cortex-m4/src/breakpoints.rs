//! Runs that end before an instruction at a chosen address, and single steps, for a debugger. The memories are not changed, and a run without breakpoints
//! does not look for any.

use std::collections::BTreeSet;

use crate::chip::{Chip, Cycle};
use crate::cpu::Trap;
use crate::machine::{Machine, Stop};
use crate::watch::Passage;

/// How a run with breakpoints has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The time is over.
    Time,
    /// The [watched](Machine::watch) exception was entered, or has returned.
    Passage(Passage),
    /// The next instruction is at one of the addresses.
    Breakpoint,
}

/// The finding with which a run [stops](Stop) before a `BKPT` while a [debugger is attached](Machine::attach_debugger).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a breakpoint instruction")]
pub struct BreakpointInstruction;

/// `BKPT`, without its number (A7.7.17).
const BKPT: u16 = 0xBE00;

impl<C: Chip> Machine<C> {
    /// A debugger is attached, or has gone (DHCSR.C_DEBUGEN, C1.6.2): `BKPT` then stops the run before it executes, and is no hard fault.
    pub fn attach_debugger(&mut self, attached: bool) {
        self.debugged = attached;
    }

    /// Runs as [`run_until`](Machine::run_until), but at most to the next instruction at one of `addresses`, which does not execute. One at which the
    /// run begins counts: step over it first.
    pub fn run_to(&mut self, until: Cycle, addresses: &BTreeSet<u32>) -> Result<Ended, Stop> {
        self.cpu.attend();
        let hit = self.look_for(until, addresses).map_err(|_| self.stop())?;
        Ok(match self.cpu.watch.take_passage() {
            Some(passage) => Ended::Passage(passage),
            None if hit => Ended::Breakpoint,
            None => Ended::Time,
        })
    }

    /// Runs one instruction, as [`step`](Machine::step), while interrupts that are due wait, as a debugger steps (DHCSR.C_MASKINTS, C1.6.2). Gives the
    /// passage of the watched exception with which the step ended.
    pub fn step_over(&mut self, until: Cycle) -> Result<Option<Passage>, Stop> {
        self.cpu.holds_interrupts = true;
        let stepped = self.step(until);
        self.cpu.holds_interrupts = false;
        stepped?;
        Ok(self.cpu.watch.take_passage())
    }

    /// Goes to the instruction after a `BKPT` that is next, without executing it. False: the next instruction is another one.
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

    /// True: the next instruction is at one of the addresses.
    fn look_for(&mut self, until: Cycle, addresses: &BTreeSet<u32>) -> Result<bool, Trap> {
        loop {
            // Exceptions first: the next instruction is then the one that really executes.
            if self.cpu.cycle >= self.cpu.deadline && !self.attend(until)? {
                return Ok(false);
            }
            if addresses.contains(&self.cpu.pc) {
                return Ok(true);
            }
            self.instruction::<true>()?;
        }
    }
}
