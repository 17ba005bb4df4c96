//! `[controller.restraint]`: when a crash makes friction LOW.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When a crash makes the friction of a D-ring LOW: once, for a light occupant, and never back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Restraint {
    /// Belt force that is a crash, N. Needs `sensors.force_hz`.
    #[schemars(range(min = 1.0, max = 1e5))]
    pub sensed_n: f64,
    /// How long it must last, ms.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub confirm_ms: f64,
    /// How long after that LOW may come at the latest, ms.
    #[schemars(range(min = 0.0, max = 1e3))]
    pub latest_ms: f64,
    /// Belt force from which on LOW would come too late, N.
    #[schemars(range(min = 1.0, max = 1e5))]
    pub latest_n: f64,
    /// Torso mass below which the occupant is light, kg.
    #[schemars(range(min = 0.0, max = 1e3))]
    pub light_below_kg: f64,
    /// The smallest torso mass that the seat can have read, kg.
    #[schemars(range(min = 0.0, max = 1e3))]
    pub least_kg: f64,
    /// The largest, kg.
    #[schemars(range(min = 0.0, max = 1e3))]
    pub most_kg: f64,
}

impl Default for Restraint {
    fn default() -> Self {
        let of = firmware::config::Restraint::default();
        Restraint {
            sensed_n: of.sensed_n.into(),
            confirm_ms: of.confirm_ms.into(),
            latest_ms: of.latest_ms.into(),
            latest_n: of.latest_n.into(),
            light_below_kg: of.light_below_kg.into(),
            least_kg: of.least_kg.into(),
            most_kg: of.most_kg.into(),
        }
    }
}
