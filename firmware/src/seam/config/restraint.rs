//! When a crash makes friction LOW.

use config_macro::settings;
use serde::{Deserialize, Serialize};

/// When a crash makes the friction of a D-ring LOW: once, for a light occupant, and never back.
#[settings(table = "restraint", scene = Restraint)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Restraint {
    /// Belt force that is a crash, N. Needs `sensors.force_hz`.
    #[setting(default = 1000.0, min = 1.0, max = 1e5)]
    pub sensed_n: f32,
    /// How long it must last, ms.
    #[setting(default = 0.5, min = 0.0, max = 100.0)]
    pub confirm_ms: f32,
    /// How long after that LOW may come at the latest, ms.
    #[setting(default = 40.0, min = 0.0, max = 1e3)]
    pub latest_ms: f32,
    /// Belt force from which on LOW would come too late, N.
    // What the limiter lets through at LOW is reached.
    #[setting(default = 3000.0, min = 1.0, max = 1e5)]
    pub latest_n: f32,
    /// Torso mass below which the occupant is light, kg.
    #[setting(default = 17.5, min = 0.0, max = 1e3)]
    pub light_below_kg: f32,
    /// The smallest torso mass that the seat can have read, kg.
    #[setting(default = 5.0, min = 0.0, max = 1e3)]
    pub least_kg: f32,
    /// The largest torso mass that the seat can have read, kg.
    #[setting(default = 60.0, min = 0.0, max = 1e3)]
    pub most_kg: f32,
}
