//! TIM2 to TIM5: up-counters that trigger peripherals, start each other, and count an encoder.
//! RM0440 29.
//!
//! The counter is not stepped: its value and its next trigger follow from its start.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::timer::regs::{Cr1Gp16, Cr2Gp16, SmcrGp16};
use stm32_metapac::timer::vals::{Mms, Sms};

use crate::map::at::timgp32 as at;
use crate::map::base::{TIM2, TIM3};
use crate::part::{Now, Stm32g474};
use crate::wires::Wires;

/// Bytes from one timer to the next.
const STRIDE: u32 = TIM3 - TIM2;
/// State of a timer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Timer {
    pub running: bool,
    /// Value of the counter at `origin`.
    pub value: u32,
    pub origin: Cycle,
    /// Core cycles per count.
    pub step: u64,
    prescaler: u32,
    /// Cycle from which an update sets the flag.
    flag_from: Cycle,
    flag: bool,
    /// Position of the encoder at which the counter is zero.
    zero: i32,
    /// Cycle of the next rise of TRGO.
    pub trigger: Cycle,
    /// Cycle of the next update that an output or an interrupt needs.
    pub update: Cycle,
    dead: bool,
    /// Number of next triggers that are lost.
    pub lost: u32,
    /// Timers that TRGO triggers, one bit each.
    pub to_timers: u8,
    /// DAC channels that TRGO triggers, one bit each.
    pub to_dacs: u8,
    /// ADCs that TRGO triggers, one bit each.
    pub to_adcs: u8,
}

impl Timer {
    /// Resets the state; a defect stays.
    pub fn reset(&mut self) {
        *self = Timer { dead: self.dead, ..Timer::default() };
    }

    /// Returns the counts since `origin`.
    pub fn counts(&self, at: Cycle) -> u64 {
        at.saturating_sub(self.origin) / self.step.max(1)
    }
}

/// Returns the first register of a timer.
pub(crate) fn first(index: usize) -> u32 {
    TIM2 + index as u32 * STRIDE
}

impl<W: Wires> Stm32g474<W> {
    pub(crate) fn timer_cr1(&self, index: usize) -> Cr1Gp16 {
        Cr1Gp16(self.regs[first(index) + at::CR1])
    }

    pub(crate) fn is_encoder(&self, index: usize) -> bool {
        let mode = SmcrGp16(self.regs[first(index) + at::SMCR]).sms();
        matches!(mode, Sms::ENCODER_MODE_1 | Sms::ENCODER_MODE_2 | Sms::ENCODER_MODE_3)
    }

    /// Returns the counts from one update to the next.
    pub(crate) fn period(&self, index: usize) -> u64 {
        u64::from(self.regs[first(index) + at::ARR]) + 1
    }

    /// Returns TIMx_CNT (29.5.12).
    fn counter(&mut self, at: Cycle, index: usize) -> u32 {
        if self.is_encoder(index) {
            let position = if self.timer_cr1(index).cen() { self.wires.encoder(at) } else { self.timers[index].zero };
            let edges = position.wrapping_sub(self.timers[index].zero);
            // Modes 1 and 2 count the edges of one channel only.
            let mode = SmcrGp16(self.regs[first(index) + at::SMCR]).sms();
            return if mode == Sms::ENCODER_MODE_3 { edges as u32 } else { (edges / 2) as u32 };
        }
        let timer = &self.timers[index];
        if !timer.running {
            return timer.value;
        }
        ((u64::from(timer.value) + timer.counts(at)) % self.period(index)) as u32
    }

    /// Returns `true` if there was an update since the flag was last cleared.
    pub(crate) fn has_updated(&self, at: Cycle, index: usize) -> bool {
        let timer = &self.timers[index];
        if timer.flag || !timer.running || self.is_encoder(index) {
            return timer.flag;
        }
        let updates = |at| (u64::from(timer.value) + timer.counts(at)) / self.period(index);
        updates(at) > updates(timer.flag_from.max(timer.origin))
    }

    pub(crate) fn read_timer(&mut self, now: Now, address: u32) -> u32 {
        let index = ((address - TIM2) / STRIDE) as usize;
        match address - first(index) {
            at::CNT => self.counter(now.at, index),
            at::SR => self.regs[address] | u32::from(self.has_updated(now.at, index)),
            at::EGR => 0,
            _ => self.regs[address],
        }
    }

    /// Continues the counter from its value, under changed conditions.
    fn rebase(&mut self, at: Cycle, index: usize) {
        if !self.is_encoder(index) {
            let flag = self.has_updated(at, index);
            let value = self.counter(at, index);
            let timer = &mut self.timers[index];
            (timer.flag, timer.flag_from) = (flag, at);
            // Keeps the elapsed part of a count.
            let part = if timer.running { at.saturating_sub(timer.origin) % timer.step.max(1) } else { 0 };
            (timer.value, timer.origin) = (value, at - part.min(at));
        }
    }

