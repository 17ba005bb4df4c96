//! `[rig.carriage]`: a mass on the tip, moved by the forces that act on it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A carriage on the tip of a driven stack, which vibrates along the motion:
/// `m v' = P + k (y - x) + c (y' - v) - F`. The end `y` of its spring is pulled at a constant
/// speed. For scenes with `[controller]` and `[contact.lugre]`.
///
/// It also models rotation: at the contact radius r an inertia J is a mass J / r^2, and a torque M
/// a force M / r.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Carriage {
    /// Mass m of the carriage, kg.
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub mass_kg: f64,
    /// Force that presses the carriage on the tip, N.
    #[schemars(range(min = 1e-3, max = 1e6))]
    pub normal_n: f64,
    /// Constant force P along the motion, N, such as a weight or a preloaded spring.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -1e6, max = 1e6))]
    pub force_n: f64,
    /// Stiffness k of the spring that pulls the carriage, N/m, such as that of a drive train or a
    /// hand.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1e12))]
    pub stiffness_n_per_m: f64,
    /// Damping c parallel to the spring, N s/m.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1e9))]
    pub damping_n_s_per_m: f64,
    /// Speed of the spring's end, m/s.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -10.0, max = 10.0))]
    pub pull_m_per_s: f64,
    /// Time at which the spring's end begins to move, s.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1e5))]
    pub pull_at_s: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
