//! The four DACs. RM0440 22.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::dac::regs::{Cr, Mcr};

use crate::finding::Rule;
use crate::map::at::dac as reg;
use crate::map::base::{DAC1, DAC2};
use crate::map::{TRIGGERS, line};
use crate::part::{Now, Stm32g474};
use crate::wires::Wires;

/// Bytes from one DAC to the next.
const STRIDE: u32 = DAC2 - DAC1;
/// DMA requests of both channels (13.3.2, table of requests).
const REQUESTS: [[u8; 2]; 4] = [[6, 7], [41, 42], [102, 103], [104, 105]];
/// DAC_SR.DMAUDR of each channel.
const UNDERRUN: [u32; 2] = [1 << 13, 1 << 29];

/// State of a DAC.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dac {
    /// Held codes.
    held: [u16; 2],
    /// Second held codes, of double data.
    second: [u16; 2],
    /// Codes at the output.
    pub output: [u16; 2],
    /// `true` if the second code of double data is next.
    is_second: [bool; 2],
    /// `true` while DMA has not served a request.
    waits: [bool; 2],
}

impl Dac {
    /// Returns the voltage of a channel, V (22.4.7).
    pub fn volts(&self, channel: usize, vdda: f64) -> f64 {
        f64::from(self.output[channel]) / 4096.0 * vdda
    }
}

fn first(index: usize) -> u32 {
    DAC1 + index as u32 * STRIDE
}

/// Returns the timer of a DAC's trigger number: 0 for TIM2 to 3 for TIM5.
fn trigger_timer(index: usize, number: u8) -> Option<usize> {
    // The metadata has the lists of DAC1 and DAC3. DAC2 and DAC4 are assumed to be as DAC1 for
    // these timers.
    let dac = if index == 2 { "DAC3" } else { "DAC1" };
    let signal = format!("DAC_CHX_TRG{number}");
    let (.., source) = TRIGGERS.iter().find(|(peripheral, name, _)| *peripheral == dac && *name == signal)?;
    ["TIM2_TRGO", "TIM3_TRGO", "TIM4_TRGO", "TIM5_TRGO"].iter().position(|timer| timer == source)
}

impl<W: Wires> Stm32g474<W> {
    fn dac_cr(&self, index: usize) -> Cr {
        Cr(self.regs[first(index) + reg::CR])
    }

    pub(crate) fn read_dac(&self, address: u32) -> u32 {
        let index = ((address - DAC1) / STRIDE) as usize;
        let dac = &self.dacs[index];
        let held = |channel: usize| u32::from(dac.held[channel]);
        match address - first(index) {
            reg::DHR12R_0 => held(0) | u32::from(dac.second[0]) << 16,
            reg::DHR12R_1 => held(1) | u32::from(dac.second[1]) << 16,
            reg::DHR12RD => held(0) | held(1) << 16,
            reg::DOR_0 => u32::from(dac.output[0]),
            reg::DOR_1 => u32::from(dac.output[1]),
            _ => self.regs[address],
        }
    }

    pub(crate) fn write_dac(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let index = ((address - DAC1) / STRIDE) as usize;
        let low = (value & 0xfff) as u16;
        let high = (value >> 16 & 0xfff) as u16;
        match address - first(index) {
            reg::DHR12RD => self.hold(now, index, [Some(low), Some(high)], ports),
            reg::DHR12R_0 => {
                self.dacs[index].second[0] = high;
                self.hold(now, index, [Some(low), None], ports)
            }
            reg::DHR12R_1 => {
                self.dacs[index].second[1] = high;
                self.hold(now, index, [None, Some(low)], ports)
            }
            reg::DHR12L_0 => self.hold(now, index, [Some((value >> 4 & 0xfff) as u16), None], ports),
            reg::DHR12L_1 => self.hold(now, index, [None, Some((value >> 4 & 0xfff) as u16)], ports),
            reg::DHR8R_0 => self.hold(now, index, [Some((value & 0xff) as u16 * 16), None], ports),
            reg::DHR8R_1 => self.hold(now, index, [None, Some((value & 0xff) as u16 * 16)], ports),
            reg::CR => self.write_dac_cr(now, index, Cr(value), ports),
            reg::MCR => self.write_mcr(now, index, Mcr(value)),
            reg::SR => {
                self.regs[address] &= !(value & (UNDERRUN[0] | UNDERRUN[1]));
                self.dac_line(index, ports);
                Ok(())
            }
            reg::SWTRIGR => {
                for channel in (0..2).filter(|channel| value >> channel & 1 != 0) {
                    let cr = self.dac_cr(index);
                    if cr.en(channel) && cr.ten(channel) && cr.tsel(channel) == 0 {
                        self.step(now, index, channel, ports)?;
                    }
                }
                self.put_out(now.at, index, false, ports)
            }
            _ => self.refuse(now, address, "the register"),
        }
    }

