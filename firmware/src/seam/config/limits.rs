//! Limits that must never be exceeded.

use config_macro::settings;
use serde::{Deserialize, Serialize};

use crate::seam::config::keys::ENERGY_PER_METRE;

/// Limits that must never be exceeded. The defaults are those of the prototype's stack.
#[settings(table = "limits", scene = Limits)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Peak drive voltage, V.
    // A higher set point is clamped and reported as a limit, not a fault.
    #[setting(default = 15.466, min = 1e-3, max = 1e4, key = 8, ceiling)]
    pub voltage_v: f32,
    /// Peak current, A.
    #[setting(default = 3.0, min = 1e-6, max = 1e3, key = 9, ceiling)]
    pub current_a: f32,
    /// Mean electrical power, W. Absent: no limit.
    #[setting(min = 1e-3, max = 1e5, key = 10, ceiling)]
    pub power_w: Option<f32>,
    /// Temperature of board and stack, degrees Celsius. The drive is derated from 20 K below it.
    #[setting(default = 100.0, min = 0.0, max = 500.0, key = 11, ceiling)]
    pub temperature_c: f32,
    /// Time for which the drive stays ON after the last new count of the belt's encoder, ms. A belt
    /// that slows instead of stopping is detected within twice that time.
    #[setting(default = 2.4, min = 0.1, max = 1e5, key = 13, ceiling)]
    pub belt_stop_ms: f32,
    /// Electrical energy per metre of belt, J/m. Absent: no limit. Needs
    /// `sensors.encoder_counts_per_mm`.
    #[setting(min = 1e-3, max = 1e9, key = ENERGY_PER_METRE, ceiling)]
    pub energy_j_per_m: Option<f32>,
    /// Largest excess of ON time over OFF time, s; OFF time cancels ON time. Absent: no limit.
    #[setting(min = 1e-3, max = 3e4, key = 12, ceiling)]
    pub on_time_s: Option<f32>,
}
