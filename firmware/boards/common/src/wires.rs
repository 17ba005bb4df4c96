//! Check that the belt's encoder is connected: the two wires of a channel must have opposite
//! levels.
//!
//! A broken wire is pulled low while the other one changes, so both agree during part of each
//! period. Two broken wires of a channel always agree. Wires that are read during an edge may agree
//! once.

/// Increase of the suspicion by a reading in which the wires of a channel agree. Any other reading
/// subtracts one.
const AGREEMENT_WEIGHT: u8 = 4;
/// Suspicion at which a line counts as broken: after three readings in a row, or a third of many
/// readings.
const BROKEN_SUSPICION: u8 = 12;

/// State of the check of the wires.
#[derive(Clone, Debug, Default)]
pub struct Wires {
    suspicion: u8,
    broken: bool,
}

impl Wires {
    /// Takes the levels of both channels, each with its complement. Returns `true` if a line is
    /// broken. This state ends after the levels have been opposite for long enough.
    #[inline]
    pub fn look(&mut self, channels: [(bool, bool); 2]) -> bool {
        let agrees = channels.iter().any(|(wire, complement)| wire == complement);
        self.suspicion =
            if agrees { (self.suspicion + AGREEMENT_WEIGHT).min(2 * BROKEN_SUSPICION) } else { self.suspicion.saturating_sub(1) };
        self.broken = self.suspicion >= BROKEN_SUSPICION || self.broken && self.suspicion > 0;
        self.broken
    }
}
