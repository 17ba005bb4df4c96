//! Microcontroller without a processor: the test writes registers as a program would.

use cortex_m4::{Access, Chip, Cycle, Fault, Interrupts, Memory, Ports, Width};
use sonoglide_stm32g474::map::{at, base::*};
use sonoglide_stm32g474::{Bare, Config, Finding, Rule, Stm32g474, Verdict, Wires};

/// Microcontroller with its memory, its interrupt lines, and the time.
pub struct Rig<W> {
    pub part: Stm32g474<W>,
    pub memory: Memory,
    pub interrupts: Interrupts,
    pub now: Cycle,
}

/// Address of an instruction in the first bank of the flash.
pub const PC: u32 = 0x0800_0400;
/// Address of the ring of the ADCs.
pub const ADC_RING: u32 = 0x2000_0000;
/// Address of the ring of the DAC.
pub const DAC_RING: u32 = 0x2000_0400;
/// Address of the ring of the UART.
pub const UART_RING: u32 = 0x2000_0800;

impl Rig<Bare> {
    /// Creates a microcontroller on a bare board, with all findings collected.
    pub fn bare() -> Self {
        Rig::on(Bare)
    }
}

impl<W: Wires> Rig<W> {
    pub fn on(wires: W) -> Self {
        let mut part = Stm32g474::new(Config::default(), wires);
        part.lint.set_all(Verdict::Collect);
        part.lint.set(Rule::IwdgMissing, Verdict::Ignore);
        Rig { part, memory: Stm32g474::<W>::memory(), interrupts: Interrupts::default(), now: 0 }
    }

    pub fn access(&mut self, address: u32, width: Width) -> Access {
        self.now += 2;
        Access { address, width, at: self.now, pc: PC }
    }

    pub fn try_write(&mut self, address: u32, value: u32, width: Width) -> Result<(), Fault> {
        let access = self.access(address, width);
        self.part.write(access, value, Ports { memory: &mut self.memory, interrupts: &mut self.interrupts })
    }

    pub fn write(&mut self, address: u32, value: u32) {
        self.try_write(address, value, Width::Word).unwrap_or_else(|fault| panic!("{address:#x} = {value:#x}: {fault:?}"));
    }

    pub fn try_read(&mut self, address: u32) -> Result<u32, Fault> {
        let access = self.access(address, Width::Word);
        self.part.read(access, Ports { memory: &mut self.memory, interrupts: &mut self.interrupts })
    }

    pub fn read(&mut self, address: u32) -> u32 {
        self.try_read(address).unwrap_or_else(|fault| panic!("{address:#x}: {fault:?}"))
    }

    pub fn set(&mut self, address: u32, bits: u32) {
        let old = self.read(address);
        self.write(address, old | bits);
    }

    pub fn clear(&mut self, address: u32, bits: u32) {
        let old = self.read(address);
        self.write(address, old & !bits);
    }

    /// Polls until the bits have the wanted value.
    pub fn poll(&mut self, address: u32, bits: u32, wanted: u32) {
        for _ in 0..100_000 {
            if self.read(address) & bits == wanted {
                return;
            }
            self.wait(8);
        }
        panic!("{address:#x} never has {wanted:#x} of {bits:#x}");
    }

    /// Advances time as the processor does, by the cycles of the next events.
    pub fn try_wait(&mut self, cycles: Cycle) -> Result<(), Fault> {
        let end = self.now + cycles;
        while self.part.due() <= end {
            self.now = self.part.due().max(self.now);
            self.part.advance(self.now, Ports { memory: &mut self.memory, interrupts: &mut self.interrupts })?;
        }
        self.now = end;
        Ok(())
    }

    pub fn wait(&mut self, cycles: Cycle) {
        self.try_wait(cycles).unwrap_or_else(|fault| panic!("{fault:?}"));
    }

    pub fn us(&mut self, us: u64) {
        self.wait((us * self.part.hz()).div_ceil(1_000_000));
    }

    pub fn reset(&mut self) {
        self.part.reset(self.now, Ports { memory: &mut self.memory, interrupts: &mut self.interrupts });
    }

    pub fn line(&self, line: u16) -> bool {
        self.interrupts.levels() >> line & 1 != 0
    }

    /// Returns the violated rules, each once.
    pub fn rules(&self) -> Vec<Rule> {
        let mut rules: Vec<_> = self.part.lint.findings.iter().map(|finding| finding.rule).collect();
        rules.sort();
        rules.dedup();
        rules
    }

    pub fn findings(&self) -> &[Finding] {
        &self.part.lint.findings
    }
}

/// Settings of the set-up that a test can change or omit.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Setup {
    pub latency: u32,
    pub boost: bool,
    pub half_us: Option<u64>,
    pub m: u32,
    pub sampling: u32,
    pub hfsel: u32,
    pub brr: u32,
    pub rx_dma: bool,
    pub dac_dma: bool,
    pub adc_dma: bool,
    /// `true` to switch the FIFO of ADC_DR off.
    pub overwrites: bool,
}

impl Default for Setup {
    fn default() -> Self {
        Setup {
            latency: 4,
            boost: true,
            half_us: Some(2),
            m: 3,
            sampling: 0,
            hfsel: 2,
            brr: 47222,
            rx_dma: true,
            dac_dma: true,
            adc_dma: true,
            overwrites: true,
        }
    }
}

