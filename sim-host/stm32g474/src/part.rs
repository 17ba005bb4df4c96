//! The part: who answers at which address, and what happens when.

use cortex_m4::{Access, Chip, Cycle, Fault, Memory, Ports, Region, Width};

use crate::adc::Adc;
use crate::art::Art;
use crate::dac::Dac;
use crate::defect::{Defect, Ram};
use crate::dma::Dma;
use crate::factory;
use crate::finding::{Finding, Lint, NotModelled, Rule};
use crate::flash::Flash;
use crate::gpio::Gpio;
use crate::iwdg::Iwdg;
use crate::map::{self, Register, Registers, base};
use crate::rcc::{HSI_HZ, Rcc};
use crate::tim1::Tim1;
use crate::time::{Agenda, Event, TimeBase};
use crate::timer::Timer;
use crate::uart::{RX_REQUEST, TX_REQUEST, Uart};
use crate::wires::{Pin, Wires};

/// What differs from one part, or board, to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// The crystal at PF0 and PF1, Hz; none: the oscillator never becomes ready.
    pub crystal_hz: Option<u64>,
    /// HSI16, Hz.
    pub hsi_hz: u64,
    /// LSI, Hz: 32 kHz, within 5 % (DS12288).
    pub lsi_hz: u64,
    /// The analog supply, which is the reference of the converters, V.
    pub vdda: f64,
    /// The unique device identifier.
    pub id: [u32; 3],
}

impl Default for Config {
    fn default() -> Self {
        Config {
            crystal_hz: Some(24_000_000),
            hsi_hz: HSI_HZ,
            lsi_hz: 32_000,
            vdda: 3.3,
            id: [0x0020_0034, 0x5243_500a, 0x2036_3231],
        }
    }
}

/// When something happens, and in which instruction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Now {
    pub at: Cycle,
    pub pc: u32,
}

/// The registers of an STM32G474RE, behind them what they do, and the board `W` at its pins.
#[derive(Clone, Debug)]
pub struct Stm32g474<W> {
    /// The board.
    pub wires: W,
    /// The lint: what becomes of findings, and those that were collected.
    pub lint: Lint,
    pub(crate) config: Config,
    pub(crate) regs: Registers,
    pub(crate) time: TimeBase,
    pub(crate) agenda: Agenda,
    pub(crate) pc: u32,
    /// The time of the last access, fetch or event.
    pub(crate) last: Cycle,
    /// The last change of the wires that was looked at.
    looked: Cycle,
    pub(crate) rcc: Rcc,
    pub(crate) flash: Flash,
    pub(crate) art: Art,
    pub(crate) dma: Dma,
    pub(crate) timers: [Timer; 4],
    pub(crate) tim1: Tim1,
    pub(crate) adcs: [Adc; 5],
    pub(crate) dacs: [Dac; 4],
    pub(crate) uart: Uart,
    pub(crate) iwdg: Iwdg,
    pub(crate) gpio: Gpio,
    /// Outputs of the comparators, a bit each.
    pub(crate) compared: u8,
    pub(crate) halted: bool,
    pub(crate) supply_low: bool,
    /// Levels of the pins that EXTI looks at.
    pub(crate) exti: u16,
    defects: Vec<(Cycle, Defect)>,
    stuck: Vec<(Pin, bool)>,
}

impl<W: Wires> Stm32g474<W> {
    /// A part after power-on, on its board.
    pub fn new(config: Config, wires: W) -> Self {
        Stm32g474 {
            wires,
            lint: Lint::default(),
            regs: Registers::default(),
            time: TimeBase::new(config.hsi_hz),
            config,
            agenda: Agenda::default(),
            pc: 0,
            last: 0,
            looked: 0,
            rcc: Rcc::default(),
            flash: Flash::default(),
            art: Art::default(),
            dma: Dma::default(),
            timers: Default::default(),
            tim1: Tim1::default(),
            adcs: Default::default(),
            dacs: Default::default(),
            uart: Uart::default(),
            iwdg: Iwdg::default(),
            gpio: Gpio::default(),
            compared: 0,
            halted: false,
            supply_low: false,
            exti: 0,
            defects: Vec::new(),
            stuck: Vec::new(),
        }
    }

    /// The memories of the part: 512 KiB of erased flash, 96 KiB of RAM, 32 KiB of core-coupled RAM (RM0440 2.2).
    pub fn memory() -> Memory {
        let mut memory = Memory::default();
        memory.add(Region { base: 0x0800_0000, bytes: vec![0xff; 0x8_0000], writable: false, waits: true });
        memory.add(Region { base: 0x2000_0000, bytes: vec![0; 0x1_8000], writable: true, waits: false });
        memory.add(Region { base: 0x1000_0000, bytes: vec![0; 0x8000], writable: true, waits: false });
        memory
    }

