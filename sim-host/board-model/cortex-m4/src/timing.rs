//! Selection of cycles if the manual gives a range: the maximum, or the usual number.
//!
//! | | [`Timing::Longest`] | [`Timing::Usual`] |
//! |---|---|---|
//! | refill of the pipeline after an immediate branch | 3 | 1 |
//! | after a branch to a register | 3 | 2 |
//! | if the target is a 32-bit instruction that is not aligned | | 1 more |
//! | after a load of the PC, `TBB`, `TBH` | 3 | 3 |
//! | successive 32-bit instructions that are not aligned | 1 more for the third and each load or store that follows | 1 more for the third |
//! | load relative to the PC | 1 more, and never pipelined | as any load |
//! | other masters of the buses | [`Chip::held_up`] more | |
//!
//! The refill takes 1 to 3 cycles "depending on the alignment and width of the target instruction,
//! and whether the processor manages to speculate the address early" (ARM DDI 0439, table 3-1). It
//! is "normally" 1 after an immediate branch, 2 after one to a register, and longer to unaligned
//! 32-bit instructions (ARM DDI 0337E, 18.2, of the Cortex-M3, which has the same pipeline). A load
//! relative to the PC "might" take one more (DDI 0439, 3.3.2).
//!
//! The rows of unaligned instructions are measured on an STM32L4 (compendium.i-0.nl, "Alignment
//! rules"): three or more take one more cycle. A mix with loads and stores can take more than one,
//! so the bound counts each of these. There is no further loss: the fetch brings one word per cycle
//! into a buffer of three, for any contents (ARM article KA8521).

use crate::chip::{Chip, Cycle};
use crate::cpu::{Cpu, INVALID};
use crate::machine::Machine;
use crate::op::Decoded;

/// Cycles that are counted if the manual gives a range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Maximum of the manual.
    Longest,
    /// Normal number of the manual, or a measured one.
    Usual,
    /// One cycle for each instruction and none for exceptions or wait states, as in an emulator.
    Instructions,
}

/// Source of the address of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    Immediate,
    Register,
    /// Memory; added to the PC in a table branch.
    Loaded,
}

/// Longest refill of the pipeline, cycles.
pub const REFILL: u32 = 3;

impl Timing {
    #[inline(always)]
    fn refill(self, target: Target) -> u32 {
        match (self, target) {
            (Timing::Longest, _) | (_, Target::Loaded) => REFILL,
            (_, Target::Immediate) => 1,
            (_, Target::Register) => 2,
        }
    }
}

impl<C: Chip> Machine<C> {
    /// Adds the delay by other bus masters. It is real time, so the rate of the watched exception
    /// does not apply.
    pub(crate) fn hold_up(&mut self) {
        let cycles = self.chip.held_up();
        if self.cpu.timing == Timing::Longest && self.cpu.asleep.is_none() {
            self.cpu.cycle += Cycle::from(cycles);
        }
    }
}

impl Cpu {
    /// Adds the cost of the current instruction to the time.
    #[inline(always)]
    pub(crate) fn spend(&mut self) {
        if self.timing == Timing::Instructions {
            self.cost = 1;
        }
        self.cycle += self.watch.time_of(self.cost, self.ipsr);
    }

    /// Adds the cost of an exception's entry or return to the time.
    pub(crate) fn spend_exception(&mut self) {
        if self.timing != Timing::Instructions {
            self.cycle += self.watch.time_of(self.cost, self.ipsr);
        }
    }

    /// Branches to an address whose lowest bit selects Thumb state, or returns from an exception
    /// (`BXWritePC`, `LoadWritePC`).
    #[inline]
    pub(crate) fn branch_exchange(&mut self, address: u32, target: Target) {
        if self.ipsr != 0 && address >= 0xF000_0000 {
            self.exception_return = Some(address);
        } else {
            self.branch_to(address, target);
        }
    }

    /// Branches as [`branch_exchange`](Cpu::branch_exchange), but never returns from an exception
    /// (`BLXWritePC`). An even address clears EPSR.T, and the next instruction faults.
    #[inline]
    pub(crate) fn branch_to(&mut self, address: u32, target: Target) {
        self.branch(address, target);
        self.next |= INVALID & !address;
    }

    /// Branches within Thumb code.
    #[inline(always)]
    pub(crate) fn branch(&mut self, address: u32, target: Target) {
        self.next = address & !1;
        self.cost += self.timing.refill(target);
        self.unaligned = 0;
        if self.timing == Timing::Usual && target != Target::Loaded {
            self.computed = Decoded::TARGET;
        }
    }

    /// Adds the extra cycles of a 32-bit instruction that is not aligned.
    #[inline(always)]
    pub(crate) fn fetch_unaligned(&mut self, accesses_memory: bool) {
        self.unaligned += 1;
        if self.unaligned == 3 || self.unaligned > 3 && accesses_memory && self.timing == Timing::Longest {
            self.cost += 1;
        }
        if self.computed == Decoded::TARGET {
            self.cost += 1;
        }
    }

    /// Adds the extra cycle that a load relative to the PC may take.
    #[inline(always)]
    pub(crate) fn load_from_code(&mut self) {
        self.cost += u32::from(self.timing == Timing::Longest);
    }
}
