//! The restraint's part of the configuration.

use serde::{Deserialize, Serialize};

/// When a crash makes the friction of a seat belt's D-ring LOW.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Restraint {
    /// Belt force that is a crash, N.
    pub sensed_n: f32,
    /// How long it must last, ms.
    pub confirm_ms: f32,
    /// How long after that LOW may come at the latest, ms.
    pub latest_ms: f32,
    /// Belt force from which on LOW would come too late, N: what the limiter lets through at LOW is reached.
    pub latest_n: f32,
    /// Torso mass below which the occupant is light, kg.
    pub light_below_kg: f32,
    /// The smallest torso mass that the seat can have read, kg.
    pub least_kg: f32,
    /// The largest, kg.
    pub most_kg: f32,
}

impl Default for Restraint {
    fn default() -> Self {
        Restraint {
            sensed_n: 1000.0,
            confirm_ms: 0.5,
            latest_ms: 40.0,
            latest_n: 3000.0,
            light_below_kg: 17.5,
            least_kg: 5.0,
            most_kg: 60.0,
        }
    }
}
