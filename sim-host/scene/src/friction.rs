//! `[controller.friction]`: the friction switch.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The friction switch: the friction that is wanted, and what is known of the contact beforehand. It sets amplitude and bursts, up to
/// `drive.velocity_m_per_s`. Give exactly one of `target_ratio` and `target_force_n`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Wanted friction, as a part of that without vibration.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub target_ratio: Option<f64>,
    /// Wanted friction, N. Needs `sensors.force_hz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e6))]
    pub target_force_n: Option<f64>,
    /// When other ratios are ordered, s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(inner(range(min = 0.0, max = 1e5)))]
    pub step_s: Vec<f64>,
    /// Those ratios.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub step_ratio: Vec<f64>,
    /// The law that is inverted.
    #[serde(default)]
    pub law: FrictionLaw,
    /// What is preferred where amplitude and bursts are both possible. Bursts need `burst.period_s`; their duty is set by the switch.
    #[serde(default)]
    pub prefer: Prefer,
    /// Sliding speed as told, m/s, where no encoder tells it.
    #[schemars(range(min = 1e-6, max = 100.0))]
    pub speed_m_per_s: f64,
    /// Dahl length Fc / Kt as told, m, where no force channel allows a survey.
    #[serde(default = "default::dahl_length_m")]
    #[schemars(range(min = 1e-9, max = 1e-3))]
    pub dahl_length_m: f64,
    /// For how long the force is averaged at each place of the survey, s.
    #[serde(default = "default::average_s")]
    #[schemars(range(min = 1e-3, max = 100.0))]
    pub average_s: f64,
}

/// The law that is inverted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FrictionLaw {
    /// Dahl's, with the stiffness that the survey finds.
    #[default]
    Dahl,
    /// Coulomb's, the reference that is shown to err.
    Coulomb,
}

/// What is preferred where amplitude and bursts are both possible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Prefer {
    /// Amplitude, but for the velocity threshold.
    #[default]
    Amplitude,
    /// Bursts.
    Bursts,
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn dahl_length_m() -> f64 {
        0.5e-6
    }
    pub(super) fn average_s() -> f64 {
        0.05
    }
}
