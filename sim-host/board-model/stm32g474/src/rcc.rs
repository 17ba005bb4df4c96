//! Clock tree and resets. RM0440 7.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::rcc::regs::{Cfgr, Cr, Csr, Pllcfgr};
use stm32_metapac::rcc::vals::Pllsrc;

use crate::finding::Rule;
use crate::map::base::RCC;
use crate::map::{REGISTERS, at};
use crate::part::{Now, Stm32g474};
use crate::time::{Event, Ps, US};
use crate::wires::Wires;

/// Frequency of HSI16, Hz.
pub const HSI_HZ: u64 = 16_000_000;

// Indices of the clocks in `Event::Ready`.
const HSI: usize = 0;
const HSE: usize = 1;
const PLL: usize = 2;
const LSI: usize = 3;
const HSI48: usize = 4;
/// Typical start-up times (DS12288, oscillator characteristics): HSI16, HSE, PLL lock, LSI, HSI48.
const START_UP: [Ps; 5] = [US, 2000 * US, 15 * US, 130 * US, 4 * US];

/// Reset flags of RCC_CSR (7.4.28).
pub(crate) const FLAGS: u32 = 0xfe << 24;

/// State of RCC besides its registers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rcc {
    /// Enable register and bits of the last write.
    pub enabled: (u32, u32),
    /// Cycle from which the enabled peripherals may be accessed.
    pub settled: Cycle,
    /// Flags of the current reset.
    pub cause: u32,
    pub power_lost: bool,
    /// Time since which the core has half of a clock above 80 MHz.
    pub halved: Option<Ps>,
    pub hse_dead: bool,
}

/// Returns the division of RCC_CFGR.HPRE (7.4.3).
pub(crate) fn hpre(cfgr: Cfgr) -> u64 {
    match cfgr.hpre().to_bits() {
        code @ 8..=11 => 2 << (code - 8),
        code @ 12..=15 => 64 << (code - 12),
        _ => 1,
    }
}

/// Returns the division of RCC_CFGR.PPRE1 or 2.
fn ppre(code: u8) -> u64 {
    if code < 4 { 1 } else { 2 << (code - 4) }
}

impl<W: Wires> Stm32g474<W> {
    pub(crate) fn cr(&self) -> Cr {
        Cr(self.regs[RCC + at::rcc::CR])
    }

    pub(crate) fn cfgr(&self) -> Cfgr {
        Cfgr(self.regs[RCC + at::rcc::CFGR])
    }

    /// Returns the core cycles of a cycle of APB1 or 2.
    pub(crate) fn apb(&self, bus: u8) -> u64 {
        ppre(if bus == 1 { self.cfgr().ppre1().to_bits() } else { self.cfgr().ppre2().to_bits() })
    }

    /// Returns the core cycles of a timer cycle: a timer has twice the bus clock if that is divided
    /// (7.2.13).
    pub(crate) fn timer_cycle(&self) -> u64 {
        match self.apb(1) {
            1 => 1,
            divided => divided / 2,
        }
    }

    /// Returns SYSCLK for a selection, Hz.
    pub(crate) fn sysclk(&self, sw: u8) -> u64 {
        match sw {
            1 => self.config.hsi_hz,
            2 => self.config.crystal_hz.unwrap_or(0),
            _ => self.vco() / (2 * (u64::from(Pllcfgr(self.regs[RCC + at::rcc::PLLCFGR]).pllr().to_bits()) + 1)),
        }
    }

    /// Returns the current SYSCLK, Hz.
    pub(crate) fn system_hz(&self) -> u64 {
        self.sysclk(self.cfgr().sws().to_bits())
    }

    /// Returns output P of the PLL, Hz: divided by PLLPDIV, or by 7 or 17 (7.4.4).
    pub(crate) fn pll_p(&self) -> u64 {
        let pll = Pllcfgr(self.regs[RCC + at::rcc::PLLCFGR]);
        let divider = match pll.0 >> 27 {
            0 => 7 + 10 * u64::from(pll.0 >> 17 & 1),
            divider => u64::from(divider),
        };
        self.vco() / divider
    }

