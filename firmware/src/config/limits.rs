//! What must never be exceeded, and by what the stack tells its temperature.

use serde::{Deserialize, Serialize};

/// The stack as a thermometer of itself: by how much a kelvin moves what the tracker measures. A coefficient of zero measures nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thermometer {
    /// Of the series resonance, Hz/K.
    pub hz_per_k: f32,
    /// Of the clamped capacitance, relative, 1/K.
    pub c0_per_k: f32,
    /// Temperature of the stack when it is first measured, where the board has no sensor of its own, degrees Celsius.
    pub ambient_c: f32,
}

impl Default for Thermometer {
    fn default() -> Self {
        Thermometer { hz_per_k: 0.0, c0_per_k: 0.0, ambient_c: 25.0 }
    }
}

/// What must never be exceeded. `None` is no limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Peak drive voltage, V. More is refused, not faulted: the drive is clamped and says so.
    pub voltage_v: f32,
    /// Peak total current, A.
    pub current_a: f32,
    /// Mean electrical power, W.
    pub power_w: Option<f32>,
    /// Temperature of board and stack, degrees Celsius. The drive is derated from 20 K below it on.
    pub temperature_c: f32,
    /// How long the drive stays ON after the last new count of the belt, ms. Only with a belt sensor.
    pub belt_stop_ms: f32,
    /// Electrical energy for each metre of belt, J/m. Only with a belt sensor.
    pub energy_j_per_m: Option<f32>,
    /// How long the drive may be ON without a pause, s.
    pub on_time_s: Option<f32>,
}

impl Default for Limits {
    /// What the stack of the prototype bears, and no other limit.
    fn default() -> Self {
        Limits {
            voltage_v: 15.466,
            current_a: 3.0,
            power_w: None,
            temperature_c: 100.0,
            belt_stop_ms: 2.4,
            energy_j_per_m: None,
            on_time_s: None,
        }
    }
}
