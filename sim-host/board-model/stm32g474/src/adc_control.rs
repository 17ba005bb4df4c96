//! Registers of the ADCs and their required order of writes. RM0440 21.4.6 to 21.4.10, 21.7, 21.8.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::adc::regs::{Cfgr, Cr};
use stm32_metapac::adccommon::regs::Ccr;

use crate::adc::{BASES, SIMULTANEOUS, common_of};
use crate::finding::Rule;
use crate::map::TRIGGERS;
use crate::map::at::{adc as reg, adccommon as common};
use crate::map::base::{ADC1, ADC2, ADC345_COMMON};
use crate::part::{Now, Stm32g474};
use crate::time::{Event, US};
use crate::wires::Wires;

/// Start-up time of the regulator (DS12288, T_ADCVREG_STUP), ps.
const REGULATOR_START_UP: u64 = 20 * US;
/// Duration of a calibration (DS12288, t_CAL), ADC cycles.
const CALIBRATION_CYCLES: f64 = 116.0;
/// Time from enable to ready (DS12288, t_STAB), ADC cycles.
const ENABLE_CYCLES: f64 = 15.0;

/// Returns the timer of an external trigger's number (21.4.18, tables): 0 for TIM2 to 3 for TIM5.
pub(crate) fn trigger_timer(index: usize, number: u8) -> Option<usize> {
    let adc = if index < 2 { "ADC1" } else { "ADC3" };
    let signal = format!("ADC_EXT_TRG{number}");
    let (.., source) = TRIGGERS.iter().find(|(peripheral, name, _)| *peripheral == adc && *name == signal)?;
    ["TIM2_TRGO", "TIM3_TRGO", "TIM4_TRGO", "TIM5_TRGO"].iter().position(|timer| timer == source)
}

/// Returns the ADC of a register.
fn index_of(address: u32) -> usize {
    match address {
        at if at >= ADC345_COMMON => 4,
        at if at >= BASES[4] => 4,
        at => BASES.iter().rposition(|base| at >= *base).unwrap_or(0),
    }
}

impl<W: Wires> Stm32g474<W> {
    pub(crate) fn read_adc(&mut self, _now: Now, address: u32, ports: &mut Ports) -> u32 {
        let index = index_of(address);
        if address - BASES[index] != reg::DR {
            return self.regs[address];
        }
        self.take_result(index, ports);
        self.adcs[index].data
    }

    /// Clears EOC, as a read of the data does (21.7.16).
    fn take_result(&mut self, index: usize, ports: &mut Ports) {
        self.regs[BASES[index] + reg::ISR] &= !4;
        self.update_adc_line(index, ports);
    }

    pub(crate) fn read_adc_common(&mut self, _now: Now, address: u32, ports: &mut Ports) -> u32 {
        let master = if address >= ADC345_COMMON { 2 } else { 0 };
        match address - common_of(master) {
            // CDR (21.8.3) contains both values; a read clears both EOC flags.
            common::CDR => {
                self.take_result(master, ports);
                self.take_result(master + 1, ports);
                self.adcs[master].data | self.adcs[master + 1].data << 16
            }
            common::CSR => self.regs[BASES[master] + reg::ISR] | self.regs[BASES[master + 1] + reg::ISR] << 16,
            _ => self.regs[address],
        }
    }

    pub(crate) fn write_adc_common(&mut self, now: Now, address: u32, value: u32) -> Result<(), Fault> {
        let group: &[usize] = if address >= ADC345_COMMON { &[2, 3, 4] } else { &[0, 1] };
        if group.iter().any(|index| self.adc_cr(*index).0 & 0x8000_003f != 0) && value != self.regs[address] {
            self.report(now, address, value ^ self.regs[address], value, Rule::AdcCommonEnabled)?;
        }
        let ccr = Ccr(value);
        if !matches!(ccr.dual().to_bits(), 0 | SIMULTANEOUS) || matches!(ccr.mdma().to_bits(), 1 | 3) {
            return self.refuse(now, address, "a dual mode that is not regular simultaneous in words of 2 x 16 bits");
        }
        self.refuse_bits(now, address, value, 1 << 24)?;
        self.regs[address] = value;
        self.rewire();
        Ok(())
    }

