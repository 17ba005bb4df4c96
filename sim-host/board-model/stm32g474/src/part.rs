//! The microcontroller: its state and its event loop.

use cortex_m4::{Cycle, Fault, Memory, Ports, Region};

use crate::adc::Adc;
use crate::art::Art;
use crate::dac::Dac;
use crate::defect::Defect;
use crate::dma::Dma;
use crate::finding::{Finding, Lint, NotModelled, Rule};
use crate::flash::Flash;
use crate::gpio::Gpio;
use crate::iwdg::Iwdg;
use crate::map::Registers;
use crate::rcc::{HSI_HZ, Rcc};
use crate::tim1::Tim1;
use crate::time::{Agenda, Event, TimeBase};
use crate::timer::Timer;
use crate::uart::{RX_REQUEST, TX_REQUEST, Uart};
use crate::wires::{Pin, Wires};

/// Properties of an individual microcontroller and its board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Crystal at PF0 and PF1, Hz; with `None` the oscillator never becomes ready.
    pub crystal_hz: Option<u64>,
    /// HSI16, Hz.
    pub hsi_hz: u64,
    /// LSI, Hz: 32 kHz, within 5 % (DS12288).
    pub lsi_hz: u64,
    /// Analog supply, which is the reference of the converters, V.
    pub vdda: f64,
    /// Unique device identifier.
    pub id: [u32; 3],
    /// Silicon revision, DBGMCU_IDCODE.REV_ID: 0x2003 is revision X.
    pub revision: u16,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            crystal_hz: Some(24_000_000),
            hsi_hz: HSI_HZ,
            lsi_hz: 32_000,
            vdda: 3.3,
            id: [0x0020_0034, 0x5243_500a, 0x2036_3231],
            revision: 0x2003,
        }
    }
}

/// Cycle and address of the current instruction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Now {
    pub at: Cycle,
    pub pc: u32,
}

/// STM32G474RE: its registers and their behaviour, with the board `W` at its pins.
#[derive(Clone, Debug)]
pub struct Stm32g474<W> {
    /// Board at the pins.
    pub wires: W,
    /// Treatment of findings, and the collected ones.
    pub lint: Lint,
    /// Properties of this part.
    pub config: Config,
    pub(crate) regs: Registers,
    pub(crate) time: TimeBase,
    pub(crate) agenda: Agenda,
    pub(crate) pc: u32,
    /// Cycle of the last access, fetch or event.
    pub(crate) last: Cycle,
    /// Cycle of the last handled change of the wires.
    pub(crate) looked: Cycle,
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
    /// Outputs of the comparators, one bit each.
    pub(crate) compared: u8,
    pub(crate) stuck_comparators: [Option<bool>; 7],
    pub(crate) halted: bool,
    pub(crate) supply_low: bool,
    /// Levels of the pins of EXTI.
    pub(crate) exti: u16,
    pub(crate) defects: Vec<(Cycle, Defect)>,
    pub(crate) stuck: Vec<(Pin, bool)>,
}

