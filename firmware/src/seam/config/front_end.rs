//! What the converters and sensors of a board are worth.

use config_macro::settings;
use serde::{Deserialize, Serialize};

/// Scale factors of the converters; on a board they come from the settings store.
#[settings(table = "front_end")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrontEnd {
    /// Volts at the stack per voltage code.
    #[setting(min = 1e-9, max = 1e3, key = 1, scale)]
    pub volt_per_lsb: f32,
    /// Amperes into the stack per current code.
    #[setting(min = 1e-9, max = 1e3, key = 2, scale)]
    pub ampere_per_lsb: f32,
    /// The sense code at zero (before the self-test has measured the offset).
    pub sense_mid_code: u16,
    /// The largest sense code.
    pub sense_max_code: u16,
    /// Volts at the amplifier's output per drive code.
    #[setting(min = 1e-9, max = 1e3, key = 3, scale)]
    pub drive_volt_per_lsb: f32,
    /// The drive code at zero volts.
    pub drive_mid_code: u16,
    /// The largest drive code.
    pub drive_max_code: u16,
    /// Drive converters, each with its amplifier, that the board has.
    #[setting(min = 1, max = 4)]
    pub drive_lanes: u8,
    /// Belt that passes from one count of its encoder to the next, m. Absent: there is no encoder.
    #[setting(min = 0.9e-7, max = 1.1e-2, key = 56)]
    pub metre_per_count: Option<f32>,
    /// Bandwidth of the force channel, Hz. Absent: there is no force channel.
    #[setting(min = 1.0, max = 1e5, key = 58)]
    pub force_hz: Option<f32>,
    /// Force per code of the force channel, N, where the board converts it. Absent: there is no force channel.
    #[setting(min = 1e-9, max = 1e3, key = 57)]
    pub newton_per_lsb: Option<f32>,
}

#[cfg(test)]
impl FrontEnd {
    /// The front end of the unit tests: converters of 12 bits, four lanes, no encoder and no force channel.
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
