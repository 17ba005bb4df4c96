//! `[controller.limits]` and `[controller.thermometer]`: what must never be exceeded, and by what the stack tells its temperature.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The stack as a thermometer of itself: what a kelvin does to what is tracked. Zero: it says nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Thermometer {
    /// What a kelvin adds to the series resonance, Hz/K.
    #[schemars(range(min = -1e4, max = 1e4))]
    pub hz_per_k: f64,
    /// By which part a kelvin changes the clamped capacitance, 1/K.
    #[schemars(range(min = -0.1, max = 0.1))]
    pub c0_per_k: f64,
    /// Temperature of the stack when it is first measured, where the board has no sensor, degrees Celsius.
    #[schemars(range(min = -100.0, max = 500.0))]
    pub ambient_c: f64,
}

impl Default for Thermometer {
    fn default() -> Self {
        Thermometer { hz_per_k: 0.0, c0_per_k: 0.0, ambient_c: 25.0 }
    }
}

impl Thermometer {
    /// Serde asks by reference.
    pub(super) fn is_none(&self) -> bool {
        *self == Thermometer::default()
    }
}

/// What must never be exceeded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Peak drive voltage, V.
    #[schemars(range(min = 1e-3, max = 1e4))]
    pub voltage_v: f64,
    /// Peak current, A.
    #[schemars(range(min = 1e-6, max = 1e3))]
    pub current_a: f64,
    /// Mean electrical power, W. Absent: no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e5))]
    pub power_w: Option<f64>,
    /// Temperature of board and stack, degrees Celsius: derated from 20 K below it on.
    #[schemars(range(min = 0.0, max = 500.0))]
    pub temperature_c: f64,
    /// How long the drive stays ON after the last new count of the belt's encoder, ms. A belt that slows instead of stopping is noticed
    /// within twice that.
    #[schemars(range(min = 0.1, max = 1e5))]
    pub belt_stop_ms: f64,
    /// Electrical energy for each metre of belt, J/m. Absent: no limit. Needs `sensors.encoder_counts_per_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e9))]
    pub energy_j_per_m: Option<f64>,
    /// How long the drive may be ON without a pause, s. Absent: no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e5))]
    pub on_time_s: Option<f64>,
}

impl Default for Limits {
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
