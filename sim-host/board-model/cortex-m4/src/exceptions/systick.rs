//! The system timer (B3.3).

use crate::chip::Cycle;

const ENABLE: u32 = 1;
const TICKINT: u32 = 1 << 1;
const CLKSOURCE: u32 = 1 << 2;
const COUNTFLAG: u32 = 1 << 16;
const MASK: u32 = 0x00FF_FFFF;

/// A counter that is not counted: only when it comes to zero is stored.
#[derive(Clone, Debug)]
pub(crate) struct SysTick {
    control: u32,
    reload: u32,
    /// The count while it stands.
    value: u32,
    /// When a running counter comes to zero, in cycles of the processor times the counts of [`rate`](SysTick::rate): a whole number.
    zero: Cycle,
    /// Counts of the core clock in so many cycles of the processor.
    core: (u32, u32),
}

impl Default for SysTick {
    fn default() -> SysTick {
        SysTick { control: 0, reload: 0, value: 0, zero: Cycle::MAX, core: (1, 1) }
    }
}

impl SysTick {
    /// Lets it count `counts` times in `cycles` cycles where it counts the core clock.
    pub(crate) fn set_core_clock(&mut self, counts: u32, cycles: u32) {
        self.core = (counts, cycles);
    }

    /// Counts, in so many cycles. The reference clock is an eighth of the processor's.
    fn rate(&self) -> (Cycle, Cycle) {
        let (counts, cycles) = if self.control & CLKSOURCE != 0 { self.core } else { (1, 8) };
        (counts.into(), cycles.into())
    }

    fn runs(&self) -> bool {
        self.control & ENABLE != 0 && self.zero != Cycle::MAX
    }

    /// When the counter next comes to zero.
    pub(crate) fn due(&self) -> Cycle {
        if self.runs() { self.zero.div_ceil(self.rate().0) } else { Cycle::MAX }
    }

    /// Lets it count to `now`; whether the exception is pended.
    pub(crate) fn advance(&mut self, now: Cycle) -> bool {
        if self.due() > now {
            return false;
        }
        let (counts, cycles) = self.rate();
        let period = Cycle::from(self.reload + 1) * cycles;
        self.control |= COUNTFLAG;
        // With a reload of 0 it stops at zero.
        self.zero = if self.reload == 0 { Cycle::MAX } else { self.zero + ((now * counts - self.zero) / period + 1) * period };
        self.value = 0;
        self.control & TICKINT != 0
    }

    fn count(&self, now: Cycle) -> u32 {
        if !self.runs() {
            return self.value;
        }
        let (counts, cycles) = self.rate();
        let left = self.zero.saturating_sub(now * counts).div_ceil(cycles) as u32;
        // The count of a whole period is that of zero itself, just before the reload.
        if left > self.reload && self.value == 0 { 0 } else { left & MASK }
    }

    /// Lets it stand; returns when it would come to zero, for [`go_on`](SysTick::go_on).
    pub(crate) fn hold(&mut self) -> Cycle {
        std::mem::replace(&mut self.zero, Cycle::MAX)
    }

    /// Lets it go on after it has stood for some cycles of the processor.
    pub(crate) fn go_on(&mut self, zero: Cycle, stood: Cycle) {
        self.zero = if zero == Cycle::MAX { zero } else { zero + stood * self.rate().0 };
    }

    pub(crate) fn read(&mut self, register: u32, now: Cycle) -> u32 {
        match register {
            0 => {
                let control = self.control;
                self.control &= !COUNTFLAG;
                control
            }
            4 => self.reload,
            8 => self.count(now),
            // No calibration value.
            _ => 1 << 31,
        }
    }

    pub(crate) fn write(&mut self, register: u32, value: u32, now: Cycle) {
        match register {
            0 => {
                let count = self.count(now);
                let was_running = self.control & ENABLE != 0;
                self.control = self.control & COUNTFLAG | value & (ENABLE | TICKINT | CLKSOURCE);
                if self.control & ENABLE == 0 {
                    self.value = count;
                } else if !was_running {
                    self.start(count, now);
                }
            }
            4 => self.reload = value & MASK,
            // Any value clears the count and COUNTFLAG; a running counter reloads with the next clock.
            8 => {
                self.control &= !COUNTFLAG;
                self.value = 0;
                if self.control & ENABLE != 0 {
                    self.start(0, now);
                }
            }
            _ => {}
        }
    }

    /// Counts down from `count`, or from the reload value after zero.
    fn start(&mut self, count: u32, now: Cycle) {
        let (counts, cycles) = self.rate();
        self.value = count;
        let steps = if count == 0 { self.reload + 1 } else { count };
        self.zero = if count == 0 && self.reload == 0 { Cycle::MAX } else { now * counts + Cycle::from(steps) * cycles };
    }
}
