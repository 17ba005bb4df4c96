//! Energy budget of the stack: energy from the amplifier, losses, work against friction, stored
//! energy.
//!
//! `integral v0 i = integral Rm i^2 + integral (F / phi) i + change of the energy in Lm and Cm`.
//! The clamped capacitance returns its energy and is omitted. The integrals are sums over the steps
//! (spectrally accurate, as the motion is periodic and begins and ends at rest or in the same
//! state). The residual therefore shows the step error of the friction coupling, and any error in
//! its sign or its reaction.

/// Sums of work since the beginning, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Work of the amplifier on the motional branch.
    pub supplied_j: f64,
    /// Heat in the motional resistance.
    pub lost_j: f64,
    /// Work that the tip does against friction.
    pub friction_on_tip_j: f64,
    /// Energy in the motional branch now; it began at rest.
    pub stored_j: f64,
    /// Part of the stored energy that changes of the circuit have added.
    pub disturbed_j: f64,
}

impl Energy {
    /// Returns the unaccounted energy relative to the supplied energy; zero if nothing was
    /// supplied.
    pub fn residual(&self) -> f64 {
        let accounted = self.lost_j + self.friction_on_tip_j + self.stored_j - self.disturbed_j;
        if self.supplied_j == 0.0 { 0.0 } else { (self.supplied_j - accounted) / self.supplied_j.abs() }
    }
}
