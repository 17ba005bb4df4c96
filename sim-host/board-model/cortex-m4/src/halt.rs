//! Actions on the run from outside the program, by a debugger or a fault of the processor.

use crate::chip::{Chip, Cycle, Ports};
use crate::machine::{Machine, Stop};
use crate::op::Size;

/// Address of SysTick's control register; a read clears its COUNTFLAG (B3.3.3).
const SYST_CSR: u32 = 0xE000_E010;

impl<C: Chip> Machine<C> {
    /// Advances time to a cycle while the processor is halted by a debugger (C1.5).
    ///
    /// The chip continues, exceptions stay pending, DWT_CYCCNT and SysTick stop (C1.8, B3.3). After
    /// a reset during the halt, the processor is at its first instruction.
    pub fn halt_until(&mut self, until: Cycle) -> Result<(), Stop> {
        self.cpu.schedule_check();
        let (began, pc) = (self.cpu.cycle, self.cpu.pc);
        let (control, enabled) = (self.cpu.dwt.control, self.cpu.dwt.enabled);
        self.cpu.dwt.set_control(control, false, began);
        let zero = self.cpu.systick.hold();
        let mut passed = Ok(());
        while passed.is_ok() && self.cpu.cycle < until {
            self.cpu.cycle = self.chip.due().min(until).max(self.cpu.cycle);
            passed = self.settle().map_err(|_| self.stop());
        }
        // Only a reset changes the program counter; it has also reset both counters.
        if self.cpu.pc == pc {
            self.cpu.dwt.set_control(control, enabled, self.cpu.cycle);
            self.cpu.systick.resume(zero, self.cpu.cycle - began);
        }
        passed
    }

    /// Reads a register of the processor (NVIC, SCB, MPU, DWT: B3.1) as a debugger does. `None` if
    /// it is not modelled, or if the read would change it.
    pub fn processor_register(&mut self, address: u32) -> Option<u32> {
        if address == SYST_CSR { None } else { self.read_register(address) }
    }

    /// Reports to the chip that a debugger has halted or resumed the processor, which stops or
    /// restarts some of its timers (C1.5.1).
    pub fn set_halted(&mut self, halted: bool) -> Result<(), Stop> {
        self.cpu.schedule_check();
        let ports = Ports { memory: &mut self.memory, interrupts: &mut self.interrupts };
        let told = self.chip.halt(self.cpu.cycle, halted, ports).map_err(|fault| self.cpu.trap(fault));
        told.map_err(|_| self.stop())
    }

    /// Writes a word as a debugger does: to memory, or to a register of the chip or of the
    /// processor.
    pub fn poke(&mut self, address: u32, value: u32) -> Result<(), Stop> {
        let stored = self.store(Size::Word, address, value);
        self.cpu.schedule_check();
        stored.map_err(|_| self.stop())
    }

    /// Sets PRIMASK, which blocks all interrupts but the non-maskable one and the hard fault.
    pub fn mask_interrupts(&mut self) {
        self.cpu.primask = true;
        self.cpu.schedule_check();
    }
}