impl<W: Wires> Stm32g474<W> {
    /// Creates a microcontroller after power-on, on its board.
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
            stuck_comparators: [None; 7],
            halted: false,
            supply_low: false,
            exti: 0,
            defects: Vec::new(),
            stuck: Vec::new(),
        }
    }

    /// Returns the memories: 512 KiB of erased flash, 96 KiB of RAM, 32 KiB of core-coupled RAM
    /// (RM0440 2.2).
    pub fn memory() -> Memory {
        let mut memory = Memory::default();
        memory.add(Region { base: 0x0800_0000, bytes: vec![0xff; 0x8_0000], writable: false, waits: true });
        memory.add(Region { base: 0x2000_0000, bytes: vec![0; 0x1_8000], writable: true, waits: false });
        memory.add(Region { base: 0x1000_0000, bytes: vec![0; 0x8000], writable: true, waits: false });
        memory
    }

    /// Returns the core clock, Hz.
    pub fn hz(&self) -> u64 {
        self.time.hz()
    }

    /// Returns the seconds since power-on at a cycle, which must not precede the last change of the
    /// clock.
    pub fn seconds(&self, at: Cycle) -> f64 {
        self.time.ps(at) as f64 * 1e-12
    }

    /// Returns the first cycle at or after a time, if the clock does not change.
    pub fn cycle(&self, seconds: f64) -> Cycle {
        self.time.cycle((seconds * 1e12) as u64)
    }

    /// Halts or resumes the processor; a halt stops the peripherals that DBGMCU selects (RM0440
    /// 47.6).
    pub fn debugger(&mut self, at: Cycle, halted: bool, mut ports: Ports) -> Result<(), Fault> {
        self.run(at, &mut ports)?;
        self.halted = halted;
        self.halt_iwdg(at);
        self.retime_counter(at);
        self.update_breaks(at, &mut ports);
        Ok(())
    }

    /// Returns the current value of a register, without side effects, for tests and displays.
    pub fn peek(&self, address: u32) -> u32 {
        self.regs[address]
    }

    /// Returns `true` if the amplifier enable, channel 3 of TIM1 (PA10), is driven high.
    pub fn enable_is_high(&self) -> bool {
        self.tim1.level(2) == crate::Level::High
    }

    pub(crate) fn now(&self, at: Cycle) -> Now {
        Now { at, pc: self.pc }
    }

    /// Reports a violation of a rule.
    pub(crate) fn report(&mut self, now: Now, address: u32, bits: u32, value: u32, rule: Rule) -> Result<(), Fault> {
        if self.lint.verdict(rule) == crate::Verdict::Ignore {
            return Ok(());
        }
        let known = self.regs.find(address).map(|(register, _)| register);
        let (peripheral, register) = known.map_or(("memory", "word"), |register| (register.peripheral, register.name));
        let names = if bits == u32::MAX { Vec::new() } else { known.map_or(Vec::new(), |register| register.names(bits)) };
        self.lint.take(Finding { peripheral, register, bits, names, value, rule, manual: rule.manual(), pc: now.pc, at: now.at })
    }

    /// Returns the error for a behaviour that the model lacks.
    pub(crate) fn refuse<T>(&self, now: Now, address: u32, what: &str) -> Result<T, Fault> {
        let name = match self.regs.find(address) {
            Some((register, _)) => format!("{}_{}: {what}", register.peripheral, register.name),
            None => what.to_owned(),
        };
        Err(Fault::Stop(Box::new(NotModelled { address, what: name, pc: now.pc, at: now.at })))
    }

    /// Returns an error if a write sets one of `bits`, which are not modelled.
    pub(crate) fn refuse_bits(&self, now: Now, address: u32, value: u32, bits: u32) -> Result<(), Fault> {
        if value & bits == 0 {
            return Ok(());
        }
        let names = self.regs.find(address).map_or(Vec::new(), |(register, _)| register.names(value & bits));
        self.refuse(now, address, &names.join("+"))
    }

    /// Executes all events up to `to`.
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
                self.update_inputs(wires, ports)?;
                continue;
            }
            let Some((at, event)) = self.agenda.take(to) else { return Ok(()) };
            match event {
                Event::Timer(index) => self.timer_due(at, index, ports)?,
                Event::Tim1 => self.tim1_due(at, ports),
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

    /// Updates pins, and then comparators, after the wires have changed.
    pub(crate) fn update_inputs(&mut self, at: Cycle, ports: &mut Ports) -> Result<(), Fault> {
        self.update_exti(at, ports);
        self.compare(at, ports);
        self.update_breaks(at, ports);
        Ok(())
    }

    /// Serves the pending requests of a peripheral when its DMA channel is enabled.
    pub(crate) fn serve_requests(&mut self, now: Now, request: u8, ports: &mut Ports) -> Result<(), Fault> {
        match request {
            RX_REQUEST | TX_REQUEST => self.serve_uart(now, request, ports),
            5 | 36..=39 => self.serve_adc(now, request, ports),
            _ => self.serve_dac(now, request, ports),
        }
    }

    /// Resets the chip; RCC_CSR shows the flag of the cause.
    pub(crate) fn pull_reset(&mut self, flag: u32, ports: &mut Ports) {
        self.rcc.cause |= flag;
        ports.interrupts.pull_reset();
    }
}
