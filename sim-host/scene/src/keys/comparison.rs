//! `[comparison]`: cases of the scene with changed keys, at equal peak, rms, power or reduction.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A comparison of cases: each is this scene with some keys changed, scaled until it equals the
/// first case in the quantity that `match` names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// Title of the tables.
    pub title: String,
    /// Metrics to compare, one column each.
    #[schemars(length(min = 1, max = 12))]
    pub metrics: Vec<String>,
    /// Key that scales the drive: a peak that the scene gives. With `[controller]`:
    /// `controller.drive.amplitude_v`.
    pub amplitude_key: String,
    /// Quantities that are equal between the cases, one table each.
    #[serde(rename = "match")]
    #[schemars(length(min = 1, max = 4))]
    pub matched: Vec<Equal>,
    /// Further changes for every case, each as `key=value` (for example a shorter timeline).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// Cases of the comparison; the others are matched to the first.
    #[schemars(length(min = 2, max = 32))]
    pub case: Vec<Case>,
}

/// A case of the comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name of the case, in tables and expectations.
    pub name: String,
    /// Changes of this case, each as `key=value`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// `true` to draw the time-frequency pictures of this case, at the last `match`. Needs a sweep.
    #[serde(default)]
    pub picture: bool,
}

/// Quantity that is equal between cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Equal {
    /// The peak: `amplitude_key` has the scene's value. Every waveform has a peak of one.
    Peak,
    /// The root mean square of the drive voltage while ON: `drive_rms_v`.
    Rms,
    /// The mean electrical power while ON: `drive_power_w`.
    Power,
    /// The reduction of the mean friction, ON and OFF: `mean_reduction_percent`.
    Reduction,
}

impl Equal {
    /// Returns the metric that is made equal, or `None` if the key itself is.
    pub fn metric(self) -> Option<&'static str> {
        match self {
            Equal::Peak => None,
            Equal::Rms => Some("drive_rms_v"),
            Equal::Power => Some("drive_power_w"),
            Equal::Reduction => Some("mean_reduction_percent"),
        }
    }

    /// Returns the exponent with which the metric grows with the amplitude in a linear plant.
    pub fn exponent(self) -> f64 {
        match self {
            Equal::Peak | Equal::Rms | Equal::Reduction => 1.0,
            Equal::Power => 2.0,
        }
    }

    /// Returns its value in a scene.
    pub fn name(self) -> &'static str {
        match self {
            Equal::Peak => "peak",
            Equal::Rms => "rms",
            Equal::Power => "power",
            Equal::Reduction => "reduction",
        }
    }
}
