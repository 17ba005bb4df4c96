//! LPUART1. RM0440 38.

use std::collections::VecDeque;

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::usart::regs::{Cr1, Cr3};

use crate::finding::Rule;
use crate::map::at::lpuart as reg;
use crate::map::base::{LPUART1, RCC};
use crate::map::{at, line};
use crate::part::{Now, Stm32g474};
use crate::time::{Event, Ps};
use crate::wires::{Received, Wires};

/// DMA requests (13.3.2).
pub(crate) const RX_REQUEST: u8 = 34;
pub(crate) const TX_REQUEST: u8 = 35;
/// LPUART_ISR (38.7.7).
const FE: u32 = 1 << 1;
const NE: u32 = 1 << 2;
const ORE: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;
/// Capacity of each buffer, bytes (38.4.3).
const BUFFER_BYTES: usize = 8;
/// LPUART_PRESC (38.7.11).
const PRESCALERS: [u64; 12] = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];

/// State of LPUART1.
#[derive(Clone, Debug)]
pub(crate) struct Uart {
    /// Bytes that wait to be sent.
    sending: VecDeque<u8>,
    /// Byte that is being sent.
    shifting: Option<u8>,
    /// Received bytes.
    received: VecDeque<u8>,
    /// Start of the byte that is being received.
    receiving: Option<Cycle>,
    /// Cycle from which the line is free.
    free: Cycle,
    /// Sticky flags.
    flags: u32,
    /// Number of next bytes with noise.
    pub noise: u32,
}

impl Default for Uart {
    fn default() -> Self {
        Uart {
            sending: VecDeque::new(),
            shifting: None,
            received: VecDeque::new(),
            receiving: None,
            free: 0,
            flags: TC,
            noise: 0,
        }
    }
}

impl Uart {
    /// Resets the state; a defect stays.
    pub fn reset(&mut self) {
        *self = Uart { noise: self.noise, ..Uart::default() };
    }
}

impl<W: Wires> Stm32g474<W> {
    fn uart_cr1(&self) -> Cr1 {
        Cr1(self.regs[LPUART1 + reg::CR1])
    }

    fn room(&self) -> usize {
        if self.uart_cr1().fifoen() { BUFFER_BYTES } else { 1 }
    }

    fn uart_clock(&self) -> u64 {
        match self.regs[RCC + at::rcc::CCIPR] >> 10 & 3 {
            0 => self.time.hz() / self.apb(1),
            1 => self.system_hz(),
            2 => self.config.hsi_hz,
            _ => 32_768,
        }
    }

    /// Returns the duration of a frame: start, eight bits, stop, and a second stop bit by CR2.STOP.
    /// The baud rate is 256 clock / BRR (38.4.7).
    fn frame(&self) -> Ps {
        let prescaler = PRESCALERS[(self.regs[LPUART1 + reg::PRESC] & 0xf).min(11) as usize];
        let bits = if self.regs[LPUART1 + reg::CR2] >> 12 & 3 == 2 { 11 } else { 10 };
        let brr = u128::from(self.regs[LPUART1 + reg::BRR].max(1));
        (u128::from(bits * prescaler) * brr * 1_000_000_000_000 / (256 * u128::from(self.uart_clock()))) as Ps
    }

    fn after_frame(&self, at: Cycle) -> Cycle {
        self.time.cycle(self.time.ps(at) + self.frame())
    }

    fn uart_isr(&self) -> u32 {
        let (cr1, uart) = (self.uart_cr1(), &self.uart);
        let mut isr = uart.flags;
        let set = |isr: &mut u32, bit: u32, on: bool| *isr |= if on { bit } else { 0 };
        set(&mut isr, RXNE, !uart.received.is_empty());
        set(&mut isr, TXE, uart.sending.len() < self.room());
        set(&mut isr, 1 << 16, uart.receiving.is_some());
        set(&mut isr, 1 << 21, cr1.ue() && cr1.te());
        set(&mut isr, 1 << 22, cr1.ue() && cr1.re());
        set(&mut isr, 1 << 23, cr1.fifoen() && uart.sending.is_empty());
        set(&mut isr, 1 << 24, cr1.fifoen() && uart.received.len() == BUFFER_BYTES);
        isr
    }