    pub(crate) fn write_timer(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let index = ((address - TIM2) / STRIDE) as usize;
        let offset = address - first(index);
        // Not modelled: one pulse, down and centre-aligned counting, dithering.
        match offset {
            at::CR1 => self.refuse_bits(now, address, value, 0x1a | 0x60 | 1 << 11 | 1 << 12)?,
            at::DIER => self.refuse_bits(now, address, value, !(1 | 1 << 8))?,
            at::SMCR => self.check_slave(now, address, SmcrGp16(value))?,
            at::CR2 => self.refuse_bits(now, address, value, 1 << 3 | 1 << 7)?,
            at::ECR | at::DCR | at::DMAR | at::AF1 | at::AF2 => return self.refuse(now, address, "the register"),
            _ => {}
        }
        self.rebase(now.at, index);
        let was = self.timer_cr1(index).cen();
        match offset {
            at::SR => {
                let timer = &mut self.timers[index];
                timer.flag &= value & 1 != 0;
                timer.flag_from = now.at;
                self.regs[address] &= value & !1;
            }
            at::CNT => {
                if self.is_encoder(index) {
                    self.timers[index].zero = self.wires.encoder(now.at).wrapping_sub(value as i32);
                } else {
                    (self.timers[index].value, self.timers[index].origin) = (value, now.at);
                }
            }
            at::EGR => {
                self.refuse_bits(now, address, value, !1)?;
                self.generate(now, index, ports)?;
            }
            at::PSC => {
                // Loaded at the next update (29.5.13), which is not modelled for a running timer.
                if self.timers[index].running {
                    return self.refuse(now, address, "a change while the counter runs");
                }
                self.regs[address] = value;
            }
            _ => self.regs[address] = value,
        }
        match offset {
            at::CR1 => {
                let cen = Cr1Gp16(value).cen();
                if cen && !was {
                    self.start_timer(now, index, ports)?;
                } else if !cen {
                    self.timers[index].running = false;
                }
            }
            at::SMCR if self.is_encoder(index) => self.timers[index].zero = self.wires.encoder(now.at),
            at::SMCR | at::CR2 => self.rewire(),
            _ => {}
        }
        self.plan_timer(now.at, index);
        self.timer_line(now.at, index, ports);
        Ok(())
    }

    fn check_slave(&mut self, now: Now, address: u32, smcr: SmcrGp16) -> Result<(), Fault> {
        self.refuse_bits(now, address, smcr.0, 0x0300_ff80)?;
        match smcr.sms() {
            Sms::DISABLED | Sms::TRIGGER_MODE | Sms::ENCODER_MODE_1 | Sms::ENCODER_MODE_2 | Sms::ENCODER_MODE_3 => Ok(()),
            _ => self.refuse(now, address, "the slave mode"),
        }
    }

    /// Handles UG (29.5.6): the counter restarts from zero, and loads its prescaler.
    fn generate(&mut self, now: Now, index: usize, ports: &mut Ports) -> Result<(), Fault> {
        self.timers[index].prescaler = self.regs[first(index) + at::PSC];
        self.timers[index].step = self.timer_cycle() * (u64::from(self.timers[index].prescaler) + 1);
        (self.timers[index].value, self.timers[index].origin) = (0, now.at);
        if self.timer_cr1(index).urs().to_bits() == 0 {
            self.timers[index].flag = true;
        }
        let mode = Cr2Gp16(self.regs[first(index) + at::CR2]).mms();
        if matches!(mode, Mms::RESET | Mms::UPDATE) {
            self.trigger(now.at, index, ports)?;
        }
        Ok(())
    }

    /// Sets CEN, after a write or by a trigger.
    pub(crate) fn start_timer(&mut self, now: Now, index: usize, ports: &mut Ports) -> Result<(), Fault> {
        self.regs[first(index) + at::CR1] |= 1;
        if self.is_encoder(index) {
            return Ok(());
        }
        if self.regs[first(index) + at::PSC] != self.timers[index].prescaler {
            return self.refuse(now, first(index) + at::PSC, "a prescaler without EGR.UG");
        }
        let step = self.timer_cycle() * (u64::from(self.timers[index].prescaler) + 1);
        let timer = &mut self.timers[index];
        (timer.running, timer.origin, timer.step) = (!timer.dead, now.at, step);
        timer.flag_from = now.at;
        self.plan_timer(now.at, index);
        if Cr2Gp16(self.regs[first(index) + at::CR2]).mms() == Mms::ENABLE {
            self.trigger(now.at, index, ports)?;
        }
        Ok(())
    }

    /// Continues the counters at their new rate after a change of the bus clock.
    pub(crate) fn retime_timers(&mut self, at: Cycle) {
        for index in 0..4 {
            self.rebase(at, index);
            self.timers[index].step = self.timer_cycle() * (u64::from(self.timers[index].prescaler) + 1);
            self.plan_timer(at, index);
        }
    }

    /// Stops a timer and its triggers, as a defect.
    pub(crate) fn halt_timer(&mut self, at: Cycle, index: usize) {
        self.rebase(at, index);
        let timer = &mut self.timers[index];
        (timer.dead, timer.running) = (true, false);
        self.plan_timer(at, index);
    }

    /// Resets the state of a timer that RCC resets.
    pub(crate) fn reset_timer(&mut self, at: Cycle, base: u32) {
        let index = ((base - TIM2) / STRIDE) as usize;
        self.timers[index].reset();
        self.rewire();
        self.plan_timer(at, index);
    }
}
