//! The energy budget of the stack: what the amplifier gives, what is lost, what friction takes, what is stored.
//!
//! `integral v0 i = integral Rm i^2 + integral (F / phi) i + change of what Lm and Cm hold`; the clamped capacitance gives back what
//! it takes and is left out. The integrals are sums over the steps (spectrally accurate for a periodic motion, and it begins and
//! ends at rest or in the same state), so that the residual shows the step error of the friction coupling, and any mistake in
//! its sign or its way back.

/// Sums of work since the beginning, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Work of the amplifier on the motional branch.
    pub supplied_j: f64,
    /// Heat in the motional resistance.
    pub lost_j: f64,
    /// Work that the tip does against friction.
    pub friction_on_tip_j: f64,
    /// What the motional branch holds now; it began at rest.
    pub stored_j: f64,
    /// What changing the circuit itself has added to that.
    pub disturbed_j: f64,
}

impl Energy {
    /// What the sums do not account for, relative to what was supplied; zero if nothing was.
    pub fn residual(&self) -> f64 {
        let accounted = self.lost_j + self.friction_on_tip_j + self.stored_j - self.disturbed_j;
        if self.supplied_j == 0.0 { 0.0 } else { (self.supplied_j - accounted) / self.supplied_j.abs() }
    }
}