    pub(crate) fn read_uart(&mut self, _now: Now, address: u32, ports: &mut Ports) -> u32 {
        match address - LPUART1 {
            reg::ISR => self.uart_isr(),
            reg::RDR => {
                let byte = self.uart.received.pop_front().unwrap_or(0);
                self.uart_line(ports);
                u32::from(byte)
            }
            reg::TDR | reg::ICR | reg::RQR => 0,
            _ => self.regs[address],
        }
    }

    pub(crate) fn write_uart(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let old = self.regs[address];
        let on = self.uart_cr1().ue();
        // Fields that may change only while the UART is off (38.7.1 to 38.7.5, 38.7.11).
        let frozen = match address - LPUART1 {
            reg::CR1 => 0x33ff_d600,
            reg::CR2 | reg::BRR | reg::PRESC => u32::MAX,
            reg::CR3 => 0x0fff_3f08 & !(1 << 10),
            _ => 0,
        };
        if on && (value ^ old) & frozen != 0 && Cr1(value).ue() | (address != LPUART1 + reg::CR1) {
            self.report(now, address, (value ^ old) & frozen, value, Rule::UartEnabled)?;
        }
        match address - LPUART1 {
            // Not modelled: nine bits, parity, addresses, and interrupts of the buffers'
            // thresholds.
            reg::CR1 => self.refuse_bits(now, address, value, !0x2000_00fd)?,
            reg::CR2 => self.refuse_bits(now, address, value, !(3 << 12))?,
            reg::CR3 => self.refuse_bits(now, address, value, !(1 | 3 << 6 | 3 << 12))?,
            reg::RQR => {
                if value & 1 << 3 != 0 {
                    self.uart.received.clear();
                }
                if value & 1 << 4 != 0 {
                    self.uart.sending.clear();
                }
                self.refuse_bits(now, address, value, 7)?;
            }
            reg::ICR => self.uart.flags &= !(value & (FE | NE | ORE | IDLE | TC)),
            reg::TDR => self.send(now, value as u8)?,
            _ => {}
        }
        if self.regs.find(address).is_some_and(|(register, _)| register.access == crate::map::Access::ReadWrite) {
            self.regs[address] = value;
        }
        if address == LPUART1 + reg::CR1 && self.uart_cr1().ue() {
            // 3 to 4096 clocks per bit (38.4.7).
            let brr = self.regs[LPUART1 + reg::BRR];
            if !(0x300..=0xf_ffff).contains(&brr) {
                self.report(now, LPUART1 + reg::BRR, u32::MAX, brr, Rule::UartDivider)?;
            }
        }
        self.fill_from_dma(now, ports)?;
        self.serve_uart(now, RX_REQUEST, ports)?;
        self.uart_line(ports);
        Ok(())
    }

    /// Adds a byte to the transmitter.
    fn send(&mut self, now: Now, byte: u8) -> Result<(), Fault> {
        let cr1 = self.uart_cr1();
        if !cr1.ue() || !cr1.te() || self.uart.sending.len() >= self.room() {
            return self.report(now, LPUART1 + reg::TDR, u32::MAX, byte.into(), Rule::UartLost);
        }
        self.uart.flags &= !TC;
        self.uart.sending.push_back(byte);
        self.shift(now.at);
        Ok(())
    }

    /// Starts to send the next byte.
    fn shift(&mut self, at: Cycle) {
        if self.uart.shifting.is_none() {
            self.uart.shifting = self.uart.sending.pop_front();
            if self.uart.shifting.is_some() {
                let end = self.after_frame(at);
                self.agenda.set(Event::Sent, end);
            }
        }
    }

    pub(crate) fn uart_sent(&mut self, at: Cycle, ports: &mut Ports) -> Result<(), Fault> {
        if let Some(byte) = self.uart.shifting.take() {
            self.wires.sent(at, byte);
        }
        self.shift(at);
        self.fill_from_dma(self.now(at), ports)?;
        if self.uart.shifting.is_none() {
            self.uart.flags |= TC;
        }
        self.uart_line(ports);
        Ok(())
    }