    pub(crate) fn write_adc(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let index = index_of(address);
        let base = BASES[index];
        let old = self.regs[address];
        let offset = address - base;
        let frozen =
            matches!(offset, reg::CFGR | reg::CFGR2 | reg::SMPR | reg::SMPR2 | reg::SQR1 | reg::SQR2 | reg::SQR3 | reg::SQR4);
        if frozen && self.adc_cr(index).adstart() && value != old {
            return self.report(now, address, value ^ old, value, Rule::AdcStarted);
        }
        match offset {
            reg::ISR => {
                self.regs[address] &= !value;
                self.adc_line(index, ports);
                return Ok(());
            }
            reg::IER => {
                self.refuse_bits(now, address, value, !0x1f)?;
                self.regs[address] = value;
                self.adc_line(index, ports);
                return Ok(());
            }
            reg::CR => return self.write_adc_cr(now, index, Cr(value)),
            reg::CFGR => {
                let cfgr = Cfgr(value);
                // Other resolutions and alignments, delays, discontinuous groups, watchdogs.
                self.refuse_bits(now, address, value, 3 << 3 | 3 << 14 | 0x1f << 16 | 0xf << 21 | 1 << 25)?;
                let known = trigger_timer(index, cfgr.extsel()).is_some() && cfgr.exten().to_bits() == 1;
                if cfgr.exten().to_bits() != 0 && !known {
                    return self.refuse(now, address, "a trigger that is not a rising TRGO of TIM2 to TIM5");
                }
            }
            reg::CFGR2 => self.refuse_bits(now, address, value, 2 | 1 << 10 | 0xf << 16 | 7 << 25)?,
            reg::SMPR | reg::SMPR2 | reg::SQR1 | reg::SQR2 | reg::SQR3 | reg::SQR4 => {}
            _ => {
                // Injected groups, watchdogs, offsets, differential inputs, gains.
                if value != old {
                    return self.refuse(now, address, "the register");
                }
            }
        }
        self.regs[address] = value;
        self.rewire();
        Ok(())
    }

    /// Writes ADC_CR (21.7.3), whose bits are mostly set by software and cleared by the ADC.
    fn write_adc_cr(&mut self, now: Now, index: usize, new: Cr) -> Result<(), Fault> {
        let address = BASES[index] + reg::CR;
        let old = self.adc_cr(index);
        let time = self.time.ps(now.at);
        self.refuse_bits(now, address, new.0, 1 << 3 | 1 << 5 | 1 << 30)?;
        let mut cr = old;
        cr.set_deeppwd(new.deeppwd());
        cr.set_advregen(new.advregen());
        if new.advregen() && new.deeppwd() {
            self.report(now, address, 3 << 28, new.0, Rule::AdcPower)?;
        }
        if new.deeppwd() || !new.advregen() {
            self.adcs[index].regulated = None;
        } else if self.adcs[index].regulated.is_none() {
            self.adcs[index].regulated = Some(time + REGULATOR_START_UP);
        }
        if new.deeppwd() {
            self.adcs[index].calibrated = None;
        }
        let started_up = self.adcs[index].regulated.is_some_and(|from| time >= from);
        let period = self.adc_period(index);
        self.regs[address] = cr.0;
        if new.adcal() && !old.adcal() {
            if !started_up {
                self.report(now, address, 1 << 31, new.0, Rule::AdcRegulator)?;
            }
            if old.aden() {
                return self.report(now, address, 1 << 31, new.0, Rule::AdcCalibration);
            }
            self.regs[address] |= 1 << 31;
            self.later(now, index, period, CALIBRATION_CYCLES)?;
        }
        if new.aden() && !old.aden() {
            if !started_up {
                self.report(now, address, 1, new.0, Rule::AdcRegulator)?;
            }
            let settled = |at: Cycle| now.at as f64 >= at as f64 + 4.0 * period.unwrap_or(0.0);
            if old.adcal() || !self.adcs[index].calibrated.is_some_and(settled) {
                self.report(now, address, 1, new.0, Rule::AdcCalibration)?;
            }
            self.regs[address] |= 1;
            self.later(now, index, period, ENABLE_CYCLES)?;
        }
        if new.adstp().to_bits() != 0 {
            self.regs[address] &= !(1 << 2);
            self.stop_adc(index);
        }
        if new.addis() && old.aden() {
            self.stop_adc(index);
            self.regs[address] &= !5;
            self.regs[BASES[index] + reg::ISR] &= !1;
        }
        if new.adstart() && !old.adstart() {
            self.start_group(now, index, new)?;
        }
        self.rewire();
        Ok(())
    }

