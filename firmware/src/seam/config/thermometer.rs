//! Coefficients from which the temperature of the stack is inferred.

use config_macro::settings;
use serde::{Deserialize, Serialize};

/// The stack as its own thermometer: temperature coefficients of the tracked quantities. Zero: not
/// used.
#[settings(table = "thermometer", scene = Thermometer)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thermometer {
    /// Temperature coefficient of the series resonance, Hz/K.
    #[setting(default, min = -1e4, max = 1e4, key = 29)]
    pub hz_per_k: f32,
    /// Relative temperature coefficient of the clamped capacitance, 1/K.
    #[setting(default, min = -0.1, max = 0.1, key = 30)]
    pub c0_per_k: f32,
    /// Temperature of the stack at its first measurement, if the board has no sensor, degrees
    /// Celsius.
    #[setting(default = 25.0, min = -100.0, max = 500.0, key = 31)]
    pub ambient_c: f32,
}
