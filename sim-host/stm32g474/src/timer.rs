//! TIM2 to TIM5: up-counters that trigger others, start each other, and count an encoder. RM0440 29.
//!
//! The counter is not stepped: its value and its next trigger follow from when it was started.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::timer::regs::{CcmrOutputGp16, Cr1Gp16, Cr2Gp16, DierGp16, SmcrGp16};
use stm32_metapac::timer::vals::{Mms, Ocm, Sms};

use crate::map::base::{TIM2, TIM3};
use crate::map::{at::timgp32 as at, line};
use crate::part::{Now, Stm32g474};
use crate::time::Event;
use crate::wires::Wires;

/// Bytes from one timer to the next.
const STRIDE: u32 = TIM3 - TIM2;
/// Core cycles from a trigger to the start of the timer that it starts: synchronised, then counted (29.4.22; not measured).
const START_DELAY: Cycle = 3;
const LINES: [u16; 4] = [line::TIM2, line::TIM3, line::TIM4, line::TIM5];
/// DMA requests of the updates of TIM2 to TIM5 (13.3.2).
const UPDATES: [u8; 4] = [60, 65, 71, 76];

/// A timer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Timer {
    running: bool,
    /// The counter's value at `origin`.
    value: u32,
    origin: Cycle,
    /// Core cycles of a count.
    step: u64,
    prescaler: u32,
    /// From when on an update sets the flag.
    flag_from: Cycle,
    flag: bool,
    /// Position of the encoder when the counter was zero.
    zero: i32,
    /// Next rise of TRGO, and next update that somebody waits for.
    trigger: Cycle,
    update: Cycle,
    dead: bool,
    /// Who takes TRGO: timers, DAC channels, ADCs, a bit each.
    pub to_timers: u8,
    pub to_dacs: u8,
    pub to_adcs: u8,
}

impl Timer {
    /// Takes it to its reset state.
    pub fn reset(&mut self) {
        *self = Timer { dead: self.dead, ..Timer::default() };
    }

    /// Counts since `origin`.
    fn counts(&self, at: Cycle) -> u64 {
        at.saturating_sub(self.origin) / self.step.max(1)
    }
}

/// First register of a timer.
fn first(index: usize) -> u32 {
    TIM2 + index as u32 * STRIDE
}

impl<W: Wires> Stm32g474<W> {
    fn timer_cr1(&self, index: usize) -> Cr1Gp16 {
        Cr1Gp16(self.regs[first(index) + at::CR1])
    }

    fn is_encoder(&self, index: usize) -> bool {
        let mode = SmcrGp16(self.regs[first(index) + at::SMCR]).sms();
        matches!(mode, Sms::ENCODER_MODE_1 | Sms::ENCODER_MODE_2 | Sms::ENCODER_MODE_3)
    }

    /// Counts from one update to the next.
    fn period(&self, index: usize) -> u64 {
        u64::from(self.regs[first(index) + at::ARR]) + 1
    }

    /// TIMx_CNT (29.5.12).
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

