//! Conversion of a trap of an instruction to the exception that it causes (B1.5.14).

use super::scb::*;
use super::{BUS_FAULT, HARD_FAULT, MEMORY_FAULT, SVCALL, USAGE_FAULT};
use crate::chip::{Chip, Ports};
use crate::cpu::Trap;
use crate::machine::Machine;

impl<C: Chip> Machine<C> {
    /// Takes the exception of `trap`, at the current instruction. `Trap::Stop` is returned instead.
    pub(crate) fn take(&mut self, trap: Trap) -> Result<(), Trap> {
        let scb = &mut self.cpu.scb;
        let address = self.cpu.fault_address;
        let (exception, status) = match trap {
            Trap::Stop => return Err(trap),
            Trap::Supervisor => (SVCALL, 0),
            Trap::Undefined => (USAGE_FAULT, UNDEFINSTR),
            Trap::NoCoprocessor => (USAGE_FAULT, NOCP),
            Trap::InvalidState => (USAGE_FAULT, INVSTATE),
            Trap::InvalidReturn => (USAGE_FAULT, INVPC),
            Trap::Unaligned => (USAGE_FAULT, UNALIGNED),
            Trap::DivideByZero => (USAGE_FAULT, DIVBYZERO),
            Trap::Fetch => (BUS_FAULT, IBUSERR),
            Trap::MemoryFetch => (MEMORY_FAULT, IACCVIOL),
            Trap::Bus => {
                scb.bfar = address;
                (BUS_FAULT, PRECISERR | BFARVALID)
            }
            Trap::Memory => {
                scb.mmfar = address;
                (MEMORY_FAULT, DACCVIOL | MMARVALID)
            }
            Trap::Breakpoint => {
                scb.hfsr |= DEBUGEVT;
                (HARD_FAULT, 0)
            }
        };
        scb.cfsr |= status;
        // A supervisor call returns to the next instruction, a fault to its own.
        if trap == Trap::Supervisor {
            self.cpu.pc = self.cpu.next;
            self.cpu.advance_it();
        }
        self.raise(exception);
        Ok(())
    }

    /// Enters a synchronous exception now. Without an enabled handler of sufficient priority it
    /// becomes a hard fault, and if even that has no priority, the processor locks up.
    fn raise(&mut self, exception: u16) {
        let priority = self.cpu.execution_priority();
        let group = self.cpu.scb.priority_group();
        let handled = self.cpu.scb.handles(exception) && self.cpu.nvic.group_priority(exception, group) < priority;
        if exception != HARD_FAULT && handled {
            self.enter(exception);
        } else if priority > -1 {
            self.cpu.scb.hfsr |= if exception == HARD_FAULT { 0 } else { FORCED };
            self.enter(HARD_FAULT);
        } else {
            self.lock_up();
        }
    }

    /// Stops executing until a reset (B1.5.15).
    pub(crate) fn lock_up(&mut self) {
        self.cpu.locked = true;
        self.cpu.schedule_check();
        let ports = Ports { memory: &mut self.memory, interrupts: &mut self.interrupts };
        if let Err(fault) = self.chip.lockup(self.cpu.cycle, ports) {
            // The stop is reported at the next check for events.
            let _ = self.cpu.trap(fault);
        }
    }
}
