//! `[rig]`: what presses on the contact and moves it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::dring::Dring;

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
    /// The rotor of a travelling-wave motor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor: Option<Rotor>,
    /// A torso in its seat belt, over a D-ring, in a crash.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dring: Option<Dring>,
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
    /// Ripple of the speed, rms as a part of it: Gaussian, of a narrow band about `ripple_hz`.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ripple_rms: f64,
    /// Frequency of the ripple, Hz.
    #[serde(default = "default::ripple_hz", skip_serializing_if = "is_usual_ripple")]
    #[schemars(range(min = 0.1, max = 1e3))]
    pub ripple_hz: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

fn is_usual_ripple(value: &f64) -> bool {
    *value == default::ripple_hz()
}

/// Defaults that serde needs as functions.
mod default {
    /// Of a hand, a roller, a chain.
    pub(super) fn ripple_hz() -> f64 {
        10.0
    }
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

/// A rigid rotor pressed on the crests of a stator through a compliant layer, and driven by their friction. For scenes with
/// `[stator]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotor {
    /// Moment of inertia, kg m^2.
    #[schemars(range(min = 1e-12, max = 1e3))]
    pub inertia_kg_m2: f64,
    /// Load torque against forward rotation, as of a weight on a drum, N m.
    #[serde(default)]
    #[schemars(range(min = -1e3, max = 1e3))]
    pub torque_nm: f64,
    /// Force that presses the rotor on, N.
    #[schemars(range(min = 1e-3, max = 1e5))]
    pub preload_n: f64,
    /// Coefficient of friction.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub mu: f64,
    /// Mean radius of the contact, m.
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub radius_m: f64,
    /// Stiffness of the contact layer if it touched all round, N/m. With the preload it sets the angle over which a crest touches.
    #[schemars(range(min = 1e3, max = 1e12))]
    pub contact_stiffness_n_per_m: f64,
}