    /// The core clock, Hz.
    pub fn hz(&self) -> u64 {
        self.time.hz()
    }

    /// Seconds since power-on at a cycle that is not before the last change of the clock.
    pub fn seconds(&self, at: Cycle) -> f64 {
        self.time.ps(at) as f64 * 1e-12
    }

    /// The first cycle that is not before a time, if the clock stays as it is.
    pub fn cycle(&self, seconds: f64) -> Cycle {
        self.time.cycle((seconds * 1e12) as u64)
    }

    /// Plans a defect.
    pub fn inject(&mut self, at: Cycle, defect: Defect) {
        self.defects.push((at, defect));
        self.defects.sort_by_key(|(at, _)| *at);
        self.plan_defect();
    }

    /// A debugger halts the processor, or lets it go on: DBGMCU says which peripherals stand meanwhile (RM0440 47.6).
    pub fn debugger(&mut self, at: Cycle, halted: bool, mut ports: Ports) -> Result<(), Fault> {
        self.run(at, &mut ports)?;
        self.halted = halted;
        self.halt_iwdg(at);
        self.update_enable(at, &mut ports);
        Ok(())
    }

    /// The present value of a register, without side effect, for tests and displays.
    pub fn peek(&self, address: u32) -> u32 {
        self.regs[address]
    }

    /// Whether the enable pin of TIM1's channel 3 (PA10) is driven high.
    pub fn enable_is_high(&self) -> bool {
        self.tim1.level(2) == crate::Level::High
    }

    fn plan_defect(&mut self) {
        let next = self.defects.first().map_or(Cycle::MAX, |(at, _)| *at);
        self.agenda.set(Event::Defect, next);
    }

    pub(crate) fn now(&self, at: Cycle) -> Now {
        Now { at, pc: self.pc }
    }

    /// Reports what a program does wrong.
    pub(crate) fn report(&mut self, now: Now, address: u32, bits: u32, value: u32, rule: Rule) -> Result<(), Fault> {
        if self.lint.verdict(rule) == crate::Verdict::Ignore {
            return Ok(());
        }
        let known = self.regs.find(address).map(|(register, _)| register);
        let (peripheral, register) = known.map_or(("memory", "word"), |register| (register.peripheral, register.name));
        let names = if bits == u32::MAX { Vec::new() } else { known.map_or(Vec::new(), |register| register.names(bits)) };
        self.lint.take(Finding { peripheral, register, bits, names, value, rule, manual: rule.manual(), pc: now.pc, at: now.at })
    }

    /// Refuses what the model does not know.
    pub(crate) fn refuse<T>(&self, now: Now, address: u32, what: &str) -> Result<T, Fault> {
        let name = match self.regs.find(address) {
            Some((register, _)) => format!("{}_{}: {what}", register.peripheral, register.name),
            None => what.to_owned(),
        };
        Err(Fault::Stop(Box::new(NotModelled { address, what: name, pc: now.pc, at: now.at })))
    }

    /// Refuses a write that sets one of `bits`, which the model does not know.
    pub(crate) fn refuse_bits(&self, now: Now, address: u32, value: u32, bits: u32) -> Result<(), Fault> {
        if value & bits == 0 {
            return Ok(());
        }
        let names = self.regs.find(address).map_or(Vec::new(), |(register, _)| register.names(value & bits));
        self.refuse(now, address, &names.join("+"))
    }

    /// The register at an address that a program accesses, if the peripheral has its clock.
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