    fn stop_adc(&mut self, index: usize) {
        self.adcs[index].stop();
        self.adcs[index].waits = false;
        self.agenda.clear(Event::AdcHold(index));
        self.agenda.clear(Event::AdcEnd(index));
    }

    /// Plans the end of a calibration or enable, `cycles` ADC cycles later.
    fn later(&mut self, now: Now, index: usize, period: Option<f64>, cycles: f64) -> Result<(), Fault> {
        let Some(period) = period else { return self.refuse(now, BASES[index] + reg::CR, "an ADC without a clock") };
        self.agenda.set(Event::AdcReady(index), now.at + (cycles * period).ceil() as Cycle);
        Ok(())
    }

    pub(crate) fn adc_ready(&mut self, at: Cycle, index: usize, ports: &mut Ports) {
        let cr = self.adc_cr(index);
        if cr.adcal() {
            self.regs[BASES[index] + reg::CR] &= !(1 << 31);
            self.adcs[index].calibrated = Some(at);
        } else if cr.aden() {
            self.regs[BASES[index] + reg::ISR] |= 1;
            self.adc_line(index, ports);
        }
    }

    /// Starts the group (ADSTART): at once, or with the first trigger.
    fn start_group(&mut self, now: Now, index: usize, new: Cr) -> Result<(), Fault> {
        let address = BASES[index] + reg::CR;
        for member in [Some(index), self.partner(index)].into_iter().flatten() {
            // Software may have cleared ADRDY, so the event decides.
            let ready = self.adc_cr(member).aden() && self.agenda.get(Event::AdcReady(member)) == Cycle::MAX;
            if !ready {
                return self.report(now, address, 1 << 2, new.0, Rule::AdcNotReady);
            }
            self.prepare_adc(now, member)?;
        }
        let pair = self.partner(index).filter(|_| self.adc_ccr(index).mdma().to_bits() != 0);
        let keeps_fifo = |index: usize| Cfgr(self.regs[BASES[index] + reg::CFGR]).ovrmod().to_bits() == 0;
        if let Some(slave) = pair
            && let Some(member) = [index, slave].into_iter().find(|&member| keeps_fifo(member))
        {
            let cfgr = self.regs[BASES[member] + reg::CFGR];
            self.report(now, BASES[member] + reg::CFGR, 1 << 12, cfgr, Rule::AdcDualFifo)?;
        }
        self.regs[address] |= 1 << 2;
        if Cfgr(self.regs[BASES[index] + reg::CFGR]).exten().to_bits() == 0 {
            self.start_adc(now, index)
        }
        Ok(())
    }

    /// Resets the state of the ADCs that RCC resets: ADC1 and 2, or ADC3 to 5 together.
    pub(crate) fn reset_adc(&mut self, base: u32) {
        let group: &[usize] = if (ADC1..=ADC2).contains(&base) || base == common_of(0) { &[0, 1] } else { &[2, 3, 4] };
        for index in group {
            self.stop_adc(*index);
            self.adcs[*index].reset();
            self.agenda.clear(Event::AdcReady(*index));
        }
    }
}