    /// Holds new codes; without a trigger they go to the output at once (22.4.5).
    fn hold(&mut self, now: Now, index: usize, codes: [Option<u16>; 2], ports: &mut Ports) -> Result<(), Fault> {
        let cr = self.dac_cr(index);
        let mut stepped = false;
        for (channel, code) in codes.into_iter().enumerate() {
            if let Some(code) = code {
                self.dacs[index].held[channel] = code;
                if cr.en(channel) && !cr.ten(channel) {
                    stepped |= std::mem::replace(&mut self.dacs[index].output[channel], code) != code;
                }
            }
        }
        if stepped { self.put_out(now.at, index, false, ports) } else { Ok(()) }
    }

    fn put_out(&mut self, at: Cycle, index: usize, triggered: bool, ports: &mut Ports) -> Result<(), Fault> {
        self.wires.dac(at, index as u8 + 1, self.dacs[index].output, triggered);
        if self.compares() {
            self.compare(at, ports);
        }
        Ok(())
    }

    fn write_dac_cr(&mut self, now: Now, index: usize, value: Cr, ports: &mut Ports) -> Result<(), Fault> {
        let address = first(index) + reg::CR;
        // Waves and calibration.
        self.refuse_bits(now, address, value.0, 0xc0 << 16 | 0xc0 | 1 << 14 | 1 << 30)?;
        for channel in 0..2 {
            let number = value.tsel(channel);
            if value.ten(channel) && number != 0 && trigger_timer(index, number).is_none() {
                return self.refuse(now, address, "a trigger that is not TIM2 to TIM5 or software");
            }
        }
        let old = std::mem::replace(&mut self.regs[address], value.0);
        let mcr = Mcr(self.regs[first(index) + reg::MCR]);
        let needed = match self.time.hz() {
            0..=80_000_000 => 0,
            80_000_001..=160_000_000 => 1,
            _ => 2,
        };
        if (value.en(0) || value.en(1)) && mcr.hfsel() < needed {
            self.report(now, first(index) + reg::MCR, 3 << 14, mcr.0, Rule::DacBusClock)?;
        }
        for channel in 0..2 {
            let dac = &mut self.dacs[index];
            if !value.en(channel) {
                (dac.output[channel], dac.waits[channel], dac.is_second[channel]) = (0, false, false);
            } else if !value.ten(channel) {
                dac.output[channel] = dac.held[channel];
            }
            if !value.dmaen(channel) {
                dac.waits[channel] = false;
            }
        }
        // DACRDY (22.7.14).
        let ready = u32::from(value.en(0)) << 11 | u32::from(value.en(1)) << 27;
        let sr = &mut self.regs[first(index) + reg::SR];
        *sr = *sr & !(1 << 11 | 1 << 27) | ready;
        self.rewire();
        if (old ^ value.0) & 0x0001_0001 != 0 || value.en(0) || value.en(1) {
            self.put_out(now.at, index, false, ports)?;
        }
        self.dac_line(index, ports);
        Ok(())
    }

    fn write_mcr(&mut self, now: Now, index: usize, value: Mcr) -> Result<(), Fault> {
        let address = first(index) + reg::MCR;
        let cr = self.dac_cr(index);
        let old = self.regs[address];
        // The half of each channel may change only while it is off (22.7.17); HFSEL may always
        // change.
        let bits = (value.0 ^ old) & (if cr.en(0) { 0x107 } else { 0 } | if cr.en(1) { 0x107 << 16 } else { 0 });
        if bits != 0 {
            self.report(now, address, bits, value.0, Rule::DacEnabled)?;
        }
        // Sample and hold, signed data.
        self.refuse_bits(now, address, value.0, 4 | 4 << 16 | 1 << 9 | 1 << 25)?;
        self.regs[address] = value.0;
        Ok(())
    }

