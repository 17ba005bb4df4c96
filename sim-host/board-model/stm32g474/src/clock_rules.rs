//! Rules of the manual for a change of the core clock. RM0440 3.3.3, 6.1.5, 7.2.7.

use cortex_m4::Fault;
use stm32_metapac::flash::regs::Acr;
use stm32_metapac::rcc::regs::Cfgr;

use crate::finding::Rule;
use crate::map::at;
use crate::map::base::{FLASH, PWR, RCC};
use crate::part::{Now, Stm32g474};
use crate::rcc::hpre;
use crate::time::US;
use crate::wires::Wires;

/// PWR_CR5.R1MODE (6.4.5): the regulator is in boost mode if it is cleared.
const R1MODE: u32 = 1 << 8;

impl<W: Wires> Stm32g474<W> {
    /// Checks a change of the core clock: voltage (6.1.5), wait states (3.3.3), and the
    /// intermediate step at half the frequency (7.2.7).
    pub(crate) fn check_clock(&mut self, now: Now, old: Cfgr, new: Cfgr, used: u8) -> Result<(), Fault> {
        let address = RCC + at::rcc::CFGR;
        let (before, system) = (self.time.hz(), self.sysclk(used));
        let after = system / hpre(new);
        if after > self.most_hz() {
            self.report(now, address, 0xf3, new.0, Rule::Boost)?;
        }
        if self.wait_states(after) > Acr(self.regs[FLASH + at::flash::ACR]).latency().to_bits() {
            self.report(now, address, 0xf3, new.0, Rule::WaitStates)?;
        }
        let time = self.time.ps(now.at);
        if after > 80_000_000 && before <= 80_000_000 {
            let halved = self.rcc.halved.is_some_and(|since| time - since >= US);
            // 85 MHz, the step before 170, is itself above 80.
            if old.sws().to_bits() != used && after * 2 <= system {
                self.rcc.halved = Some(time);
            } else if !halved || old.sws().to_bits() != used {
                self.report(now, address, 0xf3, new.0, Rule::HalfFrequency)?;
            }
        } else if after > before && after > 80_000_000 {
            if self.rcc.halved.is_some_and(|since| time - since < US) {
                self.report(now, address, 0xf0, new.0, Rule::HalfFrequency)?;
            }
        } else if after <= 80_000_000 {
            self.rcc.halved = (system > 80_000_000).then_some(time);
        }
        Ok(())
    }

    /// Returns the maximum clock at the current voltage: 170 MHz in boost, 150 MHz in range 1, 26
    /// MHz in range 2 (6.1.5).
    pub(crate) fn most_hz(&self) -> u64 {
        match (self.range(), self.regs[PWR + at::pwr::CR5] & R1MODE == 0) {
            (1, true) => 170_000_000,
            (1, false) => 150_000_000,
            _ => 26_000_000,
        }
    }

    /// Returns the wait states that a clock needs: steps of 34 MHz in boost, 30 in range 1, 12 in
    /// range 2 (3.3.3, table of wait states).
    pub(crate) fn wait_states(&self, hz: u64) -> u8 {
        let step = match self.most_hz() {
            170_000_000 => 34_000_000,
            150_000_000 => 30_000_000,
            _ => 12_000_000,
        };
        hz.div_ceil(step).saturating_sub(1) as u8
    }
}
