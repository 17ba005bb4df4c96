//! Entry to and return from exceptions (B1.5.6 to B1.5.8), with the floating-point context
//! (B1.5.7).

use super::scb::*;
use super::{BUS_FAULT, EXTERNAL, HARD_FAULT, MEMORY_FAULT, NMI};
use crate::chip::Chip;
use crate::cpu::{Cpu, Flags, Sleep, Trap};
use crate::cycles::{ENTRY, FLOAT_FRAME, RETURN, TAIL_CHAIN};
use crate::machine::Machine;
use crate::op::Size;

/// Bytes of a frame without floating-point registers.
const BASIC_FRAME: u32 = 0x20;
/// Bytes of a frame with floating-point registers.
const EXTENDED_FRAME: u32 = 0x68;

impl Cpu {
    /// Returns xPSR as it is stacked: flags, IT bits, T, and the number of the exception.
    pub(crate) fn xpsr(&self) -> u32 {
        let it = u32::from(self.it);
        self.flags.bits() | (it & 3) << 25 | (it >> 2) << 10 | 1 << 24 | u32::from(self.ipsr)
    }

    /// Advances the IT state to the next instruction (A7.3.2).
    pub(crate) fn advance_it(&mut self) {
        self.it = if self.it & 7 == 0 { 0 } else { self.it & 0xE0 | self.it << 1 & 0x1F };
    }

    /// Returns `true` if CPACR permits floating point: full access, or access for privileged code.
    fn float_allowed(&self) -> bool {
        match self.scb.cpacr >> 20 & 3 {
            3 => true,
            1 => self.privileged(),
            _ => false,
        }
    }
}

impl<C: Chip> Machine<C> {
    /// Enters an exception from the current instruction: stacks a frame and jumps to the handler.
    pub(crate) fn enter(&mut self, exception: u16) {
        self.cpu.cost = ENTRY;
        let (link, failed) = self.stack();
        let exception = match failed {
            None => exception,
            Some(derived) => match self.derive(derived, exception) {
                Some(exception) => exception,
                None => return self.lock_up(),
            },
        };
        self.cpu.r[14] = link;
        self.activate(exception);
        self.cpu.spend_exception();
    }

    /// Writes the frame. Returns `EXC_RETURN`, and the fault of the stacking if one occurred.
    fn stack(&mut self) -> (u32, Option<u16>) {
        let cpu = &mut self.cpu;
        let float = cpu.float_active && cpu.float_allowed();
        let lazy = float && cpu.scb.fpccr & LSPEN != 0;
        let align = cpu.scb.aligns_stack() || float;
        let sp = cpu.r[13];
        let frame = sp.wrapping_sub(if float { EXTENDED_FRAME } else { BASIC_FRAME }) & !(4 * u32::from(align));
        let padded = align && sp & 4 != 0;
        let handler = cpu.ipsr != 0;
        let link = 0xFFFF_FFE1 | u32::from(!float) << 4 | u32::from(!handler) << 3 | u32::from(cpu.on_process_stack) << 2;
        let words =
            [cpu.r[0], cpu.r[1], cpu.r[2], cpu.r[3], cpu.r[12], cpu.r[14], cpu.pc & !1, cpu.xpsr() | u32::from(padded) << 9];
        cpu.r[13] = frame;
        let mut failed = None;
        for (at, word) in (frame..).step_by(4).zip(words) {
            failed = failed.or(self.store(Size::Word, at, word).err());
        }
        if lazy {
            self.cpu.scb.fpcar = frame + BASIC_FRAME;
            // State that the later store needs: B3.2.21.
            let flags = u32::from(!handler) << 3 | u32::from(!self.cpu.privileged()) << 1;
            self.cpu.scb.fpccr = self.cpu.scb.fpccr & (ASPEN | LSPEN) | LSPACT | flags;
        } else if float {
            self.cpu.cost += FLOAT_FRAME;
            failed = failed.or(self.store_float(frame + BASIC_FRAME).err());
        }
        self.cpu.float_active = false;
        self.cpu.float_ready = false;
        (link, failed.map(|trap| self.set_stack_fault(trap, MSTKERR, STKERR)))
    }