    /// Returns the timer, counted from TIM2, that triggers each DAC channel.
    pub(crate) fn dac_triggers(&self) -> [Option<usize>; 8] {
        std::array::from_fn(|entry| {
            let (index, channel) = (entry / 2, entry % 2);
            let cr = self.dac_cr(index);
            if cr.en(channel) && cr.ten(channel) { trigger_timer(index, cr.tsel(channel)) } else { None }
        })
    }

    /// Handles TRGO of a timer: its channels output the next code, and then DMA loads another.
    pub(crate) fn trigger_dacs(&mut self, at: Cycle, _timer: usize, channels: u8, ports: &mut Ports) -> Result<(), Fault> {
        let now = self.now(at);
        for index in 0..4 {
            let both = channels >> (2 * index) & 3;
            // Both channels output before any DMA transfer: one request can serve both (22.4.8).
            let asks = [0, 1].map(|channel| both >> channel & 1 != 0 && self.put(index, channel));
            for channel in (0..2).filter(|channel| asks[*channel]) {
                self.ask(now, index, channel, ports)?;
            }
            if both != 0 {
                self.put_out(at, index, true, ports)?;
            }
        }
        Ok(())
    }

    /// Handles a trigger of a channel: outputs its held code and requests the next one by DMA
    /// (22.4.8).
    fn step(&mut self, now: Now, index: usize, channel: usize, ports: &mut Ports) -> Result<(), Fault> {
        if self.put(index, channel) { self.ask(now, index, channel, ports) } else { Ok(()) }
    }

    /// Outputs the held code of a channel. Returns `true` if it then needs the next one by DMA.
    fn put(&mut self, index: usize, channel: usize) -> bool {
        let double = Mcr(self.regs[first(index) + reg::MCR]).dmadouble(channel);
        let dac = &mut self.dacs[index];
        let is_second = double && dac.is_second[channel];
        dac.output[channel] = if is_second { dac.second[channel] } else { dac.held[channel] };
        dac.is_second[channel] = double && !is_second;
        self.dac_cr(index).dmaen(channel) && (!double || is_second)
    }

    /// Requests the next code of a channel by DMA.
    fn ask(&mut self, now: Now, index: usize, channel: usize, ports: &mut Ports) -> Result<(), Fault> {
        let sr = first(index) + reg::SR;
        if self.regs[sr] & UNDERRUN[channel] != 0 {
            return Ok(());
        }
        if self.dacs[index].waits[channel] {
            self.regs[sr] |= UNDERRUN[channel];
            self.dac_line(index, ports);
            return self.report(now, sr, UNDERRUN[channel], self.regs[sr], Rule::DacUnderrun);
        }
        self.dacs[index].waits[channel] = !self.request(now, REQUESTS[index][channel], ports)?;
        Ok(())
    }

    /// Serves a pending request after a DMA channel was enabled.
    pub(crate) fn serve_dac(&mut self, now: Now, request: u8, ports: &mut Ports) -> Result<(), Fault> {
        for (index, own) in REQUESTS.into_iter().enumerate() {
            for (channel, own) in own.into_iter().enumerate() {
                if own == request && self.dacs[index].waits[channel] {
                    self.dacs[index].waits[channel] = !self.request(now, request, ports)?;
                }
            }
        }
        Ok(())
    }

    fn dac_line(&self, index: usize, ports: &mut Ports) {
        let (sr, cr) = (self.regs[first(index) + reg::SR], self.dac_cr(index));
        let high = (0..2).any(|channel| cr.dmaudrie(channel) && sr & UNDERRUN[channel] != 0);
        // DAC1 and DAC3 share the line of TIM6, DAC2 and DAC4 that of TIM7.
        ports.interrupts.set(if index.is_multiple_of(2) { line::TIM6_DAC } else { line::TIM7_DAC }, high);
    }
}
