//! System configuration and external interrupts. RM0440 10 and 15.

use cortex_m4::{Cycle, Fault, Ports};

use crate::finding::Rule;
use crate::map::base::{ADC1, ADC345_COMMON, DAC1, EXTI, LPUART1, SYSCFG, TIM1, TIM2, TIM5};
use crate::map::{at, line};
use crate::part::{Now, Stm32g474};
use crate::tim1::Tim1;
use crate::wires::Wires;

/// EXTI line of PVDO (15.3.2, table of lines).
pub(crate) const PVD: u32 = 1 << 16;

/// Returns the interrupt line of EXTI 0 to 15.
fn exti_line(number: u32) -> u16 {
    match number {
        0 => line::EXTI0,
        1 => line::EXTI1,
        2 => line::EXTI2,
        3 => line::EXTI3,
        4 => line::EXTI4,
        5..=9 => line::EXTI9_5,
        _ => line::EXTI15_10,
    }
}

impl<W: Wires> Stm32g474<W> {
    pub(crate) fn write_syscfg(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let old = self.regs[address];
        match address - SYSCFG {
            // CFGR2 (10.2.10): a lock stays set until a reset.
            at::syscfg::CFGR2 => {
                let cleared = old & !value & 0xf;
                if cleared != 0 {
                    self.report(now, address, cleared, value, Rule::Locked)?;
                }
                // SPF is cleared by a one.
                self.regs[address] = (old | value) & 0xf | old & !value & 1 << 8;
                self.update_breaks(now.at, ports);
            }
            at::syscfg::MEMRMP | at::syscfg::SCSR | at::syscfg::SKR => self.refuse_bits(now, address, value, u32::MAX)?,
            _ => self.regs[address] = value,
        }
        Ok(())
    }

    pub(crate) fn write_exti(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        match address - EXTI {
            // Lines of pins and of PVD are modelled; those of comparators and others are not
            // connected.
            at::exti::RTSR_0 | at::exti::FTSR_0 => self.refuse_bits(now, address, value, !(0xffff | PVD))?,
            at::exti::RTSR_1 | at::exti::FTSR_1 | at::exti::SWIER_0 | at::exti::SWIER_1 | at::exti::EMR_0 | at::exti::EMR_1 => {
                self.refuse_bits(now, address, value, u32::MAX)?;
            }
            at::exti::PR_0 => {
                self.regs[address] &= !value;
                self.exti_lines(ports);
                return Ok(());
            }
            _ => {}
        }
        self.regs[address] = value;
        self.exti_lines(ports);
        Ok(())
    }

    /// Detects edges of the pins that are selected for EXTI (15.3.2).
    pub(crate) fn update_exti(&mut self, at: Cycle, ports: &mut Ports) {
        let (rising, falling) = (self.regs[EXTI + at::exti::RTSR_0], self.regs[EXTI + at::exti::FTSR_0]);
        if rising | falling == 0 {
            return;
        }
        for number in (0..16).filter(|number| (rising | falling) >> number & 1 != 0) {
            let source = self.regs[SYSCFG + at::syscfg::EXTICR_0 + number / 4 * 4] >> (4 * (number % 4)) & 7;
            let level = self.levels(at, source as u8) >> number & 1 != 0;
            let was = self.exti >> number & 1 != 0;
            self.exti = self.exti & !(1 << number) | u16::from(level) << number;
            let edges = if level { rising } else { falling };
            if level != was && edges >> number & 1 != 0 {
                self.regs[EXTI + at::exti::PR_0] |= 1 << number;
            }
        }
        self.exti_lines(ports);
    }

    /// Handles a change of PVDO: an edge, if that edge is enabled.
    pub(crate) fn pvd_edge(&mut self, low: bool, ports: &mut Ports) {
        let edges = self.regs[EXTI + if low { at::exti::RTSR_0 } else { at::exti::FTSR_0 }];
        self.regs[EXTI + at::exti::PR_0] |= edges & PVD;
        self.exti_lines(ports);
    }

    fn exti_lines(&mut self, ports: &mut Ports) {
        let pending = self.regs[EXTI + at::exti::PR_0] & self.regs[EXTI + at::exti::IMR_0];
        ports.interrupts.set(line::PVD_PVM, pending & PVD != 0);
        for number in [0, 1, 2, 3, 4, 5, 10] {
            let group: u32 = match number {
                5 => 0x3e0,
                10 => 0xfc00,
                one => 1 << one,
            };
            ports.interrupts.set(exti_line(number), pending & group != 0);
        }
    }

    /// Resets the internal state of a peripheral that RCC resets.
    pub(crate) fn reset_state(&mut self, now: Now, base: u32, ports: &mut Ports) {
        match base {
            TIM1 => self.tim1 = Tim1::default(),
            TIM2..=TIM5 => self.reset_timer(now.at, base),
            ADC1..ADC345_COMMON => self.reset_adc(base),
            LPUART1 => self.uart.reset(),
            _ if base >= DAC1 && (base - DAC1).is_multiple_of(0x400) && (base - DAC1) / 0x400 < 4 => {
                self.dacs[((base - DAC1) / 0x400) as usize] = Default::default();
            }
            _ => {}
        }
        self.rewire();
        self.pins_changed(now.at);
        self.update_breaks(now.at, ports);
    }
}