    /// Whether there was an update since the flag was cleared last.
    fn has_updated(&self, at: Cycle, index: usize) -> bool {
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

    /// The counter goes on from where it is, under changed conditions.
    fn rebase(&mut self, at: Cycle, index: usize) {
        if !self.is_encoder(index) {
            let flag = self.has_updated(at, index);
            let value = self.counter(at, index);
            let timer = &mut self.timers[index];
            (timer.flag, timer.flag_from) = (flag, at);
            // Keeps the part of a count that has passed.
            let part = if timer.running { at.saturating_sub(timer.origin) % timer.step.max(1) } else { 0 };
            (timer.value, timer.origin) = (value, at - part.min(at));
        }
    }

    pub(crate) fn write_timer(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let index = ((address - TIM2) / STRIDE) as usize;
        let offset = address - first(index);
        // One pulse, down and centre-aligned counting, dithering.
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
                // Taken over with the next update (29.5.13); a running one would need a look at each.
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

    /// UG (29.5.6): the counter starts again from zero, and takes over its prescaler.
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

    /// CEN: by a write, or by a trigger.
    fn start_timer(&mut self, now: Now, index: usize, ports: &mut Ports) -> Result<(), Fault> {
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

    /// First time after `at` at which the counter becomes `value`.
    fn next_match(&self, at: Cycle, index: usize, value: u64) -> Cycle {
        let (timer, period) = (&self.timers[index], self.period(index));
        if value >= period {
            return Cycle::MAX;
        }
        // Counts from origin to the first match, then the first one after `at`.
        let to_first = (value + period - u64::from(timer.value) % period) % period;
        let to_first = if to_first == 0 { period } else { to_first };
        let passed = timer.counts(at) + 1;
        let rounds = passed.saturating_sub(to_first).div_ceil(period);
        timer.origin + (to_first + rounds * period) * timer.step
    }

    /// When TRGO next rises (29.5.2, MMS).
    fn next_trigger(&self, at: Cycle, index: usize) -> Cycle {
        let channel = match Cr2Gp16(self.regs[first(index) + at::CR2]).mms() {
            Mms::UPDATE => return self.next_match(at, index, 0),
            Mms::COMPARE_PULSE | Mms::COMPARE_OC1 => 0,
            Mms::COMPARE_OC2 => 1,
            Mms::COMPARE_OC3 => 2,
            Mms::COMPARE_OC4 => 3,
            _ => return Cycle::MAX,
        };
        let compare = u64::from(self.regs[first(index) + at::CCR_0 + 4 * channel]);
        let mode = CcmrOutputGp16(self.regs[first(index) + at::CCMR1 + channel / 2 * 4]).ocm(channel as usize % 2);
        match mode {
            // High below the compare value: rises with the update (29.5.8).
            Ocm::PWM_MODE1 if compare > 0 && compare < self.period(index) => self.next_match(at, index, 0),
            Ocm::PWM_MODE2 if compare > 0 => self.next_match(at, index, compare),
            _ => Cycle::MAX,
        }
    }

    /// Plans the next event of a timer: only if somebody waits for it.
    fn plan_timer(&mut self, at: Cycle, index: usize) {
        let timer = &self.timers[index];
        let (mut trigger, mut update) = (Cycle::MAX, Cycle::MAX);
        if timer.running && !self.is_encoder(index) {
            if timer.to_timers | timer.to_dacs | timer.to_adcs != 0 {
                trigger = self.next_trigger(at, index);
            }
            if self.regs[first(index) + at::DIER] & (1 | 1 << 8) != 0 {
                update = self.next_match(at, index, 0);
            }
        }
        (self.timers[index].trigger, self.timers[index].update) = (trigger, update);
        self.agenda.set(Event::Timer(index), trigger.min(update));
    }

    pub(crate) fn timer_due(&mut self, at: Cycle, index: usize, ports: &mut Ports) -> Result<(), Fault> {
        let (triggers, updates) = (self.timers[index].trigger <= at, self.timers[index].update <= at);
        self.plan_timer(at, index);
        if triggers {
            self.trigger(at, index, ports)?;
        }
        if updates {
            self.timer_line(at, index, ports);
            if DierGp16(self.regs[first(index) + at::DIER]).ude() {
                self.request(self.now(at), UPDATES[index], ports)?;
            }
        }
        Ok(())
    }

    /// TRGO rises.
    fn trigger(&mut self, at: Cycle, index: usize, ports: &mut Ports) -> Result<(), Fault> {
        let timer = &self.timers[index];
        let (timers, dacs, adcs) = (timer.to_timers, timer.to_dacs, timer.to_adcs);
        for slave in (0..4).filter(|slave| timers >> slave & 1 != 0) {
            if !self.timer_cr1(slave).cen() {
                self.regs[first(slave) + at::SR] |= 1 << 6;
                self.start_timer(self.now(at + START_DELAY), slave, ports)?;
            }
        }
        if dacs != 0 {
            self.trigger_dacs(at, index, dacs, ports)?;
        }
        for adc in (0..5).filter(|adc| adcs >> adc & 1 != 0) {
            self.trigger_adc(at, adc, ports)?;
        }
        Ok(())
    }

    fn timer_line(&mut self, at: Cycle, index: usize, ports: &mut Ports) {
        let enabled = self.regs[first(index) + at::DIER] & 1 != 0;
        ports.interrupts.set(LINES[index], enabled && self.has_updated(at, index));
    }

    /// Finds out who takes whose trigger: after each change of what selects one.
    pub(crate) fn rewire(&mut self) {
        let dacs = self.dac_triggers();
        let adcs = self.adc_triggers();
        let slaves: [Option<usize>; 4] = std::array::from_fn(|index| {
            let smcr = SmcrGp16(self.regs[first(index) + at::SMCR]);
            // ITR0 is TIM1, ITR1 to ITR4 are TIM2 to TIM5 (29.4, table of internal triggers): TS 1 to 3, and 8.
            let source = match smcr.ts().to_bits() {
                ts @ 1..=3 => usize::from(ts) - 1,
                8 => 3,
                _ => return None,
            };
            (smcr.sms() == Sms::TRIGGER_MODE).then_some(source)
        });
        for (index, timer) in self.timers.iter_mut().enumerate() {
            let bits = |list: &[Option<usize>]| {
                (0..list.len()).filter(|to| list[*to] == Some(index)).fold(0, |bits, to| bits | 1_u8 << to)
            };
            (timer.to_timers, timer.to_dacs, timer.to_adcs) = (bits(&slaves), bits(&dacs), bits(&adcs));
        }
        for index in 0..4 {
            let at = self.last;
            self.plan_timer(at, index);
        }
    }

    /// The bus clock has changed: counters go on at their new pace.
    pub(crate) fn retime_timers(&mut self, at: Cycle) {
        for index in 0..4 {
            self.rebase(at, index);
            self.timers[index].step = self.timer_cycle() * (u64::from(self.timers[index].prescaler) + 1);
            self.plan_timer(at, index);
        }
    }

    /// A timer stands, and no trigger of it comes any more.
    pub(crate) fn halt_timer(&mut self, at: Cycle, index: usize) {
        self.rebase(at, index);
        let timer = &mut self.timers[index];
        (timer.dead, timer.running) = (true, false);
        self.plan_timer(at, index);
    }

    /// Forgets the state of a timer that RCC resets.
    pub(crate) fn reset_timer(&mut self, at: Cycle, base: u32) {
        let index = ((base - TIM2) / STRIDE) as usize;
        self.timers[index].reset();
        self.rewire();
        self.plan_timer(at, index);
    }
}
