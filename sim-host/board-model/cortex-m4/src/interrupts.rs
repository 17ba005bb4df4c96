//! Lines from the chip to the processor's interrupt controller.

/// Number of modelled interrupt lines: 128 of the 240 that ARMv7-M allows.
pub const LINES: u16 = 128;

/// Levels of the interrupt lines, the NMI, and the reset.
#[derive(Clone, Debug, Default)]
pub struct Interrupts {
    /// Levels, one bit per line. A line that is high when its handler returns pends it again
    /// (ARMv7-M B3.4.1).
    level: u128,
    nmi: bool,
    reset: bool,
    /// `true` after any change, until the processor reads it.
    changed: bool,
}

impl Interrupts {
    /// Sets the level of interrupt line `line`; 0 is the first one after the 16 system exceptions.
    pub fn set(&mut self, line: u16, high: bool) {
        let bit = 1 << line;
        let level = if high { self.level | bit } else { self.level & !bit };
        self.changed |= level != self.level;
        self.level = level;
    }

    /// Returns the levels of all lines, one bit each.
    pub fn levels(&self) -> u128 {
        self.level
    }

    /// Pends the non-maskable interrupt.
    pub fn pend_nmi(&mut self) {
        self.nmi = true;
        self.changed = true;
    }

    /// Pulls the reset line: after the current instruction the chip and the processor restart.
    pub fn pull_reset(&mut self) {
        self.reset = true;
        self.changed = true;
    }

    /// Returns `true` after a change since [`take_changed`](Interrupts::take_changed).
    pub(crate) fn has_changed(&self) -> bool {
        self.changed
    }

    /// Returns `true` after a change since the last call.
    pub(crate) fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// Returns `true` if the NMI was pended since the last call.
    pub(crate) fn take_nmi(&mut self) -> bool {
        std::mem::take(&mut self.nmi)
    }

    /// Returns `true` if the reset line was pulled since the last call.
    pub(crate) fn take_reset(&mut self) -> bool {
        std::mem::take(&mut self.reset)
    }
}
