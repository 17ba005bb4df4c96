//! Steady friction and power ratios under a sine, without system dynamics and start transient.
//!
//! Dahl's ratios depend on the velocity ratio and kappa alone, Coulomb's on the velocity ratio
//! alone.

use contact::closed;

/// Steady ratios of friction and power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steady {
    /// Mean friction over friction without vibration.
    pub friction: f64,
    /// Dissipated power over that without vibration.
    pub power: f64,
}

impl Steady {
    /// Returns the power input of the vibration over the friction power without vibration: the
    /// dissipation in excess of the sliding power.
    pub fn input(&self) -> f64 {
        self.power - self.friction
    }
}

/// Returns the steady ratios of Dahl friction.
pub fn dahl(velocity_ratio: f64, kappa: f64) -> Steady {
    let power = closed::power_ratio(velocity_ratio, kappa).unwrap_or(f64::NAN);
    Steady { friction: closed::friction_ratio(velocity_ratio, kappa), power }
}

/// Returns Coulomb's friction ratio (4.3).
pub fn coulomb(velocity_ratio: f64) -> f64 {
    closed::coulomb_friction_ratio(velocity_ratio)
}

/// Returns Dahl's friction ratio for kappa -> 0: the force of a compliant contact hardly changes
/// within a period.
pub fn compliant(velocity_ratio: f64) -> f64 {
    closed::limit_ratio(velocity_ratio)
}
