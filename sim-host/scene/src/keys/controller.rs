//! `[controller]`: the settings of the firmware that drives. Their tables are described in the firmware's own configuration.

use firmware::seam::config::Config;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Burst, Drive, Friction, Limits, Phasing, Restraint, Sweep, Thermometer, Tracking};

/// The settings of the firmware that drives the transducer: its nominal values, set points and limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// Samples in a block.
    #[serde(default = "default::block_samples")]
    #[schemars(range(min = Config::BLOCK_SAMPLES.min as u16, max = Config::BLOCK_SAMPLES.max as u16))]
    pub block_samples: u16,
    /// The drive: frequency, amplitude and shape.
    pub drive: Drive,
    /// A chirp while running. Without it the frequency is the tracked one, or stays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
    /// Lane offsets and trims of a multi-phase drive.
    #[serde(default)]
    pub phasing: Phasing,
    /// When the drive is ON. Without it: always, once locked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst: Option<Burst>,
    /// The target friction. Without it amplitude and bursts are those of the settings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
    /// How the resonance is found and tracked, and the nominal values of the transducer.
    pub tracking: Tracking,
    /// The stack as a thermometer of itself.
    #[serde(default, skip_serializing_if = "is_default")]
    pub thermometer: Thermometer,
    /// What must never be exceeded.
    #[serde(default)]
    pub limits: Limits,
    /// When a crash makes the friction of a D-ring LOW, in place of a burst. For scenes with `[rig.dring]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restraint: Option<Restraint>,
}

/// Serde asks by reference.
fn is_default(thermometer: &Thermometer) -> bool {
    *thermometer == Thermometer::default()
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn block_samples() -> u16 {
        32
    }
}
