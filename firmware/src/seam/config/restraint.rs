//! Conditions under which a crash makes friction LOW.

use config_macro::settings;
use serde::{Deserialize, Serialize};

use super::{Config, Optional};

/// Conditions under which a crash makes the friction of a D-ring LOW: once, for a light occupant,
/// and never HIGH again.
#[settings(table = "restraint", scene = Restraint, optional)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Restraint {
    /// Belt force above which there is a crash, N. Needs `sensors.force_hz`.
    #[setting(default = 1000.0, min = 1.0, max = 1e5, key = 84)]
    pub sensed_n: f32,
    /// Time for which the force must last, ms.
    #[setting(default = 0.5, min = 0.0, max = 100.0, key = 85)]
    pub confirm_ms: f32,
    /// Latest time of LOW after the confirmed crash, ms.
    #[setting(default = 40.0, min = 0.0, max = 1e3, key = 86)]
    pub latest_ms: f32,
    /// Belt force above which LOW would come too late, N.
    // The force that the limiter transmits at LOW is then already reached.
    #[setting(default = 3000.0, min = 1.0, max = 1e5, key = 87)]
    pub latest_n: f32,
    /// Torso mass below which the occupant is light, kg.
    #[setting(default = 17.5, min = 0.0, max = 1e3, key = 88)]
    pub light_below_kg: f32,
    /// Smallest plausible torso mass from the seat, kg.
    #[setting(default = 5.0, min = 0.0, max = 1e3, key = 89)]
    pub least_kg: f32,
    /// Largest plausible torso mass from the seat, kg.
    #[setting(default = 60.0, min = 0.0, max = 1e3, key = 90)]
    pub most_kg: f32,
}

impl Optional for Restraint {
    const DEFAULT: Self = Restraint {
        sensed_n: 1000.0,
        confirm_ms: 0.5,
        latest_ms: 40.0,
        latest_n: 3000.0,
        light_below_kg: 17.5,
        least_kg: 5.0,
        most_kg: 60.0,
    };

    fn of(config: &Config) -> Option<&Self> {
        config.restraint.as_ref()
    }

    fn of_mut(config: &mut Config) -> Option<&mut Self> {
        config.restraint.as_mut()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_without_a_restraint_are_its_defaults() {
        assert_eq!(Restraint::DEFAULT, Restraint::default());
    }
}
