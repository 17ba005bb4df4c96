//! Conversion of cycles and seconds, and the agenda of events.

use cortex_m4::Cycle;

/// Picoseconds since power-on.
pub type Ps = u64;

/// One microsecond, ps.
pub const US: Ps = 1_000_000;

/// Relation of the core clock, which can change, to time.
#[derive(Clone, Copy, Debug)]
pub struct TimeBase {
    hz: u64,
    since: Cycle,
    base: Ps,
}

impl TimeBase {
    /// Creates the relation from power-on, at `hz`.
    pub fn new(hz: u64) -> Self {
        TimeBase { hz, since: 0, base: 0 }
    }

    /// Returns the core clock, Hz.
    pub fn hz(&self) -> u64 {
        self.hz
    }

    /// Returns the time of a cycle.
    pub fn ps(&self, at: Cycle) -> Ps {
        self.base + (u128::from(at.saturating_sub(self.since)) * 1_000_000_000_000 / u128::from(self.hz)) as Ps
    }

    /// Returns the first cycle at or after a time.
    pub fn cycle(&self, ps: Ps) -> Cycle {
        self.since + (u128::from(ps.saturating_sub(self.base)) * u128::from(self.hz)).div_ceil(1_000_000_000_000) as Cycle
    }

    /// Stops the clock at this cycle until a time.
    pub fn stop_until(&mut self, at: Cycle, until: Ps) {
        *self = TimeBase { since: at, base: until.max(self.ps(at)), ..*self };
    }

    /// Changes the core clock at this cycle.
    pub fn set(&mut self, at: Cycle, hz: u64) {
        *self = TimeBase { hz, since: at, base: self.ps(at) };
    }
}

/// Event that occurs without an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// TIM2 to TIM5: trigger or interrupt.
    Timer(usize),
    /// ADC1 to ADC5, counted from zero: hold of the sampled voltage.
    AdcHold(usize),
    /// ADC1 to ADC5: end of a conversion.
    AdcEnd(usize),
    /// ADC1 to ADC5: calibrated, or ready.
    AdcReady(usize),
    /// Transmitter: byte sent.
    Sent,
    /// Receiver: byte received.
    Received,
    /// Receiver: idle line.
    Idle,
    /// Flash: operation finished.
    Flash,
    /// Watchdog: reset.
    Iwdg,
    /// Clock ready: HSI, HSE, PLL, LSI, HSI48.
    Ready(usize),
    /// Next defect.
    Defect,
    /// TIM1: edge of a channel, or end of its count.
    Tim1,
}

const COUNT: usize = 32;
/// Indices of the events whose time is in seconds: they move when the clock changes.
const SECONDS: std::ops::Range<usize> = 19..29;

impl Event {
    /// Returns the event of an index; simultaneous events are handled in the order of the indices.
    fn from_index(index: usize) -> Self {
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

/// Next cycle of each event.
#[derive(Clone, Debug)]
pub struct Agenda {
    at: [Cycle; COUNT],
    /// Planned events, one bit each: few.
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
    /// Plans an event at `at`, instead of at its earlier time.
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

    /// Removes an event.
    pub fn clear(&mut self, event: Event) {
        self.set(event, Cycle::MAX);
    }

    /// Returns the cycle of an event.
    pub fn get(&self, event: Event) -> Cycle {
        self.at[event.index()]
    }

    /// Returns the cycle of the next event.
    pub fn next(&self) -> Cycle {
        self.next
    }

    /// Takes the next event if it is not later than `now`; of simultaneous ones that with the lower
    /// index.
    pub fn take(&mut self, now: Cycle) -> Option<(Cycle, Event)> {
        if self.next > now {
            return None;
        }
        let taken = (self.next, Event::from_index(self.first));
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

    /// Moves the events that are due in seconds after a change of the core clock.
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
