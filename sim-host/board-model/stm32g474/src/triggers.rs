//! Triggers of the timers and their receivers. RM0440 29.

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::timer::regs::{CcmrOutputGp16, Cr2Gp16, DierGp16, SmcrGp16};
use stm32_metapac::timer::vals::{Mms, Ocm, Sms};

use crate::map::{at::timgp32 as at, line};
use crate::part::Stm32g474;
use crate::time::Event;
use crate::timer::first;
use crate::wires::Wires;

/// Core cycles from a trigger to the start of the triggered timer: synchronisation, then the first
/// count (29.4.22; not measured).
const START_DELAY: Cycle = 3;
const LINES: [u16; 4] = [line::TIM2, line::TIM3, line::TIM4, line::TIM5];
/// DMA requests of the updates of TIM2 to TIM5 (13.3.2).
const UPDATES: [u8; 4] = [60, 65, 71, 76];

impl<W: Wires> Stm32g474<W> {
    /// Returns the first cycle after `at` at which the counter becomes `value`.
    fn next_match(&self, at: Cycle, index: usize, value: u64) -> Cycle {
        let (timer, period) = (&self.timers[index], self.period(index));
        if value >= period {
            return Cycle::MAX;
        }
        // Counts from origin to the first match, and then to the first one after `at`.
        let to_first = (value + period - u64::from(timer.value) % period) % period;
        let to_first = if to_first == 0 { period } else { to_first };
        let passed = timer.counts(at) + 1;
        let rounds = passed.saturating_sub(to_first).div_ceil(period);
        timer.origin + (to_first + rounds * period) * timer.step
    }

    /// Returns the cycle of the next rise of TRGO (29.5.2, MMS).
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

    /// Plans the next event of a timer, if an output or an interrupt needs it.
    pub(crate) fn plan_timer(&mut self, at: Cycle, index: usize) {
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
        // The next event of each kind is a period later; a write before that plans it again.
        let period = self.period(index) * self.timers[index].step;
        let timer = &mut self.timers[index];
        if triggers {
            timer.trigger = at + period;
        }
        if updates {
            timer.update = at + period;
        }
        let next = timer.trigger.min(timer.update);
        self.agenda.set(Event::Timer(index), next);
        let lost = triggers && self.timers[index].lost > 0;
        self.timers[index].lost -= u32::from(lost);
        if triggers && !lost {
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

    /// Distributes a rise of TRGO.
    pub(crate) fn trigger(&mut self, at: Cycle, index: usize, ports: &mut Ports) -> Result<(), Fault> {
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

    pub(crate) fn timer_line(&mut self, at: Cycle, index: usize, ports: &mut Ports) {
        let enabled = self.regs[first(index) + at::DIER] & 1 != 0;
        ports.interrupts.set(LINES[index], enabled && self.has_updated(at, index));
    }

    /// Finds the receivers of each trigger, after a change of any selection.
    pub(crate) fn rewire(&mut self) {
        let dacs = self.dac_triggers();
        let adcs = self.adc_triggers();
        let slaves: [Option<usize>; 4] = std::array::from_fn(|index| {
            let smcr = SmcrGp16(self.regs[first(index) + at::SMCR]);
            // ITR0 is TIM1, ITR1 to ITR4 are TIM2 to TIM5 (29.4, table of internal triggers): TS 1
            // to 3, and 8.
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
}