    /// Reads a register as the bus does: by a program, or by DMA.
    pub(crate) fn load(&mut self, now: Now, register: &Register, ports: &mut Ports) -> Result<u32, Fault> {
        let address = register.address;
        match register.base {
            base::GPIOA | base::GPIOB | base::GPIOC | base::GPIOD | base::GPIOE | base::GPIOF | base::GPIOG => {
                Ok(self.read_gpio(now, address))
            }
            base::DMA1 | base::DMA2 => Ok(self.read_dma(address)),
            base::TIM2 | base::TIM3 | base::TIM4 | base::TIM5 => Ok(self.read_timer(now, address)),
            base::TIM1 => Ok(self.read_tim1(address)),
            base::ADC1 | base::ADC2 | base::ADC3 | base::ADC4 | base::ADC5 => Ok(self.read_adc(now, address, ports)),
            base::ADC12_COMMON | base::ADC345_COMMON => Ok(self.read_adc_common(now, address, ports)),
            base::DAC1 | base::DAC2 | base::DAC3 | base::DAC4 => Ok(self.read_dac(address)),
            base::IWDG if address == base::IWDG + map::at::iwdg::SR => Ok(self.iwdg_status(now.at)),
            base::IWDG => Ok(self.regs[address]),
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

    /// Writes a register as the bus does.
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
            base::PWR => self.write_pwr(now, address, value),
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

    /// Lets happen what is due until `to`.
    pub(crate) fn run(&mut self, to: Cycle, ports: &mut Ports) -> Result<(), Fault> {
        self.last = to;
        loop {
            let (wires, byte, next) = (self.wires.due(), self.next_byte(), self.agenda.next());
            if byte <= to && byte <= next {
                self.begin_byte(byte);
                continue;
            }
            if wires <= to && wires <= next && wires != self.looked {
                self.looked = wires;
                self.look_at_inputs(wires, ports)?;
                continue;
            }
            let Some((at, event)) = self.agenda.take(to) else { return Ok(()) };
            match event {
                Event::Timer(index) => self.timer_due(at, index, ports)?,
                Event::AdcHold(index) => self.adc_hold(at, index),
                Event::AdcEnd(index) => self.adc_end(at, index, ports)?,
                Event::AdcReady(index) => self.adc_ready(at, index, ports),
                Event::Sent => self.uart_sent(at, ports)?,
                Event::Received => self.uart_received(at, ports)?,
                Event::Idle => self.uart_idle(at, ports),
                Event::Flash => self.flash_done(at, ports),
                Event::Iwdg => self.iwdg_bites(ports),
                Event::Ready(clock) => self.clock_ready(at, clock, ports),
                Event::Defect => self.fail(at, ports)?,
            }
        }
    }

    /// The wires have changed by themselves: pins, then comparators.
    fn look_at_inputs(&mut self, at: Cycle, ports: &mut Ports) -> Result<(), Fault> {
        self.update_exti(at, ports);
        self.compare(at, ports);
        self.update_breaks(at, ports);
        Ok(())
    }

    /// A level of an input pin that a defect holds.
    pub(crate) fn stuck_pins(&self, port: u8) -> impl Iterator<Item = (u8, bool)> {
        self.stuck.iter().filter(move |(pin, _)| pin.port == port).map(|(pin, high)| (pin.number, *high))
    }

    /// A defect sets in.
    fn fail(&mut self, at: Cycle, ports: &mut Ports) -> Result<(), Fault> {
        while self.defects.first().is_some_and(|(due, _)| *due <= at) {
            let (_, defect) = self.defects.remove(0);
            match defect {
                Defect::AdcStuck { adc, code } => self.adcs[usize::from(adc - 1)].stuck = Some(code),
                Defect::TimerHalts { timer } => self.halt_timer(at, usize::from(timer - 2)),
                Defect::DmaHalts { dma, channel } => self.dma.halt(usize::from((dma - 1) * 8 + channel - 1)),
                Defect::HseStops => self.hse_stops(at, ports),
                Defect::PllUnlocks => self.pll_unlocks(at)?,
                Defect::BrownOut { ram } => {
                    self.flash_loses_power(ports);
                    if ram == Ram::Lost {
                        factory::scramble(ports.memory);
                    }
                    self.rcc.power_lost = true;
                    ports.interrupts.pull_reset();
                }
                Defect::FlashBits { address, bits } => self.flip_flash(address, bits, ports),
                Defect::RamBit { address, bit } => {
                    if let Some([byte]) = ports.memory.get_mut(address, 1) {
                        *byte ^= 1 << (bit & 7);
                    }
                }
                Defect::UartNoise { bytes } => self.uart.noise = bytes,
                Defect::PinStuck { pin, high } => {
                    self.stuck.push((pin, high));
                    self.look_at_inputs(at, ports)?;
                }
                Defect::SupplyLow(low) => self.supply(at, low, ports),
            }
        }
        self.plan_defect();
        Ok(())
    }

    /// Requests of a peripheral that stand when a channel begins to serve them.
    pub(crate) fn standing_requests(&mut self, now: Now, request: u8, ports: &mut Ports) -> Result<(), Fault> {
        match request {
            RX_REQUEST | TX_REQUEST => self.serve_uart(now, request, ports),
            5 | 36..=39 => self.serve_adc(now, request, ports),
            _ => self.serve_dac(now, request, ports),
        }
    }

    /// A reset by the part itself, for a reason that RCC_CSR shows.
    pub(crate) fn pull_reset(&mut self, flag: u32, ports: &mut Ports) {
        self.rcc.cause |= flag;
        ports.interrupts.pull_reset();
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
        if reserved != 0 && (register.access != map::Access::Write || value & !mask != 0) {
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

    fn damaged(&mut self, address: u32, mut ports: Ports) -> Result<(), Fault> {
        self.ecc(address, &mut ports)
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
    }
}
