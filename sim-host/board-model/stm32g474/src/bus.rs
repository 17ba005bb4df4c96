//! Bus: dispatch of accesses to the peripherals, and checks of every access.

use cortex_m4::{Access, Chip, Cycle, Fault, Ports, Width};

use crate::adc::Adc;
use crate::art::Art;
use crate::contention;
use crate::factory;
use crate::finding::Rule;
use crate::iwdg::Iwdg;
use crate::map::{self, Register, Registers, base};
use crate::part::{Now, Stm32g474};
use crate::tim1::Tim1;
use crate::time::Agenda;
use crate::timer::Timer;
use crate::wires::Wires;

impl<W: Wires> Stm32g474<W> {
    /// Returns the register at an address that a program accesses, if its peripheral has a clock.
    fn target(&mut self, now: Now, address: u32) -> Result<(&'static Register, u32), Fault> {
        let Some(found) = self.regs.find(address & !3) else {
            return if Registers::covers(address) { self.refuse(now, address, "a register") } else { Err(Fault::Bus) };
        };
        if let Some((enable, bit)) = found.0.enable {
            if self.regs[enable] & bit == 0 {
                self.report(now, found.0.address, u32::MAX, 0, Rule::Unclocked)?;
            } else if now.at < self.rcc.settled && self.rcc.enabled == (enable, self.rcc.enabled.1 | bit) {
                self.report(now, found.0.address, u32::MAX, 0, Rule::ClockSettle)?;
            }
        }
        Ok(found)
    }

    /// Reads a register over the bus: for a program, or for DMA.
    pub(crate) fn load(&mut self, now: Now, register: &Register, ports: &mut Ports) -> Result<u32, Fault> {
        let address = register.address;
        match register.base {
            base::GPIOA | base::GPIOB | base::GPIOC | base::GPIOD | base::GPIOE | base::GPIOF | base::GPIOG => {
                Ok(self.read_gpio(now, address))
            }
            base::DMA1 | base::DMA2 => Ok(self.read_dma(address)),
            base::TIM2 | base::TIM3 | base::TIM4 | base::TIM5 => Ok(self.read_timer(now, address)),
            base::TIM1 => Ok(self.read_tim1(now, address)),
            base::ADC1 | base::ADC2 | base::ADC3 | base::ADC4 | base::ADC5 => Ok(self.read_adc(now, address, ports)),
            base::ADC12_COMMON | base::ADC345_COMMON => Ok(self.read_adc_common(now, address, ports)),
            base::DAC1 | base::DAC2 | base::DAC3 | base::DAC4 => Ok(self.read_dac(address)),
            base::IWDG if address == base::IWDG + map::at::iwdg::SR => Ok(self.iwdg_status(now.at)),
            base::IWDG => Ok(self.regs[address]),
            base::DBGMCU if address == base::DBGMCU + map::at::dbgmcu::IDCODE => Ok(factory::idcode(&self.config)),
            base::LPUART1 => Ok(self.read_uart(now, address, ports)),
            base::COMP1
            | base::COMP2
            | base::COMP3
            | base::COMP4
            | base::COMP5
            | base::COMP6
            | base::COMP7
            | base::OPAMP1
            | base::OPAMP2
            | base::OPAMP3
            | base::OPAMP4
            | base::OPAMP5
            | base::OPAMP6
            | base::RCC
            | base::PWR
            | base::SYSCFG
            | base::FLASH
            | base::DMAMUX1
            | base::EXTI
            | base::DBGMCU => Ok(self.regs[address]),
            _ => self.refuse(now, address, "the peripheral"),
        }
    }

    /// Writes a register over the bus.
    pub(crate) fn store(&mut self, now: Now, register: &Register, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let address = register.address;
        match register.base {
            base::GPIOA | base::GPIOB | base::GPIOC | base::GPIOD | base::GPIOE | base::GPIOF | base::GPIOG => {
                self.write_gpio(now, address, value, ports)
            }
            base::DMA1 | base::DMA2 => self.write_dma(now, address, value, ports),
            base::DMAMUX1 => self.write_dmamux(now, address, value, ports),
            base::TIM2 | base::TIM3 | base::TIM4 | base::TIM5 => self.write_timer(now, address, value, ports),
            base::TIM1 => self.write_tim1(now, address, value, ports),
            base::ADC1 | base::ADC2 | base::ADC3 | base::ADC4 | base::ADC5 => self.write_adc(now, address, value, ports),
            base::ADC12_COMMON | base::ADC345_COMMON => self.write_adc_common(now, address, value),
            base::DAC1 | base::DAC2 | base::DAC3 | base::DAC4 => self.write_dac(now, address, value, ports),
            base::LPUART1 => self.write_uart(now, address, value, ports),
            base::COMP1 | base::COMP2 | base::COMP3 | base::COMP4 | base::COMP5 | base::COMP6 | base::COMP7 => {
                self.write_comp(now, address, value, ports)
            }
            base::OPAMP1 | base::OPAMP2 | base::OPAMP3 | base::OPAMP4 | base::OPAMP5 | base::OPAMP6 => {
                self.write_opamp(now, address, value)
            }
            base::RCC => self.write_rcc(now, address, value, ports),
            base::PWR => self.write_pwr(now, address, value, ports),
            base::SYSCFG => self.write_syscfg(now, address, value, ports),
            base::FLASH => self.write_flash_register(now, address, value, ports),
            base::IWDG => self.write_iwdg(now, address, value),
            base::EXTI => self.write_exti(now, address, value, ports),
            base::DBGMCU => {
                self.regs[address] = value;
                Ok(())
            }
            _ => self.refuse(now, address, "the peripheral"),
        }
    }
}

