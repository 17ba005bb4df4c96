//! `[rig.carriage]`: a mass that slides past a tip as the forces on it say.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A carriage on the tip of a driven stack, which vibrates along the motion: `m v' = P + k (y - x) + c (y' - v) - F`, with the end `y` of its spring pulled at a
/// constant speed. For scenes with `[controller]` and `[contact.lugre]`.
///
/// What turns is a carriage too: at the radius r of the contact an inertia J is a mass J / r^2, and a torque M a force M / r.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Carriage {
    /// Mass m of the carriage, kg.
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub mass_kg: f64,
    /// Force that presses the carriage on the tip, N.
    #[schemars(range(min = 1e-3, max = 1e6))]
    pub normal_n: f64,
    /// Constant force P along the motion, N: a weight, or an unwound spring.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub force_n: f64,
    /// Stiffness k of the spring by which it is pulled, N/m: that of a drive train, or of a hand.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1e12))]
    pub stiffness_n_per_m: f64,
    /// Damping c beside the spring, N s/m.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1e9))]
    pub damping_n_s_per_m: f64,
    /// Speed of the spring's end, m/s.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -10.0, max = 10.0))]
    pub pull_m_per_s: f64,
    /// When the spring's end begins to move, s.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1e5))]
    pub pull_at_s: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
