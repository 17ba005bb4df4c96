//! Voltage range and supply monitor. RM0440 6.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::flash::regs::Acr;
use stm32_metapac::pwr::regs::Cr1;

use crate::finding::Rule;
use crate::map::at;
use crate::map::base::{FLASH, PWR, SYSCFG};
use crate::part::{Now, Stm32g474};
use crate::wires::Wires;

/// PWR_SR2.PVDO.
const PVDO: u32 = 1 << 11;

impl<W: Wires> Stm32g474<W> {
    /// Returns the voltage range, 1 or 2.
    pub(crate) fn range(&self) -> u8 {
        Cr1(self.regs[PWR + at::pwr::CR1]).vos().to_bits()
    }

    pub(crate) fn write_pwr(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        match address - PWR {
            at::pwr::CR1 => {
                if !(1..=2).contains(&Cr1(value).vos().to_bits()) {
                    return self.refuse(now, address, "VOS");
                }
                self.refuse_bits(now, address, value, 0x4007)?;
                self.change(now, address, value)?;
            }
            at::pwr::CR5 => self.change(now, address, value)?,
            at::pwr::CR2 => {
                self.refuse_bits(now, address, value, 0xf0)?;
                // SYSCFG_CFGR2.PVDL locks PVD (10.2.10).
                if self.regs[SYSCFG + at::syscfg::CFGR2] & 4 != 0 && value != self.regs[address] {
                    return self.report(now, address, value ^ self.regs[address], value, Rule::Locked);
                }
                self.regs[address] = value;
                self.update_pvd(ports);
                self.update_breaks(now.at, ports);
            }
            at::pwr::SCR => {}
            _ => self.regs[address] = value,
        }
        Ok(())
    }

    /// Changes the voltage and checks that it permits the current clock. The settling time (VOSF,
    /// 6.4.7) is not modelled.
    fn change(&mut self, now: Now, address: u32, value: u32) -> Result<(), Fault> {
        let old = std::mem::replace(&mut self.regs[address], value);
        let hz = self.time.hz();
        if hz > self.most_hz() {
            self.report(now, address, value ^ old, value, Rule::Boost)?;
        }
        if self.wait_states(hz) > Acr(self.regs[FLASH + at::flash::ACR]).latency().to_bits() {
            self.report(now, address, value ^ old, value, Rule::WaitStates)?;
        }
        Ok(())
    }

    /// Handles a supply that falls below the threshold of PVD, or recovers.
    pub(crate) fn supply(&mut self, at: Cycle, low: bool, ports: &mut Ports) {
        self.supply_low = low;
        self.update_pvd(ports);
        self.update_breaks(at, ports);
    }

    fn update_pvd(&mut self, ports: &mut Ports) {
        let was = self.pvd();
        let low = self.supply_low && self.regs[PWR + at::pwr::CR2] & 1 != 0;
        let status = &mut self.regs[PWR + at::pwr::SR2];
        *status = *status & !PVDO | if low { PVDO } else { 0 };
        if low != was {
            self.pvd_edge(low, ports);
        }
    }

    /// Returns PWR_SR2.PVDO: `true` if PVD detects a low supply.
    pub(crate) fn pvd(&self) -> bool {
        self.regs[PWR + at::pwr::SR2] & PVDO != 0
    }
}