impl<W: Wires> Rig<W> {
    /// Sets the clock to 170 MHz from HSI16, in the order of the manual.
    pub fn clocks(&mut self, setup: Setup) {
        self.set(RCC + at::rcc::APB1ENR1, 1 << 28);
        self.wait(4);
        if setup.boost {
            self.write(PWR + at::pwr::CR5, 0);
        }
        self.write(FLASH + at::flash::ACR, 0x0004_0700 | setup.latency);
        self.write(RCC + at::rcc::PLLCFGR, 2 | setup.m << 4 | 85 << 8 | 1 << 24);
        self.set(RCC + at::rcc::CR, 1 << 24);
        self.poll(RCC + at::rcc::CR, 1 << 25, 1 << 25);
        if let Some(us) = setup.half_us {
            self.write(RCC + at::rcc::CFGR, 3 | 8 << 4);
            self.poll(RCC + at::rcc::CFGR, 0xc, 0xc);
            self.us(us);
        }
        self.write(RCC + at::rcc::CFGR, 3);
        self.write(RCC + at::rcc::AHB1ENR, 0x107);
        self.write(RCC + at::rcc::AHB2ENR, 0x000f_6007);
        self.write(RCC + at::rcc::APB1ENR1, 1 << 28 | 0xf | 0x400);
        self.write(RCC + at::rcc::APB1ENR2, 1);
        self.write(RCC + at::rcc::APB2ENR, 0x801);
        self.wait(8);
    }

    /// Starts a channel of DMA1 (counted from 0) on a ring.
    pub fn dma(&mut self, channel: u32, request: u32, register: u32, ring: u32, count: u32, control: u32) {
        let first = DMA1 + at::dma::CH_0_CR + channel * 20;
        self.write(first, 0);
        self.write(DMAMUX1 + 4 * channel, request);
        self.write(first + 8, register);
        self.write(first + 12, ring);
        self.write(first + 4, count);
        self.write(first, control);
    }

    /// Starts the regulator of an ADC, calibrates and enables it.
    pub fn wake_adc(&mut self, adc: u32) {
        self.write(adc + at::adc::CR, 0);
        self.write(adc + at::adc::CR, 1 << 28);
        self.us(21);
        self.set(adc + at::adc::CR, 1 << 31);
        self.poll(adc + at::adc::CR, 1 << 31, 0);
        self.wait(40);
        self.set(adc + at::adc::CR, 1);
        self.poll(adc + at::adc::ISR, 1, 1);
    }

    /// Starts the block stream: TIM3 at 1 MHz to DAC1, TIM4 at 2 MHz to ADC1 and ADC2, both by DMA.
    pub fn streams(&mut self, setup: Setup) {
        self.write(ADC12_COMMON + at::adccommon::CCR, 3 << 16 | 6 | 2 << 14 | 1 << 13);
        for (adc, channel) in [(ADC1, 1_u32), (ADC2, 2)] {
            self.wake_adc(adc);
            self.write(adc + at::adc::SQR1, channel << 6);
            self.write(adc + at::adc::SMPR, setup.sampling << (3 * channel));
            self.write(adc + at::adc::CFGR2, 1 | 1 << 9);
            // Without the FIFO of ADC_DR (ES0430 2.7.6).
            self.write(adc + at::adc::CFGR, u32::from(setup.overwrites) << 12);
        }
        self.set(ADC1 + at::adc::CFGR, 12 << 5 | 1 << 10);
        if setup.adc_dma {
            self.dma(0, 5, ADC12_COMMON + at::adccommon::CDR, ADC_RING, 64, 0x3aa1 | 0xe);
        }
        self.set(ADC1 + at::adc::CR, 1 << 2);
        self.write(DAC1 + at::dac::MCR, setup.hfsel << 14);
        self.write(DAC1 + at::dac::DHR12RD, 2048 | 2048 << 16);
        if setup.dac_dma {
            self.dma(1, 6, DAC1 + at::dac::DHR12RD, DAC_RING, 64, 0x2ab1);
        }
        self.write(DAC1 + at::dac::CR, 0x0001_0001);
        self.us(10);
        self.write(DAC1 + at::dac::CR, 0x0023_0023 | 0x1000);
        self.write(TIM4 + at::timgp16::ARR, 84);
        self.write(TIM4 + at::timgp16::CCR_0, 4);
        self.write(TIM4 + at::timgp16::CCMR1, 7 << 4);
        self.write(TIM4 + at::timgp16::CR2, 4 << 4);
        self.write(TIM4 + at::timgp16::SMCR, 2 << 4 | 6);
        self.write(TIM3 + at::timgp16::CR1, 4);
        self.write(TIM3 + at::timgp16::ARR, 169);
        self.write(TIM3 + at::timgp16::CR2, 2 << 4);
        self.write(TIM3 + at::timgp16::CR1, 5);
    }

    /// Starts LPUART1 at 921 600 baud, received by DMA.
    pub fn uart(&mut self, setup: Setup) {
        self.write(LPUART1 + at::lpuart::BRR, setup.brr);
        self.write(LPUART1 + at::lpuart::CR3, u32::from(setup.rx_dma) << 6);
        if setup.rx_dma {
            self.dma(2, 34, LPUART1 + at::lpuart::RDR, UART_RING, 512, 0x10a1);
        }
        self.write(LPUART1 + at::lpuart::CR1, 1 << 29 | 0xc);
        self.write(LPUART1 + at::lpuart::CR1, 1 << 29 | 0xd);
    }
}
