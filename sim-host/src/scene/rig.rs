//! `[rig]`: what presses on the contact and moves it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What presses on the contact and moves it. Give exactly one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rig {
    /// A slider at constant speed (experiment 1).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slider: Option<Slider>,
    /// A vibration that nothing disturbs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kinematic: Option<Kinematic>,
    /// One mass on a spring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sdof: Option<Sdof>,
}

/// A slider at constant speed; the tip of a driven stack vibrates along the motion. For scenes with `[controller]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Slider {
    /// Load on the lever arm, N.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e4))]
    pub load_n: f64,
    /// Weight of the transducer itself, N.
    #[schemars(range(min = 0.0, max = 1e4))]
    pub self_weight_n: f64,
    /// Sliding speed, m/s.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub speed_m_per_s: f64,
}

/// A vibration velocity that is given, whatever the friction: no system dynamics (thesis 4.1, 4.2). For scenes with `[excitation]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Kinematic {
    /// Peak vibration velocity Vv, m/s; across the surface under a Hertzian contact, else along the motion.
    #[schemars(range(min = 0.0, max = 1e4))]
    pub vibration_m_per_s: f64,
}

/// One mass on a spring, m x'' + c x' + Ks x = force - friction (thesis 4.14). For scenes with `[excitation]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sdof {
    /// Mass m, kg.
    #[schemars(range(min = 1e-9, max = 1e6))]
    pub mass_kg: f64,
    /// System stiffness Ks, N/m.
    #[schemars(range(min = 1e-3, max = 1e15))]
    pub stiffness_n_per_m: f64,
    /// Damping ratio, c over 2 sqrt(m Ks). The thesis has none.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub damping_ratio: f64,
}