    fn pll_input(&self) -> u64 {
        let pll = Pllcfgr(self.regs[RCC + at::rcc::PLLCFGR]);
        let source = match pll.pllsrc() {
            Pllsrc::HSI => self.config.hsi_hz,
            Pllsrc::HSE => self.config.crystal_hz.unwrap_or(0),
            _ => 0,
        };
        source / (u64::from(pll.pllm().to_bits()) + 1)
    }

    fn vco(&self) -> u64 {
        self.pll_input() * u64::from(Pllcfgr(self.regs[RCC + at::rcc::PLLCFGR]).plln().to_bits())
    }

    fn ready_bit(clock: usize) -> (u32, u32) {
        match clock {
            HSI => (RCC + at::rcc::CR, 1 << 10),
            HSE => (RCC + at::rcc::CR, 1 << 17),
            PLL => (RCC + at::rcc::CR, 1 << 25),
            LSI => (RCC + at::rcc::CSR, 1 << 1),
            _ => (RCC + at::rcc::CRRCR, 1 << 1),
        }
    }

    /// Handles a clock that is switched on or off.
    fn switch(&mut self, now: Now, clock: usize, was: bool, on: bool) {
        let (register, bit) = Self::ready_bit(clock);
        if on && !was {
            let dead = clock == HSE && (self.config.crystal_hz.is_none() || self.rcc.hse_dead);
            if !dead {
                let due = self.time.cycle(self.time.ps(now.at) + START_UP[clock]);
                self.agenda.set(Event::Ready(clock), due);
            }
        } else if !on {
            self.agenda.clear(Event::Ready(clock));
            self.regs[register] &= !bit;
        }
    }

    pub(crate) fn clock_ready(&mut self, _at: Cycle, clock: usize, _ports: &mut Ports) {
        let (register, bit) = Self::ready_bit(clock);
        self.regs[register] |= bit;
    }

    pub(crate) fn write_rcc(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let old = self.regs[address];
        match address - RCC {
            at::rcc::CR => self.write_cr(now, Cr(old), Cr(value))?,
            at::rcc::CFGR => self.write_cfgr(now, Cfgr(old), Cfgr(value))?,
            at::rcc::PLLCFGR => {
                if self.cr().pllon() && value & !0x111_0000 != old & !0x111_0000 {
                    self.report(now, address, value ^ old, value, Rule::PllRunning)?;
                }
                self.regs[address] = value;
            }
            at::rcc::CSR => {
                let (before, wanted) = (Csr(old), Csr(value));
                self.switch(now, LSI, before.lsion(), wanted.lsion());
                let kept = if wanted.rmvf() { 0 } else { old & FLAGS };
                self.regs[address] = kept | (self.regs[address] & 2) | (value & 1);
            }
            at::rcc::CRRCR => {
                self.switch(now, HSI48, old & 1 != 0, value & 1 != 0);
                self.regs[address] = self.regs[address] & !1 | value & 1;
            }
            at::rcc::CICR => self.regs[RCC + at::rcc::CIFR] &= !value,
            at::rcc::CIER => {
                self.refuse_bits(now, address, value, u32::MAX)?;
            }
            at::rcc::BDCR => self.refuse_bits(now, address, value, u32::MAX)?,
            at::rcc::AHB1ENR | at::rcc::AHB2ENR | at::rcc::AHB3ENR | at::rcc::APB1ENR1 | at::rcc::APB1ENR2 | at::rcc::APB2ENR => {
                let risen = value & !old;
                if risen != 0 {
                    // Two cycles of the peripheral's bus (7.2.17).
                    (self.rcc.enabled, self.rcc.settled) = ((address, risen), now.at + 2 * self.apb(1).max(self.apb(2)));
                }
                self.regs[address] = value;
            }
            at::rcc::AHB1RSTR
            | at::rcc::AHB2RSTR
            | at::rcc::AHB3RSTR
            | at::rcc::APB1RSTR1
            | at::rcc::APB1RSTR2
            | at::rcc::APB2RSTR => {
                self.regs[address] = value;
                self.reset_peripherals(now, address, value & !old, ports);
            }
            _ => self.regs[address] = value,
        }
        Ok(())
    }