    fn fill_from_dma(&mut self, now: Now, ports: &mut Ports) -> Result<(), Fault> {
        let cr1 = self.uart_cr1();
        let asks = Cr3(self.regs[LPUART1 + reg::CR3]).dmat() && cr1.ue() && cr1.te();
        while asks && self.uart.sending.len() < self.room() {
            let before = self.uart.sending.len() + usize::from(self.uart.shifting.is_some());
            if !self.request_byte(now, ports)? || self.uart.sending.len() + usize::from(self.uart.shifting.is_some()) == before {
                break;
            }
        }
        Ok(())
    }

    /// Requests one byte by DMA, without a nested request by its write to TDR.
    fn request_byte(&mut self, now: Now, ports: &mut Ports) -> Result<bool, Fault> {
        let cr3 = self.regs[LPUART1 + reg::CR3];
        self.regs[LPUART1 + reg::CR3] = cr3 & !(1 << 7);
        let served = self.request(now, TX_REQUEST, ports);
        self.regs[LPUART1 + reg::CR3] = cr3;
        served
    }

    /// Returns the cycle at which the next byte of the wires begins, if the receiver is on and
    /// free.
    pub(crate) fn next_byte(&self) -> Cycle {
        let cr1 = self.uart_cr1();
        if !cr1.ue() || !cr1.re() || self.uart.receiving.is_some() {
            return Cycle::MAX;
        }
        match self.wires.byte_due() {
            Cycle::MAX => Cycle::MAX,
            due => due.max(self.uart.free),
        }
    }

    pub(crate) fn begin_byte(&mut self, at: Cycle) {
        self.uart.receiving = Some(at);
        let end = self.after_frame(at);
        self.uart.free = end;
        self.agenda.clear(Event::Idle);
        self.agenda.set(Event::Received, end);
    }

    pub(crate) fn uart_received(&mut self, at: Cycle, ports: &mut Ports) -> Result<(), Fault> {
        let Some(start) = self.uart.receiving.take() else { return Ok(()) };
        let Some(Received { mut byte, framing, mut noise }) = self.wires.receive(start) else { return Ok(()) };
        if self.uart.noise > 0 {
            self.uart.noise -= 1;
            byte ^= 1 << (at % 8);
            noise = true;
        }
        let cr3 = Cr3(self.regs[LPUART1 + reg::CR3]);
        self.uart.flags |= if framing { FE } else { 0 } | if noise && !cr3.onebit() { NE } else { 0 };
        let now = self.now(at);
        if self.uart.received.len() >= self.room() {
            // With OVRDIS the new byte replaces the last one, without a flag (38.7.4).
            if cr3.ovrdis() {
                self.uart.received.pop_back();
                self.uart.received.push_back(byte);
            } else {
                self.uart.flags |= ORE;
            }
            self.report(now, LPUART1 + reg::RDR, u32::MAX, byte.into(), Rule::UartLost)?;
        } else {
            self.uart.received.push_back(byte);
        }
        self.serve_uart(now, RX_REQUEST, ports)?;
        let idle = self.after_frame(at);
        self.agenda.set(Event::Idle, idle);
        self.uart_line(ports);
        Ok(())
    }

    /// Sets the idle flag after a frame without a byte (38.4.6).
    pub(crate) fn uart_idle(&mut self, _at: Cycle, ports: &mut Ports) {
        self.uart.flags |= IDLE;
        self.uart_line(ports);
    }

    /// Lets DMA take received bytes, or bring bytes to send.
    pub(crate) fn serve_uart(&mut self, now: Now, request: u8, ports: &mut Ports) -> Result<(), Fault> {
        if request == TX_REQUEST {
            return self.fill_from_dma(now, ports);
        }
        while Cr3(self.regs[LPUART1 + reg::CR3]).dmar() && !self.uart.received.is_empty() {
            if !self.request(now, RX_REQUEST, ports)? {
                break;
            }
        }
        Ok(())
    }

    fn uart_line(&self, ports: &mut Ports) {
        let (isr, cr1, cr3) = (self.uart_isr(), self.uart_cr1(), Cr3(self.regs[LPUART1 + reg::CR3]));
        // IDLEIE, RXNEIE, TCIE, TXEIE have the bit positions of their flags; RXNEIE includes the
        // overrun.
        let high = isr & cr1.0 & (IDLE | RXNE | TC | TXE) != 0
            || (cr1.rxneie() && isr & ORE != 0)
            || (cr3.eie() && isr & (FE | NE | ORE) != 0);
        ports.interrupts.set(line::LPUART1, high);
    }
}
