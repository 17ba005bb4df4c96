//! Counter of TIM1 in one-pulse mode: it counts up once, and stops at zero. RM0440 28.3.3, 28.3.12,
//! 28.3.22.
//!
//! The counter is not stepped: its value, the next edge of a channel and the end follow from its
//! start. Repeated counting, counting down, and preload registers are refused.
//!
//! ```text
//! CNT = value + floor((t - origin) / step),  step = timer cycle * (PSC + 1);   the end is at CNT = ARR + 1: CNT = 0, CEN = 0, UIF = 1
//! PWM mode 1: high while CNT < CCR;  PWM mode 2: high while CNT >= CCR
//! ```

use cortex_m4::{Cycle, Fault, Ports};

use crate::finding::Rule;
use crate::map::at::timadv as reg;
use crate::map::base::TIM1;
use crate::map::line;
use crate::part::{Now, Stm32g474};
use crate::time::Event;
use crate::wires::Wires;

/// TIM1_CR1 (28.6.1).
pub(crate) const CEN: u32 = 1;
const URS: u32 = 1 << 2;
const OPM: u32 = 1 << 3;
const CKD: u32 = 3 << 8;
/// Flag of TIM1_SR: update (28.6.5).
const UIF: u32 = 1;
/// Flag of TIM1_SR: compare of channel 1; those of the other channels follow.
const CC1IF: u32 = 1 << 1;
/// Timer cycles from CEN to the first counting cycle (28.3.1).
const START_DELAY: Cycle = 1;

/// State of the counter besides its registers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Counter {
    running: bool,
    /// Value at `origin`.
    value: u32,
    origin: Cycle,
    /// Core cycles per count.
    step: u64,
    /// PSC of the last update.
    prescaler: u32,
    /// Counter value up to which the compare flags are set.
    seen: u32,
}

impl Counter {
    fn at(&self, at: Cycle) -> u32 {
        let counts = if self.running { at.saturating_sub(self.origin) / self.step.max(1) } else { 0 };
        self.value + counts as u32
    }

    /// Returns the cycle at which it reaches a future value.
    fn reaches(&self, value: u32) -> Cycle {
        self.origin + u64::from(value.saturating_sub(self.value)) * self.step
    }
}

impl<W: Wires> Stm32g474<W> {
    /// Returns the reference level of a channel, counted from zero, by its mode and the counter
    /// (28.6.8).
    pub(crate) fn tim1_reference(&self, at: Cycle, channel: usize) -> bool {
        let below = self.tim1.counter.at(at) < self.compare_value(channel);
        match self.tim1_mode(channel) {
            5 => true,
            6 => below,
            7 => !below,
            _ => false,
        }
    }

    /// Returns CCMR.OCxM of a channel (28.6.8).
    fn tim1_mode(&self, channel: usize) -> u32 {
        let ccmr = self.regs[TIM1 + if channel < 2 { reg::CCMR1 } else { reg::CCMR2 }];
        ccmr >> (8 * (channel % 2) + 4) & 7
    }

    fn compare_value(&self, channel: usize) -> u32 {
        self.regs[TIM1 + reg::CCR_0 + 4 * channel as u32] & 0xffff
    }

    fn tim1_step(&self) -> u64 {
        // Twice the bus clock if that is divided (7.2.13).
        let cycle = match self.apb(2) {
            1 => 1,
            divided => divided / 2,
        };
        cycle * (u64::from(self.tim1.counter.prescaler) + 1)
    }

    /// Returns TIM1_CNT (28.6.12).
    pub(crate) fn tim1_count(&self, at: Cycle) -> u32 {
        self.tim1.counter.at(at)
    }

    /// Sets the flags of the compare values that the counter has reached (28.6.5).
    pub(crate) fn see_compares(&mut self, at: Cycle) {
        let (seen, count) = (self.tim1.counter.seen, self.tim1.counter.at(at));
        for channel in 0..4 {
            if (seen + 1..=count).contains(&self.compare_value(channel)) {
                self.regs[TIM1 + reg::SR] |= CC1IF << channel;
            }
        }
        self.tim1.counter.seen = count;
    }

