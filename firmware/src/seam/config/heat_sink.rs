//! The thermistor at the amplifier's heat sink.

use config_macro::settings;
use serde::{Deserialize, Serialize};

/// The thermistor at the amplifier's heat sink: from an input of the board to ground, below a resistor to the supply of the converters. Its temperature
/// and the processor's are compared with `limits.temperature_c`, the hotter of the two. One that is open or short stops the drive.
#[settings(table = "heat_sink")]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatSink {
    /// Its resistance at 25 degrees Celsius, ohm. Absent: there is no thermistor.
    #[setting(min = 100.0, max = 1e6, key = 59)]
    pub ohm_at_25_c: Option<f32>,
    /// Its coefficient B, K.
    #[setting(default = 3950.0, min = 1000.0, max = 1e4, key = 60)]
    pub beta_k: f32,
    /// The resistor to the supply, ohm.
    #[setting(default = 10e3, min = 100.0, max = 1e6, key = 61)]
    pub pull_up_ohm: f32,
}
