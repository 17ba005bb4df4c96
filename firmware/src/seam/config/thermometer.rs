//! Values from which the temperature of the stack is inferred.

use config_macro::settings;
use serde::{Deserialize, Serialize};

use crate::seam::error::Error;

/// Temperature of the stack: from the energy that it takes, and from the temperature coefficients
/// of the tracked quantities. The hottest value counts.
#[settings(table = "thermometer", scene = Thermometer)]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thermometer {
    /// Temperature coefficient of the series resonance, Hz/K. Zero: not used.
    #[setting(default, min = -1e4, max = 1e4, key = 29)]
    pub hz_per_k: f32,
    /// Relative temperature coefficient of the clamped capacitance, 1/K. Zero: not used.
    #[setting(default, min = -0.1, max = 0.1, key = 30)]
    pub c0_per_k: f32,
    /// Highest temperature of the stack's surroundings, degrees Celsius. A sensor at the driver
    /// replaces it.
    #[setting(default = 25.0, min = -100.0, max = 500.0, key = 31)]
    pub ambient_c: f32,
    /// Thermal resistance from the stack to its surroundings, K/W. Absent: no energy balance, and a
    /// load can hide the heat from the resonance.
    #[setting(min = 1e-6, max = 1e6, key = 98)]
    pub resistance_k_per_w: Option<f32>,
    /// Heat capacity of the stack, J/K. Must be given with the resistance.
    #[setting(min = 1e-6, max = 1e6, key = 99)]
    pub heat_capacity_j_per_k: Option<f32>,
    /// Relative tolerance of resistance and heat capacity: 0.3 for values of a data sheet, two
    /// standard deviations for measured ones.
    #[setting(default = 0.3, min = 0.0, max = 0.9, key = 100)]
    pub tolerance: f32,
    /// Highest temperature of the stack at power-on, degrees Celsius. Absent: warm, at
    /// `limits.temperature_c`. Used by the energy balance.
    #[setting(min = -100.0, max = 500.0, key = 101)]
    pub start_c: Option<f32>,
    /// `true` if the board's sensor is at the stack: only its reading counts.
    #[setting(default, key = 102, quiet)]
    pub at_stack: bool,
}

impl Thermometer {
    /// Checks that the heat capacity is given with the thermal resistance.
    pub(super) fn check_balance(&self) -> Result<(), Error> {
        self.resistance_k_per_w.map_or(Ok(()), |_| Self::HEAT_CAPACITY_J_PER_K.check(self.heat_capacity_j_per_k.unwrap_or(0.0)))
    }
}