    /// Checks a write to a register of the counter.
    pub(crate) fn check_counter(&mut self, now: Now, address: u32, value: u32) -> Result<(), Fault> {
        let counts = self.regs[TIM1 + reg::CR1] & CEN != 0;
        match address - TIM1 {
            reg::CR1 => {
                self.refuse_bits(now, address, value, !(CEN | URS | OPM | CKD))?;
                if value & CEN == 0 {
                    return Ok(());
                }
                if value & OPM == 0 {
                    return self.refuse(now, address, "a counter without one-pulse mode");
                }
                if self.regs[TIM1 + reg::PSC] != self.tim1.counter.prescaler {
                    return self.refuse(now, TIM1 + reg::PSC, "a prescaler without EGR.UG");
                }
                if self.regs[TIM1 + reg::ARR] & 0xffff == 0 {
                    self.report(now, address, CEN, value, Rule::TimBlocked)?;
                }
                Ok(())
            }
            reg::CNT if value & 0xffff > self.regs[TIM1 + reg::ARR] & 0xffff => self.refuse(now, address, "a count beyond ARR"),
            reg::ARR if value & 0xffff < self.tim1_count(now.at) => self.refuse(now, address, "an end before the count"),
            reg::ARR => self.refuse_bits(now, address, value, !0xffff),
            reg::EGR if counts && value & 1 != 0 => self.refuse(now, address, "UG while the counter runs"),
            reg::PSC if counts => self.refuse(now, address, "a change while the counter runs"),
            reg::RCR => self.refuse_bits(now, address, value, u32::MAX),
            _ => Ok(()),
        }
    }

    /// Continues the counter from its value, or stops it, under changed conditions.
    pub(crate) fn rebase_counter(&mut self, at: Cycle) {
        self.see_compares(at);
        let stands = self.tim1_is_halted() || self.regs[TIM1 + reg::ARR] & 0xffff == 0;
        let runs = self.regs[TIM1 + reg::CR1] & CEN != 0 && !stands;
        let step = self.tim1_step();
        let counter = &mut self.tim1.counter;
        if runs && counter.running && step == counter.step {
            return;
        }
        let value = counter.at(at);
        let origin = if runs && !counter.running { at + START_DELAY * step } else { at };
        *counter = Counter { running: runs, value, origin, step, seen: value, ..*counter };
    }

    /// Writes CNT.
    pub(crate) fn set_count(&mut self, at: Cycle, value: u32) {
        let counter = &mut self.tim1.counter;
        (counter.value, counter.seen) = (value & 0xffff, value & 0xffff);
        counter.origin = counter.origin.max(at);
    }

    /// Updates at the end of the count or by UG: the counter becomes zero, the prescaler is loaded,
    /// and AOE sets MOE if no break is active (28.6.20).
    pub(crate) fn update_counter(&mut self, at: Cycle, by_software: bool) {
        let prescaler = self.regs[TIM1 + reg::PSC] & 0xffff;
        self.tim1.counter = Counter { origin: at, prescaler, ..Counter::default() };
        self.regs[TIM1 + reg::CR1] &= !CEN;
        if !by_software || self.regs[TIM1 + reg::CR1] & URS == 0 {
            self.regs[TIM1 + reg::SR] |= UIF;
        }
        for channel in 0..4 {
            if self.compare_value(channel) == 0 {
                self.regs[TIM1 + reg::SR] |= CC1IF << channel;
            }
        }
        self.enable_by_update();
    }

    /// Plans the next edge of a channel, or the end.
    pub(crate) fn plan_counter(&mut self, at: Cycle) {
        let counter = &self.tim1.counter;
        if !counter.running {
            self.agenda.clear(Event::Tim1);
            return;
        }
        let (count, end) = (counter.at(at), (self.regs[TIM1 + reg::ARR] & 0xffff) + 1);
        let edge = (0..4)
            .filter(|channel| self.tim1_mode(*channel) >= 6)
            .map(|channel| self.compare_value(channel))
            .filter(|compare| (count + 1..end).contains(compare))
            .min();
        let next = counter.reaches(edge.unwrap_or(end));
        self.agenda.set(Event::Tim1, next);
    }

    /// Handles an edge of a channel or the end of the count.
    pub(crate) fn tim1_due(&mut self, at: Cycle, ports: &mut Ports) {
        self.see_compares(at);
        if self.tim1.counter.at(at) > self.regs[TIM1 + reg::ARR] & 0xffff {
            self.update_counter(at, false);
        }
        self.plan_counter(at);
        self.update_breaks(at, ports);
    }

    /// Updates the counter after a change of the core clock, or a halt by a debugger.
    pub(crate) fn retime_counter(&mut self, at: Cycle) {
        self.rebase_counter(at);
        self.plan_counter(at);
    }

    pub(crate) fn counter_line(&self, ports: &mut Ports) {
        let asks = self.regs[TIM1 + reg::SR] & self.regs[TIM1 + reg::DIER] & UIF != 0;
        ports.interrupts.set(line::TIM1_UP_TIM16, asks);
    }
}