    /// Sets the status of a fault on the stack and returns its exception.
    fn set_stack_fault(&mut self, trap: Trap, memory: u32, bus: u32) -> u16 {
        let (exception, status) = if trap == Trap::Memory { (MEMORY_FAULT, memory) } else { (BUS_FAULT, bus) };
        self.cpu.scb.cfsr |= status;
        exception
    }

    /// Selects the exception to enter after a failed stacking: the original one or the fault of the
    /// stacking. `None` means a lock-up.
    fn derive(&mut self, derived: u16, exception: u16) -> Option<u16> {
        let cpu = &mut self.cpu;
        let group = cpu.scb.priority_group();
        let priority = cpu.nvic.group_priority(exception, group);
        if priority < 0 {
            return None;
        }
        cpu.nvic.pend(exception);
        if cpu.scb.handles(derived) && cpu.nvic.group_priority(derived, group) < priority {
            return Some(derived);
        }
        cpu.scb.hfsr |= FORCED;
        Some(HARD_FAULT)
    }

    /// Jumps to the handler, on the main stack.
    fn activate(&mut self, exception: u16) {
        let cpu = &mut self.cpu;
        cpu.use_process_stack(false);
        cpu.nvic.activate(exception);
        cpu.ipsr = exception;
        cpu.it = 0;
        cpu.exclusive = None;
        cpu.event = true;
        cpu.float_ready = false;
        cpu.fetched = 1;
        cpu.schedule_check();
        self.profile_entry(exception);
        self.pass(exception, true);
        match self.vector(exception) {
            Ok(target) => {
                self.cpu.pc = if target & 1 == 1 { target & !1 } else { target | crate::cpu::INVALID };
            }
            Err(_) if exception == HARD_FAULT || exception == NMI => self.lock_up(),
            Err(_) => {
                self.cpu.scb.hfsr |= VECTTBL;
                self.cpu.nvic.pend_system(HARD_FAULT);
            }
        }
    }

    /// Reads an entry of the vector table.
    pub(crate) fn vector(&mut self, number: u16) -> Result<u32, Trap> {
        let address = self.cpu.scb.vtor.wrapping_add(4 * u32::from(number));
        // Memory that the chip maps to address 0 after reset.
        let address = if self.memory.find(address).is_none() { address.wrapping_add(self.boot) } else { address };
        self.load(Size::Word, address)
    }

    fn store_float(&mut self, frame: u32) -> Result<(), Trap> {
        for s in 0..16 {
            self.store_aligned(frame + 4 * s, self.cpu.s[s as usize])?;
        }
        self.store_aligned(frame + 64, self.cpu.fpscr)
    }

    /// Prepares a floating-point instruction: access check, lazy store, and new context
    /// (`ExecuteFPCheck`).
    #[cold]
    pub(crate) fn prepare_float(&mut self) -> Result<(), Trap> {
        if !self.cpu.float_allowed() {
            return Err(Trap::NoCoprocessor);
        }
        if self.cpu.scb.fpccr & LSPACT != 0 {
            self.cpu.cost += FLOAT_FRAME;
            let frame = self.cpu.scb.fpcar;
            if let Err(trap) = self.store_float(frame) {
                let exception = self.set_stack_fault(trap, MLSPERR, LSPERR);
                self.cpu.nvic.pend_system(exception);
                self.cpu.schedule_check();
            }
            self.cpu.scb.fpccr &= !LSPACT;
        }
        if self.cpu.scb.fpccr & ASPEN != 0 && !self.cpu.float_active {
            self.cpu.fpscr = self.cpu.fpscr & !0x07C0_0000 | self.cpu.scb.fpdscr;
            self.cpu.float_active = true;
        }
        self.cpu.float_ready = true;
        Ok(())
    }

