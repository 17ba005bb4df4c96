//! The five ADCs: power-up, calibration, triggers, oversampling, dual mode. RM0440 21.
//!
//! A conversion has three events: its trigger, the hold of its input, and its end. `adc_control.rs`
//! contains the registers.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::adc::regs::{Cfgr, Cfgr2, Cr, Isr, Sqr1};
use stm32_metapac::adccommon::regs::Ccr;

use crate::adc_inputs::Input;
use crate::factory::{reference_volts, sensor_volts};
use crate::finding::Rule;
use crate::map::at::{adc as reg, adccommon as common};
use crate::map::base::{ADC1, ADC2, ADC3, ADC4, ADC5, ADC12_COMMON, ADC345_COMMON};
use crate::map::line;
use crate::part::{Now, Stm32g474};
use crate::time::{Event, Ps};
use crate::wires::Wires;

pub(crate) const BASES: [u32; 5] = [ADC1, ADC2, ADC3, ADC4, ADC5];
/// DMA requests (13.3.2, table of requests).
const REQUESTS: [u8; 5] = [5, 36, 37, 38, 39];
/// ADC cycles of a conversion after the sampling, 12 bits (21.4.16).
const CONVERSION_CYCLES: f64 = 12.5;
/// Minimum time from the end of a conversion to the next trigger without
/// [`Rule::AdcTriggerMargin`], ADC cycles.
const TRIGGER_MARGIN: f64 = 0.25;
/// Regular simultaneous mode (ADCx_CCR.DUAL).
pub(crate) const SIMULTANEOUS: u8 = 6;

/// State of an ADC.
#[derive(Clone, Debug)]
pub(crate) struct Adc {
    /// Time at which its regulator has started up, ps.
    pub regulated: Option<Ps>,
    /// Cycle of its calibration.
    pub calibrated: Option<Cycle>,
    /// `true` during a conversion.
    pub busy: bool,
    /// End of the current or last conversion, cycles with a fraction.
    end: f64,
    pub inputs: [Input; 16],
    /// Core cycles of an ADC cycle.
    pub period: f64,
    /// Core cycles from a trigger to the sampling.
    pub latency: f64,
    /// Core cycles of the sampling of each place of the sequence.
    pub sampling: [f64; 16],
    rank: usize,
    held: u32,
    sum: u32,
    count: u32,
    /// Data register.
    pub data: u32,
    /// `true` if DMA still has to take the data register.
    pub waits: bool,
    /// Code of every conversion, if the ADC is stuck.
    pub stuck: Option<u16>,
    /// Previous result, if each one is stored a sample late.
    pub late: Option<u32>,
}

impl Default for Adc {
    fn default() -> Self {
        Adc {
            regulated: None,
            calibrated: None,
            busy: false,
            end: f64::NEG_INFINITY,
            inputs: [Input::Unknown; 16],
            period: 1.0,
            latency: 0.0,
            sampling: [0.0; 16],
            rank: 0,
            held: 0,
            sum: 0,
            count: 0,
            data: 0,
            waits: false,
            stuck: None,
            late: None,
        }
    }
}

impl Adc {
    /// Resets the state; a defect stays.
    pub fn reset(&mut self) {
        *self = Adc { stuck: self.stuck, late: self.late, ..Adc::default() };
    }

    /// Stops the current conversion and sequence.
    pub fn stop(&mut self) {
        (self.busy, self.rank, self.sum, self.count) = (false, 0, 0, 0);
    }
}

/// Returns the address of the common registers of an ADC.
pub(crate) fn common_of(index: usize) -> u32 {
    if index < 2 { ADC12_COMMON } else { ADC345_COMMON }
}

/// Rounds a time up to a cycle. `f64::ceil` is a function call on some hosts.
fn first_cycle(time: f64) -> Cycle {
    let whole = time as Cycle;
    whole + Cycle::from((whole as f64) < time)
}

impl<W: Wires> Stm32g474<W> {
    pub(crate) fn adc_cr(&self, index: usize) -> Cr {
        Cr(self.regs[BASES[index] + reg::CR])
    }

    pub(crate) fn adc_ccr(&self, index: usize) -> Ccr {
        Ccr(self.regs[common_of(index) + common::CCR])
    }

    /// Returns `true` if an ADC is the slave of a pair that converts together.
    fn is_slave(&self, index: usize) -> bool {
        matches!(index, 1 | 3) && self.adc_ccr(index).dual().to_bits() == SIMULTANEOUS
    }

    /// Returns the slave that converts together with this ADC.
    pub(crate) fn partner(&self, index: usize) -> Option<usize> {
        (matches!(index, 0 | 2) && self.adc_ccr(index).dual().to_bits() == SIMULTANEOUS).then_some(index + 1)
    }

    /// Returns the timer, counted from TIM2, that triggers each ADC.
    pub(crate) fn adc_triggers(&self) -> [Option<usize>; 5] {
        std::array::from_fn(|index| {
            let cfgr = Cfgr(self.regs[BASES[index] + reg::CFGR]);
            if !self.adc_cr(index).adstart() || cfgr.exten().to_bits() == 0 || self.is_slave(index) {
                return None;
            }
            crate::adc_control::trigger_timer(index, cfgr.extsel())
        })
    }