    /// Resets the peripherals whose bit has risen.
    fn reset_peripherals(&mut self, now: Now, register: u32, bits: u32, ports: &mut Ports) {
        let hit = |reset: Option<(u32, u32)>| reset.is_some_and(|(at, bit)| at == register && bit & bits != 0);
        self.regs.reset(|register| hit(register.reset));
        let mut bases: Vec<u32> = REGISTERS.iter().filter(|register| hit(register.reset)).map(|register| register.base).collect();
        bases.dedup();
        for base in bases {
            self.reset_state(now, base, ports);
        }
    }

    fn write_cr(&mut self, now: Now, old: Cr, new: Cr) -> Result<(), Fault> {
        let address = RCC + at::rcc::CR;
        let used = self.cfgr().sws().to_bits();
        let mut kept = new;
        // The source of the core clock cannot be stopped (7.4.1).
        let source = Pllcfgr(self.regs[RCC + at::rcc::PLLCFGR]).pllsrc();
        kept.set_hsion(new.hsion() || used == 1 || (used == 3 && source == Pllsrc::HSI));
        kept.set_hseon(new.hseon() || used == 2 || (used == 3 && source == Pllsrc::HSE));
        kept.set_pllon(new.pllon() || used == 3);
        if kept.pllon() && !old.pllon() {
            let ready = match source {
                Pllsrc::HSI => old.hsirdy(),
                Pllsrc::HSE => old.hserdy(),
                _ => false,
            };
            if !ready {
                self.report(now, address, 1 << 24, new.0, Rule::ClockNotReady)?;
            }
            // DS12288, PLL characteristics: input 2.66 to 16 MHz, VCO 96 to 344 MHz, output to 170
            // MHz.
            let fits = (2_660_000..=16_000_000).contains(&self.pll_input())
                && (96_000_000..=344_000_000).contains(&self.vco())
                && self.sysclk(3) <= 170_000_000;
            if !fits {
                self.report(now, RCC + at::rcc::PLLCFGR, u32::MAX, self.regs[RCC + at::rcc::PLLCFGR], Rule::PllRange)?;
            }
        }
        let ready = 1 << 10 | 1 << 17 | 1 << 25;
        self.regs[address] = kept.0 & !ready | old.0 & ready;
        self.switch(now, HSI, old.hsion(), kept.hsion());
        self.switch(now, HSE, old.hseon(), kept.hseon());
        self.switch(now, PLL, old.pllon(), kept.pllon());
        Ok(())
    }

    fn write_cfgr(&mut self, now: Now, old: Cfgr, new: Cfgr) -> Result<(), Fault> {
        let address = RCC + at::rcc::CFGR;
        let wanted = new.sw().to_bits();
        let ready = match wanted {
            1 => self.cr().hsirdy(),
            2 => self.cr().hserdy(),
            3 => self.cr().pllrdy() && Pllcfgr(self.regs[RCC + at::rcc::PLLCFGR]).pllren(),
            _ => return self.refuse(now, address, "SW = 0"),
        };
        let used = if ready { wanted } else { old.sws().to_bits() };
        if !ready {
            self.report(now, address, 3, new.0, Rule::ClockNotReady)?;
        }
        self.check_clock(now, old, new, used)?;
        self.regs[address] = new.0 & !0xc | u32::from(used) << 2;
        self.set_clock(now.at)
    }

    /// Applies the clock that RCC_CFGR selects.
    pub(crate) fn set_clock(&mut self, at: Cycle) -> Result<(), Fault> {
        let hz = (self.sysclk(self.cfgr().sws().to_bits()) / hpre(self.cfgr())).max(1);
        if hz != self.time.hz() {
            let before = self.time;
            self.time.set(at, hz);
            self.agenda.retime(&before, &self.time.clone());
        }
        self.retime_timers(at);
        self.retime_counter(at);
        self.retime_adcs(self.now(at))
    }
}
