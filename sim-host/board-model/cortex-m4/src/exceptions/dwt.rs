//! Cycle counter of the data watchpoint and trace unit (C1.8). Comparators and event counters are
//! not modelled.

use crate::chip::Cycle;

/// DWT_CTRL and DWT_CYCCNT.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dwt {
    pub(crate) control: u32,
    /// DEMCR.TRCENA
    pub(crate) enabled: bool,
    /// Count while the counter is stopped; otherwise the difference of cycle and count.
    base: u32,
}

impl Dwt {
    fn counts(&self) -> bool {
        self.enabled && self.control & 1 == 1
    }

    pub(crate) fn count(&self, now: Cycle) -> u32 {
        if self.counts() { (now as u32).wrapping_sub(self.base) } else { self.base }
    }

    pub(crate) fn set_count(&mut self, count: u32, now: Cycle) {
        self.base = if self.counts() { (now as u32).wrapping_sub(count) } else { count };
    }

    /// Starts or stops the counter, which keeps its count.
    pub(crate) fn set_control(&mut self, control: u32, enabled: bool, now: Cycle) {
        let count = self.count(now);
        (self.control, self.enabled) = (control, enabled);
        self.set_count(count, now);
    }
}
