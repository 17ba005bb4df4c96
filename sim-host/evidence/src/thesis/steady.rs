//! Steady friction and power under a sine, system dynamics apart: what the ratios tend to once start-up is over.
//!
//! Dahl's depend on the velocity ratio and kappa alone, Coulomb's on the velocity ratio alone.

use contact::closed;

/// Steady ratios of friction and power.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steady {
    /// Mean friction over that without vibration.
    pub friction: f64,
    /// Power dissipated over that without vibration.
    pub power: f64,
}

impl Steady {
    /// Power that the vibration takes in, over that of friction without it: what is dissipated beyond what sliding brings.
    pub fn input(&self) -> f64 {
        self.power - self.friction
    }
}

/// Steady ratios of Dahl friction.
pub fn dahl(velocity_ratio: f64, kappa: f64) -> Steady {
    let power = closed::power_ratio(velocity_ratio, kappa).unwrap_or(f64::NAN);
    Steady { friction: closed::friction_ratio(velocity_ratio, kappa), power }
}

/// Coulomb's friction ratio (4.3).
pub fn coulomb(velocity_ratio: f64) -> f64 {
    closed::coulomb_friction_ratio(velocity_ratio)
}

/// Dahl's friction ratio for kappa -> 0, where the contact is so compliant that the force hardly changes within a period.
pub fn compliant(velocity_ratio: f64) -> f64 {
    closed::limit_ratio(velocity_ratio)
}