impl<W: Wires> Chip for Stm32g474<W> {
    fn read(&mut self, access: Access, mut ports: Ports) -> Result<u32, Fault> {
        let now = Now { at: access.at, pc: access.pc };
        self.pc = access.pc;
        self.run(access.at, &mut ports)?;
        let shift = access.address % 4 * 8;
        let word = match factory::read(access.address & !3, &self.config) {
            Some(word) => word,
            None => {
                let (register, _) = self.target(now, access.address)?;
                self.load(now, register, &mut ports)?
            }
        };
        Ok(match access.width {
            Width::Word => word,
            Width::Half => word >> shift & 0xffff,
            Width::Byte => word >> shift & 0xff,
        })
    }

    fn write(&mut self, access: Access, value: u32, mut ports: Ports) -> Result<(), Fault> {
        let now = Now { at: access.at, pc: access.pc };
        self.pc = access.pc;
        self.run(access.at, &mut ports)?;
        if (0x0800_0000..0x0808_0000).contains(&access.address) {
            return self.program(now, access, value, &mut ports);
        }
        let (register, mask) = self.target(now, access.address)?;
        let narrow = match access.width {
            Width::Word => None,
            Width::Half => Some(0xffff_u32),
            Width::Byte => Some(0xff),
        };
        let value = match narrow {
            None => value,
            Some(lanes) => {
                if register.peripheral.starts_with("DAC") || register.peripheral.starts_with("ADC") {
                    self.report(now, register.address, u32::MAX, value, Rule::Width)?;
                }
                let shift = access.address % 4 * 8;
                let old = if register.access == map::Access::Write { 0 } else { self.regs[register.address] };
                old & !(lanes << shift) | (value & lanes) << shift
            }
        };
        if register.access == map::Access::Read {
            return self.report(now, register.address, u32::MAX, value, Rule::ReadOnly);
        }
        let reserved = (value ^ self.regs[register.address]) & !mask;
        // Flags that a zero clears: programs write ones to the other bits, as ST's drivers do.
        let clears_by_zero = register.name == "SR" && register.peripheral.starts_with("TIM");
        if reserved != 0 && !clears_by_zero && (register.access != map::Access::Write || value & !mask != 0) {
            self.report(now, register.address, reserved, value, Rule::Reserved)?;
        }
        self.store(now, register, value, &mut ports)
    }

    fn due(&self) -> Cycle {
        let wires = self.wires.due();
        let wires = if wires == self.looked { Cycle::MAX } else { wires };
        self.agenda.next().min(wires).min(self.next_byte())
    }

    fn advance(&mut self, now: Cycle, mut ports: Ports) -> Result<(), Fault> {
        self.run(now, &mut ports)
    }

    fn fetch_wait(&mut self, address: u32, at: Cycle) -> u32 {
        (self.pc, self.last) = (address, at);
        self.flash_stall(address, at) + self.art.fetch(address, at)
    }

    fn load_wait(&mut self, address: u32, at: Cycle) -> u32 {
        self.flash_stall(address, at) + self.art.load(address)
    }

    fn access_wait(&mut self, address: u32) -> u32 {
        contention::wait(address)
    }

    fn held_up(&mut self) -> u32 {
        std::mem::take(&mut self.dma.held_up)
    }

    fn damaged(&mut self, address: u32, mut ports: Ports) -> Result<(), Fault> {
        self.ecc(address, &mut ports)
    }

    fn halt(&mut self, at: Cycle, halted: bool, ports: Ports) -> Result<(), Fault> {
        self.debugger(at, halted, ports)
    }

    fn lockup(&mut self, at: Cycle, mut ports: Ports) -> Result<(), Fault> {
        self.run(at, &mut ports)?;
        self.tim1.lockup = true;
        self.update_breaks(at, &mut ports);
        Ok(())
    }

    fn reset(&mut self, at: Cycle, mut ports: Ports) {
        let before = self.regs.clone();
        self.flash_loses_power(&mut ports);
        self.regs.reset(|_| true);
        self.reset_flags(&before);
        self.time.set(at, self.config.hsi_hz);
        self.agenda = Agenda::default();
        self.plan_defect();
        self.flash = self.flash.after_reset();
        self.art = Art::default();
        self.dma = self.dma.after_reset();
        self.timers.iter_mut().for_each(Timer::reset);
        self.tim1 = Tim1::default();
        self.adcs.iter_mut().for_each(Adc::reset);
        self.dacs = Default::default();
        self.uart.reset();
        self.iwdg = Iwdg::default();
        self.compared = 0;
        self.rewire();
        for line in 0..cortex_m4::LINES {
            ports.interrupts.set(line, false);
        }
        self.pins_changed(at);
        let flags = self.regs[base::RCC + map::at::rcc::CSR];
        self.wires.reset(at, flags);
    }
}
