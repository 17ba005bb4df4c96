//! System timer (B3.3).

use crate::chip::Cycle;

const ENABLE: u32 = 1;
const TICKINT: u32 = 1 << 1;
const CLKSOURCE: u32 = 1 << 2;
const COUNTFLAG: u32 = 1 << 16;
const MASK: u32 = 0x00FF_FFFF;

/// System timer. Instead of a running count, only the time of its next zero is stored.
#[derive(Clone, Debug)]
pub(crate) struct SysTick {
    control: u32,
    reload: u32,
    /// Count while the timer is stopped.
    value: u32,
    /// Time of the next zero, in cycles of the processor times the counts of
    /// [`rate`](SysTick::rate), which makes it a whole number.
    zero: Cycle,
    /// Clock ratio of the core clock: counts, and cycles of the processor during these counts.
    core: (u32, u32),
}

impl Default for SysTick {
    fn default() -> SysTick {
        SysTick { control: 0, reload: 0, value: 0, zero: Cycle::MAX, core: (1, 1) }
    }
}

impl SysTick {
    /// Sets the core clock to `counts` counts in `cycles` cycles.
    pub(crate) fn set_core_clock(&mut self, counts: u32, cycles: u32) {
        self.core = (counts, cycles);
    }

    /// Returns the counts, and the cycles of the processor during these counts. The reference clock
    /// is an eighth of the processor's.
    fn rate(&self) -> (Cycle, Cycle) {
        let (counts, cycles) = if self.control & CLKSOURCE != 0 { self.core } else { (1, 8) };
        (counts.into(), cycles.into())
    }

    fn runs(&self) -> bool {
        self.control & ENABLE != 0 && self.zero != Cycle::MAX
    }

    /// Returns the cycle of the next zero.
    pub(crate) fn due(&self) -> Cycle {
        if self.runs() { self.zero.div_ceil(self.rate().0) } else { Cycle::MAX }
    }

    /// Advances to `now`. Returns `true` if the exception is pended.
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
        // A full period remaining is shown as zero: the counter reloads with the next clock.
        if left > self.reload && self.value == 0 { 0 } else { left & MASK }
    }

    /// Stops the timer; returns the time of its next zero, for [`resume`](SysTick::resume).
    pub(crate) fn hold(&mut self) -> Cycle {
        std::mem::replace(&mut self.zero, Cycle::MAX)
    }

    /// Resumes the timer after `stood` cycles of the processor.
    pub(crate) fn resume(&mut self, zero: Cycle, stood: Cycle) {
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
            // SYST_CALIB: no calibration value.
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
            // Any value clears the count and COUNTFLAG; a running counter reloads with the next
            // clock.
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

    /// Starts the timer from `count`, or from the reload value if `count` is zero.
    fn start(&mut self, count: u32, now: Cycle) {
        let (counts, cycles) = self.rate();
        self.value = count;
        let steps = if count == 0 { self.reload + 1 } else { count };
        self.zero = if count == 0 && self.reload == 0 { Cycle::MAX } else { now * counts + Cycle::from(steps) * cycles };
    }
}
