//! Scale factors of a board's converter codes.

use firmware::board::command::Converters;

use crate::client::Client;
use crate::link_error::LinkError;
use crate::parameter::{parameter, report};

/// Scale factors from codes to volts and amperes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Sampling rate, Hz.
    pub sample_hz: f64,
    /// Duration of a block, s.
    pub block_s: f64,
    /// Volts at the stack per voltage code.
    pub volt_per_lsb: f64,
    /// Amperes into the stack per current code.
    pub ampere_per_lsb: f64,
    /// Volts at the amplifier's output per drive code.
    pub drive_volt_per_lsb: f64,
    /// Sense code at zero.
    pub sense_mid_code: f64,
    /// Drive code at zero.
    pub drive_mid_code: f64,
}

impl Scale {
    /// Requests the scale factors from the board.
    pub fn ask(converters: &Converters, client: &mut Client) -> Result<Self, LinkError> {
        let sample_hz = f64::from(converters.sample_hz);
        let mut acts = |name: &str| Ok::<f64, LinkError>(report(parameter(name)?, client)?.acts.into());
        Ok(Scale {
            sample_hz,
            block_s: f64::from(converters.block_samples) / sample_hz,
            volt_per_lsb: acts("front_end.volt_per_lsb")?,
            ampere_per_lsb: acts("front_end.ampere_per_lsb")?,
            drive_volt_per_lsb: acts("front_end.drive_volt_per_lsb")?,
            sense_mid_code: converters.sense_mid_code.into(),
            drive_mid_code: converters.drive_mid_code.into(),
        })
    }

    /// Converts a voltage code to V.
    pub fn volts(&self, code: u16) -> f64 {
        (f64::from(code) - self.sense_mid_code) * self.volt_per_lsb
    }

    /// Converts a current code to A.
    pub fn amperes(&self, code: u16) -> f64 {
        (f64::from(code) - self.sense_mid_code) * self.ampere_per_lsb
    }

    /// Converts a drive code to V.
    pub fn drive_volts(&self, code: u16) -> f64 {
        (f64::from(code) - self.drive_mid_code) * self.drive_volt_per_lsb
    }
}
