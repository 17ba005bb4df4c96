//! Whether the belt's encoder is still connected: its two wires of a channel must contradict each other.
//!
//! A broken wire rests where its pull-down puts it, while the other one goes on: they agree for part of each period. Two that are
//! both broken agree always. Wires that are looked at in the middle of an edge may agree once.

/// What a look at which a channel's wires agree adds; one at which none do takes one away.
const AGREES: u8 = 4;
/// This much is a broken line: three looks in a row, or a third of many.
const BROKEN: u8 = 12;

/// The memory of the wires.
#[derive(Clone, Debug, Default)]
pub struct Wires {
    suspicion: u8,
    broken: bool,
}

impl Wires {
    /// Takes the levels of both channels, each with its complement. Returns whether a line is broken; that ends once they have contradicted
    /// each other for long.
    pub fn look(&mut self, channels: [(bool, bool); 2]) -> bool {
        let agrees = channels.iter().any(|(wire, complement)| wire == complement);
        self.suspicion = if agrees { (self.suspicion + AGREES).min(2 * BROKEN) } else { self.suspicion.saturating_sub(1) };
        self.broken = self.suspicion >= BROKEN || self.broken && self.suspicion > 0;
        self.broken
    }
}
