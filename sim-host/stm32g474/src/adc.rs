//! The five ADCs: power-up, calibration, triggers, oversampling, dual mode. RM0440 21.
//!
//! A conversion is three events: its trigger, the instant at which the input is held, and its end. `adc_control.rs` has the registers.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::adc::regs::{Cfgr, Cfgr2, Cr, Isr, Smpr, Smpr2, Sqr1, Sqr2, Sqr3, Sqr4};
use stm32_metapac::adccommon::regs::Ccr;

use crate::factory::{reference_volts, sensor_volts};
use crate::finding::Rule;
use crate::map::at::{adc as reg, adccommon as common};
use crate::map::base::{ADC1, ADC2, ADC3, ADC4, ADC5, ADC12_COMMON, ADC345_COMMON, RCC};
use crate::map::{SIGNALS, at, line};
use crate::part::{Now, Stm32g474};
use crate::time::{Event, Ps};
use crate::wires::{Pin, Wires};

pub(crate) const BASES: [u32; 5] = [ADC1, ADC2, ADC3, ADC4, ADC5];
/// DMA requests (13.3.2, table of requests).
const REQUESTS: [u8; 5] = [5, 36, 37, 38, 39];
/// Sampling times, ADC cycles (21.4.12).
const SAMPLING: [f64; 8] = [2.5, 6.5, 12.5, 24.5, 47.5, 92.5, 247.5, 640.5];
/// ADC cycles of a conversion after the sampling, 12 bits (21.4.16).
const CONVERSION: f64 = 12.5;
/// ADC cycles from a trigger to the start of the sampling, by CKMODE (DS12288, ADC characteristics, t_LATR): the most, where the clock is asynchronous.
const LATENCY: [f64; 4] = [2.5, 2.0, 2.25, 2.125];
/// Margin between the end of a conversion and the next trigger below which [`Rule::AdcTriggerMargin`] speaks, ADC cycles.
const MARGIN: f64 = 0.25;
/// Regular simultaneous mode (ADCx_CCR.DUAL).
pub(crate) const SIMULTANEOUS: u8 = 6;

/// What an ADC converts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Input {
    Pin(Pin),
    Sensor,
    Reference,
    Unknown,
}

/// An ADC.
#[derive(Clone, Debug)]
pub(crate) struct Adc {
    /// When its regulator has started up; when it was calibrated.
    pub regulated: Option<Ps>,
    pub calibrated: Option<Cycle>,
    /// A conversion is under way; when it ends, or the last one has ended, to a fraction of a cycle.
    pub busy: bool,
    end: f64,
    inputs: [Input; 16],
    rank: usize,
    held: u32,
    sum: u32,
    count: u32,
    /// The data register, and whether DMA still has to take it.
    pub data: u32,
    pub waits: bool,
    /// Converts everything to this.
    pub stuck: Option<u16>,
}

impl Default for Adc {
    fn default() -> Self {
        Adc {
            regulated: None,
            calibrated: None,
            busy: false,
            end: f64::NEG_INFINITY,
            inputs: [Input::Unknown; 16],
            rank: 0,
            held: 0,
            sum: 0,
            count: 0,
            data: 0,
            waits: false,
            stuck: None,
        }
    }
}

impl Adc {
    /// Takes it to its reset state.
    pub fn reset(&mut self) {
        *self = Adc { stuck: self.stuck, ..Adc::default() };
    }

    /// Ends what is under way.
    pub fn stop(&mut self) {
        (self.busy, self.rank, self.sum, self.count) = (false, 0, 0, 0);
    }
}

/// The common registers of an ADC.
pub(crate) fn common_of(index: usize) -> u32 {
    if index < 2 { ADC12_COMMON } else { ADC345_COMMON }
}

impl<W: Wires> Stm32g474<W> {
    pub(crate) fn adc_cr(&self, index: usize) -> Cr {
        Cr(self.regs[BASES[index] + reg::CR])
    }

    pub(crate) fn adc_ccr(&self, index: usize) -> Ccr {
        Ccr(self.regs[common_of(index) + common::CCR])
    }

