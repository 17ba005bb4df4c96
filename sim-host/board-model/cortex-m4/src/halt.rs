//! What a debugger, or a fault of the processor, does to the run from outside of the program.

use crate::chip::{Chip, Cycle, Ports};
use crate::machine::{Machine, Stop};
use crate::op::Size;

/// SysTick's control register: a read clears its COUNTFLAG (B3.3.3).
const SYST_CSR: u32 = 0xE000_E010;

impl<C: Chip> Machine<C> {
    /// Lets time pass to a cycle while the processor stands, halted by a debugger (C1.5): the part goes on, exceptions stay pending, DWT_CYCCNT and
    /// SysTick stand (C1.8, B3.3). After a reset that falls into it the processor stands at its first instruction.
    pub fn stand_until(&mut self, until: Cycle) -> Result<(), Stop> {
        self.cpu.attend();
        let (began, pc) = (self.cpu.cycle, self.cpu.pc);
        let (control, enabled) = (self.cpu.dwt.control, self.cpu.dwt.enabled);
        self.cpu.dwt.set_control(control, false, began);
        let zero = self.cpu.systick.hold();
        let mut passed = Ok(());
        while passed.is_ok() && self.cpu.cycle < until {
            self.cpu.cycle = self.chip.due().min(until).max(self.cpu.cycle);
            passed = self.settle().map_err(|_| self.stop());
        }
        // Only a reset moves the program counter; it has also put both counters into their reset states.
        if self.cpu.pc == pc {
            self.cpu.dwt.set_control(control, enabled, self.cpu.cycle);
            self.cpu.systick.go_on(zero, self.cpu.cycle - began);
        }
        passed
    }

    /// A register of the processor (NVIC, SCB, MPU, DWT: B3.1) as a debugger reads it; none where the model has none, or where the read would change it.
    pub fn processor_register(&mut self, address: u32) -> Option<u32> {
        if address == SYST_CSR { None } else { self.read_register(address) }
    }

    /// A debugger has halted the processor, or lets it go on: the part is told, which halts some of its timers (C1.5.1).
    pub fn set_halted(&mut self, halted: bool) -> Result<(), Stop> {
        self.cpu.attend();
        let ports = Ports { memory: &mut self.memory, interrupts: &mut self.interrupts };
        let told = self.chip.halt(self.cpu.cycle, halted, ports).map_err(|fault| self.cpu.trap(fault));
        told.map_err(|_| self.stop())
    }

    /// Writes a word as a debugger does: to memory, to a register of the part or of the processor.
    pub fn poke(&mut self, address: u32, value: u32) -> Result<(), Stop> {
        let stored = self.store(Size::Word, address, value);
        self.cpu.attend();
        stored.map_err(|_| self.stop())
    }

    /// Sets PRIMASK: no interrupt is taken any more, but the non-maskable one and the hard fault.
    pub fn mask_interrupts(&mut self) {
        self.cpu.primask = true;
        self.cpu.attend();
    }
}
