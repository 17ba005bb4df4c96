//! Whether the belt's encoder is still connected: its two wires of a channel must contradict each
//! other.
//!
//! A broken wire is low by its pull-down, while the other one changes: they agree for part of each
//! period. Two that are both broken agree always. Wires that are read in the middle of an edge may
//! agree once.

/// Added to the suspicion by a reading in which a channel's wires agree; any other reading
/// subtracts one.
const AGREES: u8 = 4;
/// The suspicion from which a line is broken: three readings in a row, or a third of many.
const BROKEN: u8 = 12;

/// The state of the wires' check.
#[derive(Clone, Debug, Default)]
pub struct Wires {
    suspicion: u8,
    broken: bool,
}

impl Wires {
    /// Takes the levels of both channels, each with its complement. Returns whether a line is
    /// broken; that ends once they have contradicted each other for long.
    #[inline]
    pub fn look(&mut self, channels: [(bool, bool); 2]) -> bool {
        let agrees = channels.iter().any(|(wire, complement)| wire == complement);
        self.suspicion = if agrees { (self.suspicion + AGREES).min(2 * BROKEN) } else { self.suspicion.saturating_sub(1) };
        self.broken = self.suspicion >= BROKEN || self.broken && self.suspicion > 0;
        self.broken
    }
}
