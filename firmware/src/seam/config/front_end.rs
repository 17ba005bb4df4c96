//! Scales of the converters and sensors of a board.

use config_macro::settings;
use serde::{Deserialize, Serialize};

/// Scale factors of the converters; on a board they come from the settings store.
#[settings(table = "front_end")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrontEnd {
    /// Voltage at the stack per voltage code, V.
    #[setting(min = 1e-9, max = 1e3, key = 1, scale)]
    pub volt_per_lsb: f32,
    /// Current into the stack per current code, A.
    #[setting(min = 1e-9, max = 1e3, key = 2, scale)]
    pub ampere_per_lsb: f32,
    /// Sense code at zero, before the self-test has measured the offset.
    pub sense_mid_code: u16,
    /// Largest sense code.
    pub sense_max_code: u16,
    /// Voltage at the amplifier's output per drive code, V.
    #[setting(min = 1e-9, max = 1e3, key = 3, scale)]
    pub drive_volt_per_lsb: f32,
    /// Drive code at zero volts.
    pub drive_mid_code: u16,
    /// Largest drive code.
    pub drive_max_code: u16,
    /// Number of the board's drive converters, each with its amplifier.
    #[setting(min = 1, max = 4)]
    pub drive_lanes: u8,
    /// Length of belt per count of its encoder, m. Absent: there is no encoder.
    #[setting(min = 0.9e-7, max = 1.1e-2, key = 56)]
    pub metre_per_count: Option<f32>,
    /// Bandwidth of the force channel, Hz. Absent: there is no force channel.
    #[setting(min = 1.0, max = 1e5, key = 58)]
    pub force_hz: Option<f32>,
    /// Force per code of the force channel, N, if the board converts it. Absent: there is no force
    /// channel.
    #[setting(min = 1e-9, max = 1e3, key = 57)]
    pub newton_per_lsb: Option<f32>,
}

#[cfg(test)]
impl FrontEnd {
    /// Front end of the unit tests: converters of 12 bits, four lanes, no encoder and no force
    /// channel.
    pub(crate) const OF_TESTS: Self = FrontEnd {
        volt_per_lsb: 0.01,
        ampere_per_lsb: 0.002,
        sense_mid_code: 2048,
        sense_max_code: 4095,
        drive_volt_per_lsb: 0.01,
        drive_mid_code: 2048,
        drive_max_code: 4095,
        drive_lanes: 4,
        metre_per_count: None,
        force_hz: None,
        newton_per_lsb: None,
    };
}
