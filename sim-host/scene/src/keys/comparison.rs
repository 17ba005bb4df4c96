//! `[comparison]`: the scene with some keys set, case beside case, at equal peak, rms or power.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cases beside each other: each is this scene, run again with some keys set, and scaled until it equals the first case in what
/// `match` names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// What the tables show.
    pub title: String,
    /// The metrics, a column each.
    #[schemars(length(min = 1, max = 12))]
    pub metrics: Vec<String>,
    /// Key that scales what is driven: a peak, which the scene gives. With `[controller]`: `controller.drive.amplitude_v`.
    pub amplitude_key: String,
    /// What is equal between the cases, a table each.
    #[serde(rename = "match")]
    #[schemars(length(min = 1, max = 3))]
    pub matched: Vec<Equal>,
    /// Further changes for every case, each as `key=value` (a shorter timeline, say).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// The cases; the first is what the others are matched to.
    #[schemars(length(min = 2, max = 32))]
    pub case: Vec<Case>,
}

/// A case of the comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name of the case, in tables and expectations.
    pub name: String,
    /// What is changed in it, each as `key=value`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// Whether its time-frequency pictures are drawn, at the last `match`. It needs a sweep.
    #[serde(default)]
    pub picture: bool,
}

/// What is equal between cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Equal {
    /// The peak: `amplitude_key` has the scene's value. Every shape has a peak of one.
    Peak,
    /// The root mean square of what was driven while ON: `drive_rms_v`.
    Rms,
    /// The mean electrical power while ON: `drive_power_w`.
    Power,
}

impl Equal {
    /// The metric that is made equal; none where the key itself is.
    pub fn metric(self) -> Option<&'static str> {
        match self {
            Equal::Peak => None,
            Equal::Rms => Some("drive_rms_v"),
            Equal::Power => Some("drive_power_w"),
        }
    }

    /// The power of the amplitude with which that metric grows, in a linear plant.
    pub fn exponent(self) -> f64 {
        match self {
            Equal::Peak | Equal::Rms => 1.0,
            Equal::Power => 2.0,
        }
    }

    /// How a scene spells it.
    pub fn name(self) -> &'static str {
        match self {
            Equal::Peak => "peak",
            Equal::Rms => "rms",
            Equal::Power => "power",
        }
    }
}
