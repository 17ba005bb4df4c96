//! Cycles and seconds, and when what next happens.

use cortex_m4::Cycle;

/// Picoseconds since power-on.
pub type Ps = u64;

/// A microsecond.
pub const US: Ps = 1_000_000;

/// The core clock, which changes, against time, which does not.
#[derive(Clone, Copy, Debug)]
pub struct TimeBase {
    hz: u64,
    since: Cycle,
    base: Ps,
}

impl TimeBase {
    /// From power-on, at so many Hz.
    pub fn new(hz: u64) -> Self {
        TimeBase { hz, since: 0, base: 0 }
    }

    /// The core clock, Hz.
    pub fn hz(&self) -> u64 {
        self.hz
    }

    /// The time of a cycle.
    pub fn ps(&self, at: Cycle) -> Ps {
        self.base + (u128::from(at.saturating_sub(self.since)) * 1_000_000_000_000 / u128::from(self.hz)) as Ps
    }

    /// The first cycle that is not before a time.
    pub fn cycle(&self, ps: Ps) -> Cycle {
        self.since + (u128::from(ps.saturating_sub(self.base)) * u128::from(self.hz)).div_ceil(1_000_000_000_000) as Cycle
    }

    /// The clock stands at this cycle until a time.
    pub fn stand(&mut self, at: Cycle, until: Ps) {
        *self = TimeBase { since: at, base: until.max(self.ps(at)), ..*self };
    }

    /// From this cycle on the core has another clock.
    pub fn set(&mut self, at: Cycle, hz: u64) {
        *self = TimeBase { hz, since: at, base: self.ps(at) };
    }
}

/// What happens by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// TIM2 to TIM5: a trigger or an interrupt of it.
    Timer(usize),
    /// ADC1 to ADC5, counted from zero: the sampled voltage is held.
    AdcHold(usize),
    /// ADC1 to ADC5: a conversion ends.
    AdcEnd(usize),
    /// ADC1 to ADC5: calibrated, or ready.
    AdcReady(usize),
    /// The transmitter has sent a byte.
    Sent,
    /// The receiver has a byte.
    Received,
    /// The receiver's line is idle.
    Idle,
    /// The flash has finished.
    Flash,
    /// The watchdog bites.
    Iwdg,
    /// A clock is ready: HSI, HSE, PLL, LSI, HSI48.
    Ready(usize),
    /// The next defect.
    Defect,
    /// TIM1: an edge of a channel, or the end of its count.
    Tim1,
}

const COUNT: usize = 32;
/// Those whose time is in seconds: they move when the clock changes.
const SECONDS: std::ops::Range<usize> = 19..29;

impl Event {
    /// All, in the order in which they are looked at.
    fn of(index: usize) -> Self {
        match index {
            0..4 => Event::Timer(index),
            4..9 => Event::AdcHold(index - 4),
            9..14 => Event::AdcEnd(index - 9),
            14..19 => Event::AdcReady(index - 14),
            19 => Event::Sent,
            20 => Event::Received,
            21 => Event::Idle,
            22 => Event::Flash,
            23 => Event::Iwdg,
            24..29 => Event::Ready(index - 24),
            29 => Event::Defect,
            _ => Event::Tim1,
        }
    }

    fn index(self) -> usize {
        match self {
            Event::Timer(n) => n,
            Event::AdcHold(n) => 4 + n,
            Event::AdcEnd(n) => 9 + n,
            Event::AdcReady(n) => 14 + n,
            Event::Sent => 19,
            Event::Received => 20,
            Event::Idle => 21,
            Event::Flash => 22,
            Event::Iwdg => 23,
            Event::Ready(n) => 24 + n,
            Event::Defect => 29,
            Event::Tim1 => 30,
        }
    }
}

/// When each of them happens next.
#[derive(Clone, Debug)]
pub struct Agenda {
    at: [Cycle; COUNT],
    /// Those that happen at all, a bit each: few.
    planned: u32,
    next: Cycle,
    first: usize,
}

impl Default for Agenda {
    fn default() -> Self {
        Agenda { at: [Cycle::MAX; COUNT], planned: 0, next: Cycle::MAX, first: COUNT }
    }
}

impl Agenda {
    /// Something happens at `at`, and not when it was to happen before.
    pub fn set(&mut self, event: Event, at: Cycle) {
        let index = event.index();
        self.at[index] = at;
        if at == Cycle::MAX {
            self.planned &= !(1 << index);
        } else {
            self.planned |= 1 << index;
        }
        if index == self.first {
            self.find_first();
        } else if (at, index) < (self.next, self.first) {
            (self.next, self.first) = (at, index);
        }
    }

    /// It does not happen.
    pub fn clear(&mut self, event: Event) {
        self.set(event, Cycle::MAX);
    }

    /// When it happens.
    pub fn get(&self, event: Event) -> Cycle {
        self.at[event.index()]
    }

    /// When something happens.
    pub fn next(&self) -> Cycle {
        self.next
    }

    /// Takes what happens next, if that is no later than `now`: of two at the same time the one with the lower index.
    pub fn take(&mut self, now: Cycle) -> Option<(Cycle, Event)> {
        if self.next > now {
            return None;
        }
        let taken = (self.next, Event::of(self.first));
        self.at[self.first] = Cycle::MAX;
        self.planned &= !(1 << self.first);
        self.find_first();
        Some(taken)
    }

    fn find_first(&mut self) {
        (self.next, self.first) = (Cycle::MAX, COUNT);
        let mut left = self.planned;
        while left != 0 {
            let index = left.trailing_zeros() as usize;
            left &= left - 1;
            if self.at[index] < self.next {
                (self.next, self.first) = (self.at[index], index);
            }
        }
    }

    /// The core clock has changed: what is due in seconds moves in cycles.
    pub fn retime(&mut self, before: &TimeBase, after: &TimeBase) {
        for slot in &mut self.at[SECONDS] {
            if *slot != Cycle::MAX {
                *slot = after.cycle(before.ps(*slot));
            }
        }
        self.find_first();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_change_moves_what_is_due_in_seconds() {
        let slow = TimeBase::new(16_000_000);
        let mut fast = slow;
        let mut agenda = Agenda::default();
        agenda.set(Event::Flash, slow.cycle(100 * US));
        agenda.set(Event::Timer(0), 1600);
        fast.set(800, 160_000_000);
        agenda.retime(&slow, &fast);
        assert_eq!(agenda.get(Event::Flash), 800 + 50 * 160);
        assert_eq!(agenda.take(10_000), Some((1600, Event::Timer(0))));
        assert_eq!(fast.ps(8800), 100 * US);
    }
}