    /// Returns from an exception with `EXC_RETURN` in the PC (`ExceptionReturn`).
    pub(crate) fn leave(&mut self, link: u32) -> Result<(), Trap> {
        let returning = self.cpu.ipsr;
        let (handler, process, float) = match link & 0x1F {
            kind @ (0x11 | 0x01) => (true, false, kind & 0x10 == 0),
            kind @ (0x19 | 0x09) => (false, false, kind & 0x10 == 0),
            kind @ (0x1D | 0x0D) => (false, true, kind & 0x10 == 0),
            _ => return self.refuse(link),
        };
        let nested = self.cpu.nvic.active_count() > 1;
        // CCR.NONBASETHRDENA lets a nested handler return to thread mode.
        let fits = if handler { nested } else { !nested || self.cpu.scb.ccr & 1 != 0 };
        if !self.cpu.nvic.is_active(returning) || !fits || link & 0x0FFF_FFE0 != 0x0FFF_FFE0 {
            return self.refuse(link);
        }
        self.profile_return(returning);
        self.pass(returning, false);
        if returning != NMI {
            self.cpu.faultmask = false;
        }
        self.cpu.nvic.update(&mut self.interrupts);
        self.cpu.nvic.deactivate(returning);
        let priority = self.cpu.execution_priority();
        if let Some(next) = self.cpu.enters(priority) {
            self.cpu.cost = TAIL_CHAIN;
            self.cpu.r[14] = link;
            self.activate(next);
            self.cpu.spend_exception();
            return Ok(());
        }
        self.cpu.cost = RETURN;
        self.unstack(handler, process, float, link)?;
        self.cpu.spend_exception();
        if !handler && self.cpu.scb.sleeps_on_exit() {
            self.cpu.asleep = Some(Sleep::Interrupt);
        }
        self.cpu.schedule_check();
        Ok(())
    }

    /// Ends the exception after an invalid `EXC_RETURN`; a usage fault follows.
    fn refuse(&mut self, link: u32) -> Result<(), Trap> {
        self.cpu.nvic.deactivate(self.cpu.ipsr);
        self.cpu.r[14] = link;
        Err(Trap::InvalidReturn)
    }

    fn unstack(&mut self, handler: bool, process: bool, float: bool, link: u32) -> Result<(), Trap> {
        let frame = self.cpu.stack_pointer(process);
        let mut words = [0; 8];
        for (at, word) in (frame..).step_by(4).zip(&mut words) {
            match self.load_aligned(at) {
                Ok(value) => *word = value,
                Err(Trap::Stop) => return Err(Trap::Stop),
                Err(trap) => {
                    let exception = self.set_stack_fault(trap, MUNSTKERR, UNSTKERR);
                    self.cpu.r[14] = link;
                    let exception = if self.cpu.scb.handles(exception) { exception } else { HARD_FAULT };
                    self.cpu.nvic.pend_system(exception);
                    self.cpu.schedule_check();
                    return Ok(());
                }
            }
        }
        let xpsr = words[7];
        let ipsr = (xpsr & 0x1FF) as u16;
        if (ipsr != 0) != handler || ipsr >= EXTERNAL + crate::LINES {
            return Err(Trap::InvalidReturn);
        }
        if float {
            if self.cpu.scb.fpccr & LSPACT != 0 {
                // The registers were never stored, so they are still valid.
                self.cpu.scb.fpccr &= !LSPACT;
            } else {
                self.cpu.cost += FLOAT_FRAME;
                for s in 0..16 {
                    self.cpu.s[s as usize] = self.load_aligned(frame + BASIC_FRAME + 4 * s)?;
                }
                self.cpu.fpscr = self.load_aligned(frame + BASIC_FRAME + 64)? & crate::float::FPSCR_BITS;
            }
        }
        let cpu = &mut self.cpu;
        cpu.float_active = float;
        cpu.float_ready = false;
        cpu.use_process_stack(process);
        let size = if float { EXTENDED_FRAME } else { BASIC_FRAME };
        let padding = 4 * u32::from(xpsr >> 9 & 1 == 1 && (cpu.scb.aligns_stack() || float));
        cpu.r[13] = frame.wrapping_add(size) | padding;
        (cpu.r[0], cpu.r[1], cpu.r[2], cpu.r[3], cpu.r[12], cpu.r[14]) =
            (words[0], words[1], words[2], words[3], words[4], words[5]);
        cpu.pc = words[6] & !1 | if xpsr >> 24 & 1 == 0 { crate::cpu::INVALID } else { 0 };
        cpu.flags = Flags::from_bits(xpsr);
        cpu.it = ((xpsr >> 25 & 3) | (xpsr >> 10 & 0x3F) << 2) as u8;
        cpu.ipsr = ipsr;
        cpu.fetched = 1;
        cpu.exclusive = None;
        cpu.event = true;
        Ok(())
    }
}
