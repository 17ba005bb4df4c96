//! Both DMA controllers and their request multiplexer. RM0440 12 and 13.
//!
//! A request is served at once: arbitration and the few cycles of a transfer are not modelled.

use cortex_m4::{Fault, Ports};
use stm32_metapac::bdma::regs::Cr;
use stm32_metapac::bdma::vals::Dir;

use crate::contention;
use crate::finding::Rule;
use crate::map::base::{DMA1, DMA2, DMAMUX1};
use crate::map::{at, line};
use crate::part::{Now, Stm32g474};
use crate::wires::Wires;

/// Bytes from one channel's registers to the next.
const STRIDE: u32 = at::dma::CH_1_CR - at::dma::CH_0_CR;
/// Number of requests of the multiplexer (13.3.2).
const REQUESTS: usize = 128;

/// Channel with the settings that it has read when it was enabled.
#[derive(Clone, Copy, Debug, Default)]
struct Channel {
    control: u32,
    /// Number of remaining transfers.
    left: u32,
    /// Number of transfers that it restarts with.
    count: u32,
    peripheral: u32,
    memory: u32,
    dead: bool,
    /// Number of requests that it still misses.
    misses: u32,
    /// `true` if its next transfer fails.
    fails: bool,
}

/// Both controllers.
#[derive(Clone, Debug)]
pub(crate) struct Dma {
    channels: [Channel; 16],
    /// Channel of each request, plus one.
    of_request: [u8; REQUESTS],
    /// Cycles of delay of the processor by transfers, not read by it yet.
    pub(crate) held_up: u32,
}

impl Default for Dma {
    fn default() -> Self {
        Dma { channels: Default::default(), of_request: [0; REQUESTS], held_up: 0 }
    }
}

impl Dma {
    /// Returns the state after a reset, which keeps dead channels.
    pub fn after_reset(&self) -> Self {
        let mut dma = Dma::default();
        for (new, old) in dma.channels.iter_mut().zip(&self.channels) {
            new.dead = old.dead;
        }
        dma
    }

    /// Makes a channel stop serving requests.
    pub fn halt(&mut self, channel: usize) {
        self.channels[channel & 15].dead = true;
    }

    /// Makes a channel miss the next requests.
    pub fn miss(&mut self, channel: usize, requests: u32) {
        self.channels[channel & 15].misses = requests;
    }

    /// Makes the next transfer of a channel fail.
    pub fn fail_next(&mut self, channel: usize) {
        self.channels[channel & 15].fails = true;
    }
}

/// Returns the first register of the controller of a channel.
fn controller(channel: usize) -> u32 {
    if channel < 8 { DMA1 } else { DMA2 }
}

/// Returns the first register of a channel.
fn registers(channel: usize) -> u32 {
    controller(channel) + at::dma::CH_0_CR + (channel as u32 & 7) * STRIDE
}

const LINES: [u16; 16] = [
    line::DMA1_CHANNEL1,
    line::DMA1_CHANNEL2,
    line::DMA1_CHANNEL3,
    line::DMA1_CHANNEL4,
    line::DMA1_CHANNEL5,
    line::DMA1_CHANNEL6,
    line::DMA1_CHANNEL7,
    line::DMA1_CHANNEL8,
    line::DMA2_CHANNEL1,
    line::DMA2_CHANNEL2,
    line::DMA2_CHANNEL3,
    line::DMA2_CHANNEL4,
    line::DMA2_CHANNEL5,
    line::DMA2_CHANNEL6,
    line::DMA2_CHANNEL7,
    line::DMA2_CHANNEL8,
];

/// Flag of DMA_ISR: transfer complete. Bit 0 is set with any of the flags.
const TC: u32 = 2;
/// Flag of DMA_ISR: half of the transfers complete.
const HT: u32 = 4;
/// Flag of DMA_ISR: transfer error.
const TE: u32 = 8;

