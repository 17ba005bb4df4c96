//! Thermistor at the amplifier's heat sink.

use config_macro::settings;
use serde::{Deserialize, Serialize};

/// Thermistor at the amplifier's heat sink, connected from an input of the board to ground, with a
/// pull-up resistor to the supply of the converters. The hotter of heat sink and processor is
/// compared with `limits.temperature_c`. An open or shorted thermistor stops the drive.
#[settings(table = "heat_sink")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatSink {
    /// Resistance at 25 degrees Celsius, ohm. Absent: there is no thermistor.
    #[setting(min = 100.0, max = 1e6, key = 59)]
    pub ohm_at_25_c: Option<f32>,
    /// Coefficient B, K.
    #[setting(default = 3950.0, min = 1000.0, max = 1e4, key = 60)]
    pub beta_k: f32,
    /// Pull-up resistor, ohm.
    #[setting(default = 10e3, min = 100.0, max = 1e6, key = 61)]
    pub pull_up_ohm: f32,
}
