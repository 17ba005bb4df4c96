//! `[controller]`: the settings of the firmware that drives. Its tables are documented in the
//! firmware's configuration.

use firmware::seam::config::Config;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Burst, Drive, Friction, Limits, Phasing, Restraint, Sweep, Thermometer, Tracking};

/// The settings of the firmware that drives the transducer: its nominal values, set points and
/// limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// Samples in a block.
    #[serde(default = "default::block_samples")]
    #[schemars(range(min = Config::BLOCK_SAMPLES.min as u16, max = Config::BLOCK_SAMPLES.max as u16))]
    pub block_samples: u16,
    /// The drive: frequency, amplitude and shape.
    pub drive: Drive,
    /// A chirp while running. Without it, the frequency is tracked or constant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
    /// Lane offsets and trims of a multi-phase drive.
    #[serde(default)]
    pub phasing: Phasing,
    /// Times at which the drive is ON. Without it: always, once locked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst: Option<Burst>,
    /// The target friction. Without it, amplitude and bursts are those of the settings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
    /// Search and tracking of the resonance, and the nominal values of the transducer.
    pub tracking: Tracking,
    /// Temperature measurement by the stack itself.
    #[serde(default, skip_serializing_if = "is_default")]
    pub thermometer: Thermometer,
    /// Limits that must never be exceeded.
    #[serde(default)]
    pub limits: Limits,
    /// Control of the friction of a D-ring in a crash, instead of bursts. For scenes with
    /// `[rig.dring]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restraint: Option<Restraint>,
}

/// Returns `true` for the default. Serde passes a reference.
fn is_default(thermometer: &Thermometer) -> bool {
    *thermometer == Thermometer::default()
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn block_samples() -> u16 {
        32
    }
}
