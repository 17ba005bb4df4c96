//! State of the machine as a debugger reads and writes it.

use crate::chip::{Chip, Cycle};
use crate::cpu::{Flags, INVALID};
use crate::elf::Symbols;
use crate::machine::Machine;

impl<C: Chip> Machine<C> {
    /// Returns the cycles since power-on.
    pub fn cycle(&self) -> Cycle {
        self.cpu.cycle
    }

    /// Returns the instructions since power-on, including skipped ones of an IT block.
    pub fn instructions(&self) -> u64 {
        self.cpu.instructions
    }

    /// Returns `true` if the processor has locked up, until the next reset.
    pub fn is_locked_up(&self) -> bool {
        self.cpu.locked
    }

    /// Returns `true` if the processor sleeps in `WFI` or `WFE`.
    pub fn is_asleep(&self) -> bool {
        self.cpu.asleep.is_some()
    }

    /// Returns the number of the active exception, 0 in thread mode.
    pub fn exception(&self) -> u16 {
        self.cpu.ipsr
    }

    /// Returns a register: R0 to R14; 15 is the address of the next instruction.
    pub fn register(&self, number: u8) -> u32 {
        if number == 15 { self.cpu.pc & !INVALID } else { self.cpu.get(number) }
    }

    /// Sets a register: R0 to R14; 15 is the address of the next instruction, which wakes a
    /// sleeping processor.
    pub fn set_register(&mut self, number: u8, value: u32) {
        if number == 15 {
            self.cpu.pc = value & !1;
            self.cpu.asleep = None;
        } else {
            self.cpu.set(number, value);
        }
    }

    /// Returns the bits of a floating-point register, S0 to S31.
    pub fn float_register(&self, number: u8) -> u32 {
        self.cpu.s[usize::from(number & 31)]
    }

    /// Returns APSR: the condition flags, Q and GE.
    pub fn flags(&self) -> u32 {
        self.cpu.flags.bits()
    }

    /// Returns xPSR: the condition flags, the state of an IT block and the active exception
    /// (B1.4.2).
    pub fn xpsr(&self) -> u32 {
        self.cpu.xpsr()
    }

    /// Sets the condition flags and the state of an IT block from xPSR; the exception does not
    /// change.
    pub fn set_xpsr(&mut self, xpsr: u32) {
        self.cpu.flags = Flags::from_bits(xpsr);
        self.cpu.it = ((xpsr >> 25 & 3) | (xpsr >> 10 & 0x3F) << 2) as u8;
    }

    /// Sets the bits of a floating-point register, S0 to S31.
    pub fn set_float_register(&mut self, number: u8, bits: u32) {
        self.cpu.s[usize::from(number & 31)] = bits;
    }

    /// Sets FPSCR.
    pub fn set_fpscr(&mut self, value: u32) {
        self.cpu.fpscr = value;
    }

    /// Returns FPSCR.
    pub fn fpscr(&self) -> u32 {
        self.cpu.fpscr
    }

    /// Returns the main or the process stack pointer, active or not.
    pub fn stack_pointer(&self, process: bool) -> u32 {
        self.cpu.stack_pointer(process)
    }

    /// Returns CFSR and HFSR: the cause of the last fault (ARM DDI 0403, B3.2.15 and B3.2.16).
    pub fn fault_status(&self) -> (u32, u32) {
        (self.cpu.scb.cfsr, self.cpu.scb.hfsr)
    }

    /// Returns the functions and objects of the image.
    pub fn symbols(&self) -> &Symbols {
        &self.symbols
    }
}