    /// Handles a trigger of the regular group (21.4.18).
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
        let adc = &self.adcs[index];
        let latency = adc.latency;
        if at as f64 - adc.end < TRIGGER_MARGIN * adc.period {
            self.report(now, BASES[index] + reg::SMPR, u32::MAX, self.regs[BASES[index] + reg::SMPR], Rule::AdcTriggerMargin)?;
        }
        self.convert(index, at as f64 + latency);
        Ok(())
    }

    /// Plans a conversion whose sampling starts at `from`.
    fn convert(&mut self, index: usize, from: f64) {
        let adc = &mut self.adcs[index];
        let hold = from + adc.sampling[adc.rank];
        (adc.busy, adc.end) = (true, hold + CONVERSION_CYCLES * adc.period);
        let end = first_cycle(adc.end);
        self.agenda.set(Event::AdcHold(index), first_cycle(hold));
        self.agenda.set(Event::AdcEnd(index), end);
    }

    /// Starts a conversion by software.
    pub(crate) fn start_adc(&mut self, now: Now, index: usize) {
        self.convert(index, now.at as f64 + self.adcs[index].latency);
    }

    /// Holds the input: 12 bits, in units of the reference (21.4.32).
    pub(crate) fn adc_hold(&mut self, at: Cycle, index: usize) {
        for member in [Some(index), self.partner(index)].into_iter().flatten() {
            let rank = self.adcs[index].rank;
            let volts = match self.adcs[member].inputs[rank] {
                Input::Pin(pin) => self.wires.volts(at, pin),
                Input::Sensor if self.adc_ccr(member).vsenseen() => sensor_volts(self.wires.celsius(at)),
                Input::Reference if self.adc_ccr(member).vrefen() => reference_volts(),
                _ => 0.0,
            };
            let code = (volts / self.config.vdda * 4096.0 + 0.5).clamp(0.0, 4095.0) as u32;
            self.adcs[member].held = self.adcs[member].stuck.map_or(code, u32::from);
        }
    }

    /// Ends a conversion, stores its result and plans the next one (21.4.26, 21.4.30, 21.4.31).
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
        if self.adcs[index].count < wanted {
            // The next conversion of the sum needs its own trigger, or follows at once.
            if cfgr2.trovs().to_bits() == 0 {
                self.convert(index, end);
            }
            return Ok(());
        }
        let last = self.adcs[index].rank == usize::from(Sqr1(self.regs[base + reg::SQR1]).l());
        for member in [Some(index), partner].into_iter().flatten() {
            let adc = &mut self.adcs[member];
            let mut value = adc.sum >> shift & 0xffff;
            if let Some(late) = &mut adc.late {
                std::mem::swap(late, &mut value);
            }
            (adc.sum, adc.count) = (0, 0);
            self.result(at, member, value, last)?;
        }
        self.adcs[index].rank = if last { 0 } else { self.adcs[index].rank + 1 };
        if !last || cfgr.cont() {
            self.convert(index, end);
        } else if cfgr.exten().to_bits() == 0 {
            self.regs[base + reg::CR] &= !(1 << 2);
        }
        self.ask_dma(at, index, ports)?;
        self.update_adc_line(index, ports);
        Ok(())
    }

    /// Stores a value in ADC_DR, unless the last one was not read (21.4.26).
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
        // Even if the newer value replaces the older one: a sample is lost.
        if unread {
            return self.report(self.now(at), base + reg::ISR, 1 << 4, isr.0, Rule::AdcOverrun);
        }
        Ok(())
    }

    /// Requests DMA for a value: one request for both of a pair, or one each.
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

    /// Transfers a waiting value after a DMA channel was enabled.
    pub(crate) fn serve_adc(&mut self, now: Now, request: u8, ports: &mut Ports) -> Result<(), Fault> {
        for (index, own) in REQUESTS.into_iter().enumerate() {
            if own == request && self.adcs[index].waits {
                self.adcs[index].waits = !self.request(now, request, ports)?;
            }
        }
        Ok(())
    }

    /// Updates the interrupt line, if any interrupt is enabled: most ADCs have none.
    pub(crate) fn update_adc_line(&self, index: usize, ports: &mut Ports) {
        if self.regs[BASES[index] + reg::IER] != 0 {
            self.adc_line(index, ports);
        }
    }

    pub(crate) fn adc_line(&self, index: usize, ports: &mut Ports) {
        const LINES: [u16; 5] = [line::ADC1_2, line::ADC1_2, line::ADC3, line::ADC4, line::ADC5];
        let high = |index: usize| self.regs[BASES[index] + reg::ISR] & self.regs[BASES[index] + reg::IER] != 0;
        ports.interrupts.set(LINES[index], high(index) || (index < 2 && high(1 - index)));
    }
}