impl<W: Wires> Stm32g474<W> {
    /// Returns the channel of a register, and its offset in the channel.
    fn channel_of(address: u32) -> Option<(usize, u32)> {
        let (first, base) = if address >= DMA2 { (8, DMA2) } else { (0, DMA1) };
        let offset = (address - base).checked_sub(at::dma::CH_0_CR)?;
        Some((first + (offset / STRIDE) as usize, offset % STRIDE))
    }

    pub(crate) fn read_dma(&self, address: u32) -> u32 {
        match Self::channel_of(address) {
            Some((channel, 4)) => self.dma.channels[channel].left,
            _ => self.regs[address],
        }
    }

    pub(crate) fn write_dma(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let Some((channel, offset)) = Self::channel_of(address) else {
            // DMA_IFCR (12.6.2): ones clear flags; bit 0 of a channel clears all of its flags.
            let base = address - at::dma::IFCR;
            let all = (0..8).filter(|n| value >> (4 * n) & 1 != 0).fold(value, |bits, n| bits | 0xf << (4 * n));
            let isr = &mut self.regs[base + at::dma::ISR];
            *isr &= !all;
            // GIF is cleared with the last of them.
            for n in 0..8 {
                if *isr >> (4 * n) & 0xe == 0 {
                    *isr &= !(1 << (4 * n));
                }
            }
            let first = if base == DMA2 { 8 } else { 0 };
            (first..first + 8).for_each(|channel| self.dma_line(channel, ports));
            return Ok(());
        };
        let old = self.regs[address];
        let on = self.regs[registers(channel)] & 1 != 0;
        // CPAR, CMAR, CNDTR, and CCR without its interrupt enables and EN may change only while the
        // channel is off (12.4.3). Fields written together with a cleared EN have no effect: they
        // are read-only until then (12.6.3).
        let bits = value ^ self.read_dma(address);
        let value = if on && offset == 0 && value & 1 == 0 { old & !0xf | value & 0xf } else { value };
        let bits = if offset == 0 { (value ^ old) & !0xf } else { bits };
        if on && bits != 0 {
            return self.report(now, address, bits, value, Rule::DmaEnabled);
        }
        if offset == 0 {
            self.refuse_bits(now, address, value, 1 << 14)?;
        }
        self.regs[address] = if offset == 4 { value & 0xffff } else { value };
        if offset == 4 {
            (self.dma.channels[channel].left, self.dma.channels[channel].count) = (value & 0xffff, value & 0xffff);
        }
        if offset == 0 {
            self.dma.channels[channel].control = value;
            if value & 1 != 0 && !on {
                let (peripheral, memory) = (self.regs[address + 8], self.regs[address + 12]);
                let entry = &mut self.dma.channels[channel];
                (entry.peripheral, entry.memory) = (peripheral, memory);
                self.serve_pending(now, channel, ports)?;
            }
            self.dma_line(channel, ports);
        }
        Ok(())
    }

    pub(crate) fn write_dmamux(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let channel = (address - DMAMUX1) / 4;
        if channel >= 16 {
            return self.refuse(now, address, "synchronisation and request generators");
        }
        self.refuse_bits(now, address, value, !0x7f)?;
        self.regs[address] = value;
        self.dma.of_request = [0; REQUESTS];
        for channel in 0..16 {
            let request = self.regs[DMAMUX1 + 4 * channel] & 0x7f;
            if request != 0 {
                self.dma.of_request[request as usize] = channel as u8 + 1;
            }
        }
        self.serve_pending(now, channel as usize, ports)
    }

    /// Serves pending requests of a channel that was enabled.
    fn serve_pending(&mut self, now: Now, channel: usize, ports: &mut Ports) -> Result<(), Fault> {
        let request = self.regs[DMAMUX1 + 4 * channel as u32] & 0x7f;
        if request != 0 && self.dma.channels[channel].control & 1 != 0 {
            self.serve_requests(now, request as u8, ports)?;
        }
        Ok(())
    }