    /// Core cycles of an ADC cycle; none without a clock (21.4.3).
    pub(crate) fn adc_period(&self, index: usize) -> Option<f64> {
        let ccr = self.adc_ccr(index);
        match ccr.ckmode().to_bits() {
            0 => {
                let select = self.regs[RCC + at::rcc::CCIPR] >> (if index < 2 { 28 } else { 30 }) & 3;
                let kernel = match select {
                    1 => self.pll_p(),
                    2 => self.system_hz(),
                    _ => return None,
                };
                const PRESCALERS: [u32; 12] = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];
                let prescaler = PRESCALERS.get(usize::from(ccr.presc().to_bits()))?;
                Some(f64::from(*prescaler) * self.time.hz() as f64 / kernel as f64)
            }
            mode => Some(f64::from(1 << (mode - 1))),
        }
    }

    /// Whether an ADC is the slave of a pair that converts together.
    fn is_slave(&self, index: usize) -> bool {
        matches!(index, 1 | 3) && self.adc_ccr(index).dual().to_bits() == SIMULTANEOUS
    }

    /// The ADC that converts with this one.
    pub(crate) fn partner(&self, index: usize) -> Option<usize> {
        (matches!(index, 0 | 2) && self.adc_ccr(index).dual().to_bits() == SIMULTANEOUS).then_some(index + 1)
    }

    /// What is at a channel (21.4.11, table of the inputs).
    fn input(&self, index: usize, channel: u8) -> Input {
        let internal = match (index, channel) {
            (0, 16) | (4, 4) => Some(Input::Sensor),
            (0 | 2 | 3 | 4, 18) => Some(Input::Reference),
            _ => None,
        };
        let name = format!("ADC{}", index + 1);
        let signal = format!("IN{channel}");
        let pin = || {
            SIGNALS
                .iter()
                .find(|(peripheral, input, ..)| *peripheral == name && *input == signal)
                .and_then(|(.., pin, _)| Pin::named(pin))
        };
        internal.or_else(|| pin().map(Input::Pin)).unwrap_or(Input::Unknown)
    }

    /// The channel of a place in the sequence (21.7.11 to 21.7.14).
    fn channel(&self, index: usize, rank: usize) -> u8 {
        let base = BASES[index];
        match rank {
            0..4 => Sqr1(self.regs[base + reg::SQR1]).sq(rank),
            4..9 => Sqr2(self.regs[base + reg::SQR2]).sq(rank - 4),
            9..14 => Sqr3(self.regs[base + reg::SQR3]).sq(rank - 9),
            _ => Sqr4(self.regs[base + reg::SQR4]).sq(rank - 14),
        }
    }

    /// Looks up the sequence when it is started.
    pub(crate) fn prepare_adc(&mut self, now: Now, index: usize) -> Result<(), Fault> {
        let length = usize::from(Sqr1(self.regs[BASES[index] + reg::SQR1]).l());
        for rank in 0..=length {
            let channel = self.channel(index, rank);
            let input = self.input(index, channel);
            let ccr = self.adc_ccr(index);
            match input {
                Input::Unknown => return self.refuse(now, BASES[index] + reg::SQR1, &format!("channel {channel}")),
                Input::Sensor if !ccr.vsenseen() => {
                    self.report(now, common_of(index) + common::CCR, 1 << 23, ccr.0, Rule::AdcInternalOff)?;
                }
                Input::Reference if !ccr.vrefen() => {
                    self.report(now, common_of(index) + common::CCR, 1 << 22, ccr.0, Rule::AdcInternalOff)?;
                }
                _ => {}
            }
            self.adcs[index].inputs[rank] = input;
        }
        self.adcs[index].stop();
        Ok(())
    }

    fn sampling(&self, index: usize, rank: usize) -> f64 {
        let channel = self.channel(index, rank);
        let smpr = Smpr(self.regs[BASES[index] + reg::SMPR]);
        let time = if channel < 10 {
            smpr.smp(usize::from(channel))
        } else {
            Smpr2(self.regs[BASES[index] + reg::SMPR2]).smp(usize::from(channel) - 10)
        };
        match time.to_bits() {
            // SMPPLUS makes 2.5 cycles 3.5 (21.7.6).
            0 if smpr.smpplus() => 3.5,
            code => SAMPLING[usize::from(code)],
        }
    }

    /// The timers, from TIM2, that trigger each ADC.
    pub(crate) fn adc_triggers(&self) -> [Option<usize>; 5] {
        std::array::from_fn(|index| {
            let cfgr = Cfgr(self.regs[BASES[index] + reg::CFGR]);
            if !self.adc_cr(index).adstart() || cfgr.exten().to_bits() == 0 || self.is_slave(index) {
                return None;
            }
            crate::adc_control::trigger_timer(index, cfgr.extsel())
        })
    }

    /// A trigger of the regular group (21.4.18).
    pub(crate) fn trigger_adc(&mut self, at: Cycle, index: usize, ports: &mut Ports) -> Result<(), Fault> {
        let now = self.now(at);
        if self.adcs[index].busy && self.adcs[index].end <= at as f64 {
            self.agenda.clear(Event::AdcEnd(index));
            self.adc_end(at, index, ports)?;
        }
        if self.adcs[index].busy {
            let isr = self.regs[BASES[index] + reg::ISR];
            return self.report(now, BASES[index] + reg::CFGR, 0x1f << 5, isr, Rule::AdcTriggerLost);
        }
        let Some(period) = self.adc_period(index) else {
            return self.refuse(now, BASES[index] + reg::CR, "an ADC without a clock");
        };
        if at as f64 - self.adcs[index].end < MARGIN * period {
            self.report(now, BASES[index] + reg::SMPR, u32::MAX, self.regs[BASES[index] + reg::SMPR], Rule::AdcTriggerMargin)?;
        }
        self.convert(index, at as f64 + LATENCY[usize::from(self.adc_ccr(index).ckmode().to_bits())] * period, period);
        Ok(())
    }

    /// A conversion, sampling from `from` on.
    fn convert(&mut self, index: usize, from: f64, period: f64) {
        let hold = from + self.sampling(index, self.adcs[index].rank) * period;
        let adc = &mut self.adcs[index];
        (adc.busy, adc.end) = (true, hold + CONVERSION * period);
        let end = adc.end.ceil() as Cycle;
        self.agenda.set(Event::AdcHold(index), hold.ceil() as Cycle);
        self.agenda.set(Event::AdcEnd(index), end);
    }

    /// Starts a conversion by software.
    pub(crate) fn start_adc(&mut self, now: Now, index: usize) -> Result<(), Fault> {
        let Some(period) = self.adc_period(index) else {
            return self.refuse(now, BASES[index] + reg::CR, "an ADC without a clock");
        };
        let latency = LATENCY[usize::from(self.adc_ccr(index).ckmode().to_bits())];
        self.convert(index, now.at as f64 + latency * period, period);
        Ok(())
    }

    /// The input is held: 12 bits of it, in units of the reference (21.4.32).
    pub(crate) fn adc_hold(&mut self, at: Cycle, index: usize) {
        for member in [Some(index), self.partner(index)].into_iter().flatten() {
            let rank = self.adcs[index].rank;
            let volts = match self.adcs[member].inputs[rank] {
                Input::Pin(pin) => self.wires.volts(at, pin),
                Input::Sensor if self.adc_ccr(member).vsenseen() => sensor_volts(self.wires.celsius(at)),
                Input::Reference if self.adc_ccr(member).vrefen() => reference_volts(),
                _ => 0.0,
            };
            let code = (volts / self.config.vdda * 4096.0).round().clamp(0.0, 4095.0) as u32;
            self.adcs[member].held = self.adcs[member].stuck.map_or(code, u32::from);
        }
    }

    /// A conversion ends: what follows it, and what is to be done with it (21.4.26, 21.4.30, 21.4.31).
    pub(crate) fn adc_end(&mut self, at: Cycle, index: usize, ports: &mut Ports) -> Result<(), Fault> {
        if !self.adcs[index].busy {
            return Ok(());
        }
        let (base, partner) = (BASES[index], self.partner(index));
        let (cfgr, cfgr2) = (Cfgr(self.regs[base + reg::CFGR]), Cfgr2(self.regs[base + reg::CFGR2]));
        let (wanted, shift) = if cfgr2.rovse() { (2 << cfgr2.ovsr(), cfgr2.ovss()) } else { (1, 0) };
        for member in [Some(index), partner].into_iter().flatten() {
            let adc = &mut self.adcs[member];
            adc.sum += adc.held;
            adc.count += 1;
        }
        self.adcs[index].busy = false;
        let end = self.adcs[index].end;
        let period = self.adc_period(index).unwrap_or(1.0);
        if self.adcs[index].count < wanted {
            // The next one of the sum comes with a trigger of its own, or at once.
            if cfgr2.trovs().to_bits() == 0 {
                self.convert(index, end, period);
            }
            return Ok(());
        }
        let last = self.adcs[index].rank == usize::from(Sqr1(self.regs[base + reg::SQR1]).l());
        for member in [Some(index), partner].into_iter().flatten() {
            let adc = &mut self.adcs[member];
            let value = adc.sum >> shift & 0xffff;
            (adc.sum, adc.count) = (0, 0);
            self.result(at, member, value, last)?;
        }
        self.adcs[index].rank = if last { 0 } else { self.adcs[index].rank + 1 };
        if !last || cfgr.cont() {
            self.convert(index, end, period);
        } else if cfgr.exten().to_bits() == 0 {
            self.regs[base + reg::CR] &= !(1 << 2);
        }
        self.ask_dma(at, index, ports)?;
        self.adc_line(index, ports);
        Ok(())
    }

    /// A new value in ADC_DR, unless the last one was not read (21.4.26).
    fn result(&mut self, at: Cycle, index: usize, value: u32, last: bool) -> Result<(), Fault> {
        let base = BASES[index];
        let mut isr = Isr(self.regs[base + reg::ISR]);
        let cfgr = Cfgr(self.regs[base + reg::CFGR]);
        let unread = isr.eoc() || self.adcs[index].waits;
        isr.set_eoc(true);
        isr.set_eos(isr.eos() || last);
        if unread {
            isr.set_ovr(true);
        }
        self.regs[base + reg::ISR] = isr.0;
        let overwrites = cfgr.ovrmod().to_bits() != 0;
        if !unread || overwrites {
            self.adcs[index].data = value;
        }
        if unread && !overwrites {
            return self.report(self.now(at), base + reg::ISR, 1 << 4, isr.0, Rule::AdcOverrun);
        }
        Ok(())
    }

    /// Asks DMA to take a value: one for both of a pair, or one each.
    fn ask_dma(&mut self, at: Cycle, index: usize, ports: &mut Ports) -> Result<(), Fault> {
        let now = self.now(at);
        let pair = self.partner(index).filter(|_| self.adc_ccr(index).mdma().to_bits() != 0);
        let members = if pair.is_some() { [Some(index), None] } else { [Some(index), self.partner(index)] };
        for member in members.into_iter().flatten() {
            let asks = pair.is_some() || Cfgr(self.regs[BASES[member] + reg::CFGR]).dmaen().to_bits() != 0;
            // An overrun stops the requests until it is cleared.
            if asks && !Isr(self.regs[BASES[member] + reg::ISR]).ovr() {
                self.adcs[member].waits = true;
                let served = self.request(now, REQUESTS[member], ports)?;
                self.adcs[member].waits = !served;
            }
        }
        Ok(())
    }

    /// A DMA channel is on: a value that waits is taken.
    pub(crate) fn serve_adc(&mut self, now: Now, request: u8, ports: &mut Ports) -> Result<(), Fault> {
        for index in 0..5 {
            if REQUESTS[index] == request && self.adcs[index].waits {
                self.adcs[index].waits = !self.request(now, request, ports)?;
            }
        }
        Ok(())
    }

    pub(crate) fn adc_line(&self, index: usize, ports: &mut Ports) {
        const LINES: [u16; 5] = [line::ADC1_2, line::ADC1_2, line::ADC3, line::ADC4, line::ADC5];
        let high = |index: usize| self.regs[BASES[index] + reg::ISR] & self.regs[BASES[index] + reg::IER] != 0;
        ports.interrupts.set(LINES[index], high(index) || (index < 2 && high(1 - index)));
    }
}
