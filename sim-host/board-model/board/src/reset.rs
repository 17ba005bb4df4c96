//! Resets of the part, and their causes.

use std::fmt;

use cortex_m4::Cycle;

/// A reset of the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reset {
    /// When.
    pub at: Cycle,
    /// Its flags in RCC_CSR.
    pub(crate) flags: u32,
}

impl fmt::Display for Reset {
    /// Its cause, by the flags of RCC_CSR (RM0440 7.4.28): the first one of these, as every reset pulls the pin too.
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