    /// Requests a transfer for a peripheral. Returns `true` if it was made; otherwise the request
    /// is pending.
    pub(crate) fn request(&mut self, now: Now, request: u8, ports: &mut Ports) -> Result<bool, Fault> {
        let Some(channel) = usize::from(self.dma.of_request[usize::from(request)]).checked_sub(1) else { return Ok(false) };
        let state = self.dma.channels[channel];
        let control = Cr(state.control);
        if !control.en() || state.dead || state.left == 0 {
            return Ok(false);
        }
        if state.misses > 0 {
            self.dma.channels[channel].misses -= 1;
            return Ok(false);
        }
        if std::mem::take(&mut self.dma.channels[channel].fails) {
            self.count(now, channel, false, ports)?;
            return Ok(true);
        }
        let done = state.count - state.left;
        let (psize, msize) = (control.psize().to_bits().min(2), control.msize().to_bits().min(2));
        let peripheral = state.peripheral + if control.pinc() { done << psize } else { 0 };
        let memory = state.memory + if control.minc() { done << msize } else { 0 };
        let moved = if control.dir() == Dir::FROM_MEMORY {
            match ports.memory.get(memory, 1 << msize) {
                Some(bytes) => {
                    let mut word = [0; 4];
                    word[..bytes.len()].copy_from_slice(bytes);
                    self.bus_write(now, peripheral, u32::from_le_bytes(word), ports)?
                }
                None => false,
            }
        } else {
            match self.bus_read(now, peripheral, ports)? {
                Some(value) => match ports.memory.get_mut(memory, 1 << msize) {
                    // DMA cannot write to the flash.
                    Some(bytes) if memory >= 0x1000_0000 => {
                        bytes.copy_from_slice(&value.to_le_bytes()[..1 << msize]);
                        true
                    }
                    _ => false,
                },
                None => false,
            }
        };
        self.dma.held_up += contention::transfer_delay(peripheral);
        self.count(now, channel, moved, ports)?;
        Ok(true)
    }

    /// Updates CNDTR, flags and interrupt after a transfer (12.4.3, 12.4.5).
    fn count(&mut self, now: Now, channel: usize, moved: bool, ports: &mut Ports) -> Result<(), Fault> {
        let state = &mut self.dma.channels[channel];
        let mut flags = 0;
        if moved {
            state.left -= 1;
            if state.left == state.count / 2 {
                flags |= HT;
            }
            if state.left == 0 {
                flags |= TC;
                if state.control & 1 << 5 != 0 {
                    state.left = state.count;
                }
            }
        } else {
            flags |= TE;
            state.control &= !1;
            self.regs[registers(channel)] &= !1;
            self.report(now, registers(channel), u32::MAX, self.dma.channels[channel].memory, Rule::DmaError)?;
        }
        if flags != 0 {
            self.regs[controller(channel) + at::dma::ISR] |= (flags | 1) << (4 * (channel & 7));
            if channel < 8 && !self.iwdg.running {
                self.report(now, crate::map::base::IWDG, u32::MAX, 0, Rule::IwdgMissing)?;
            }
            self.dma_line(channel, ports);
        }
        Ok(())
    }

    fn dma_line(&self, channel: usize, ports: &mut Ports) {
        let flags = self.regs[controller(channel) + at::dma::ISR] >> (4 * (channel & 7));
        ports.interrupts.set(LINES[channel], flags & self.dma.channels[channel].control & 0xe != 0);
    }

    fn bus_read(&mut self, now: Now, address: u32, ports: &mut Ports) -> Result<Option<u32>, Fault> {
        let Some((register, _)) = self.regs.find(address & !3) else { return Ok(None) };
        Ok(Some(self.load(now, register, ports)? >> (address % 4 * 8)))
    }

    fn bus_write(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<bool, Fault> {
        let Some((register, _)) = self.regs.find(address & !3) else { return Ok(false) };
        self.store(now, register, value, ports)?;
        Ok(true)
    }
}
