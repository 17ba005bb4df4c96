//! What a debugger, or a fault of the processor, does to the run from outside of the program.

use crate::chip::{Chip, Cycle, Ports};
use crate::machine::{Machine, Stop};
use crate::op::Size;

impl<C: Chip> Machine<C> {
    /// Holds the processor until a cycle, as a debugger that has halted it does (C1.5.1): the part goes on, a reset ends the halt. DWT_CYCCNT stands
    /// meanwhile (C1.8.7).
    pub fn hold(&mut self, until: Cycle) -> Result<(), Stop> {
        self.cpu.attend();
        let (control, enabled) = (self.cpu.dwt.control, self.cpu.dwt.enabled);
        self.cpu.dwt.set_control(control, false, self.cpu.cycle);
        self.tell_part(true)?;
        let pc = self.cpu.pc;
        while self.cpu.cycle < until {
            self.settle().map_err(|_| self.stop())?;
            if self.cpu.pc != pc {
                // Only a reset moves it. It has also put the counter into its reset state.
                return self.tell_part(false);
            }
            self.cpu.cycle = self.chip.due().min(until).max(self.cpu.cycle);
        }
        self.cpu.dwt.set_control(control, enabled, self.cpu.cycle);
        self.tell_part(false)
    }

    fn tell_part(&mut self, halted: bool) -> Result<(), Stop> {
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
