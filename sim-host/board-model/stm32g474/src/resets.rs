//! Clock failures and reset flags. RM0440 7.1, 7.2.11.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::rcc::regs::Pllcfgr;
use stm32_metapac::rcc::vals::Pllsrc;

use crate::map::base::RCC;
use crate::map::{Registers, at};
use crate::part::Stm32g474;
use crate::rcc::FLAGS;
use crate::time::Event;
use crate::wires::Wires;

// Flags of RCC_CSR (RM0440 7.4.28).
const PIN: u32 = 1 << 26;
const BOR: u32 = 1 << 27;
const SOFTWARE: u32 = 1 << 28;
/// Flag of the independent watchdog in RCC_CSR.
pub(crate) const IWDG_FLAG: u32 = 1 << 29;

impl<W: Wires> Stm32g474<W> {
    /// Stops the crystal: with CSS on, the core switches to HSI, and the NMI is pended (7.2.11).
    pub(crate) fn hse_stops(&mut self, at: Cycle, ports: &mut Ports) -> Result<(), Fault> {
        self.rcc.hse_dead = true;
        let mut cr = self.cr();
        if !cr.hserdy() {
            return Ok(());
        }
        let source = Pllcfgr(self.regs[RCC + at::rcc::PLLCFGR]).pllsrc();
        let used = self.cfgr().sws().to_bits();
        let from_hse = used == 2 || (used == 3 && source == Pllsrc::HSE);
        cr.set_hserdy(false);
        if cr.csson() {
            cr.set_hseon(false);
            if source == Pllsrc::HSE {
                cr.set_pllon(false);
                cr.set_pllrdy(false);
            }
            self.regs[RCC + at::rcc::CIFR] |= 1 << 8;
            ports.interrupts.pend_nmi();
            self.clock_failure_break(at, ports);
            if from_hse {
                cr.set_hsion(true);
                cr.set_hsirdy(true);
                self.regs[RCC + at::rcc::CFGR] = self.cfgr().0 & !0xf | 0b0101;
            }
        }
        self.regs[RCC + at::rcc::CR] = cr.0;
        self.set_clock(at)
    }

    /// Unlocks the PLL. If it is the system clock, everything that counts its cycles stops until
    /// the watchdog, which has its own oscillator, resets the chip.
    pub(crate) fn pll_unlocks(&mut self, at: Cycle) -> Result<(), Fault> {
        self.regs[RCC + at::rcc::CR] &= !(1 << 25);
        if self.cfgr().sws().to_bits() == 3 {
            let bite = self.agenda.get(Event::Iwdg);
            if bite == Cycle::MAX {
                return self.refuse(self.now(at), RCC + at::rcc::CR, "the processor without a clock");
            }
            let before = self.time;
            self.time.stop_until(at, before.ps(bite));
            self.agenda.retime(&before, &self.time);
        }
        Ok(())
    }

    /// Sets RCC_CSR after a reset: its cause, and the pin, which every reset pulls (7.1.2).
    /// Power-on clears older flags.
    pub(crate) fn reset_flags(&mut self, before: &Registers) {
        let cause = std::mem::take(&mut self.rcc);
        let own = if cause.cause == 0 { SOFTWARE } else { cause.cause };
        let old = before[RCC + at::rcc::CSR] & FLAGS;
        self.regs[RCC + at::rcc::CSR] = if cause.power_lost { BOR | PIN } else { old | own | PIN };
        self.rcc.hse_dead = cause.hse_dead;
    }
}
