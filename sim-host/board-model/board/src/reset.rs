//! Resets of the microcontroller and their causes.

use std::fmt;

use cortex_m4::Cycle;

/// Reset of the microcontroller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reset {
    /// Cycle of the reset.
    pub at: Cycle,
    /// Flags in RCC_CSR.
    pub(crate) flags: u32,
}

impl fmt::Display for Reset {
    /// Writes the cause from the flags of RCC_CSR (RM0440 7.4.28): the first flag of this list,
    /// because every reset also pulls the pin.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let causes = [
            (29, "the independent watchdog"),
            (28, "software"),
            (30, "the window watchdog"),
            (27, "brown-out"),
            (26, "the reset pin"),
        ];
        let cause = causes.iter().find(|(bit, _)| self.flags >> bit & 1 == 1);
        f.write_str(cause.map_or("an unknown cause", |(_, name)| name))
    }
}
