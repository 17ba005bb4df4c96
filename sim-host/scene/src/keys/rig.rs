//! `[rig]`: the mechanism that presses on the contact and moves it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::carriage::Carriage;
use crate::dring::Dring;

/// The mechanism that presses on the contact and moves it. Give exactly one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rig {
    /// A slider at constant speed (experiment 1).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slider: Option<Slider>,
    /// A prescribed vibration, independent of the friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kinematic: Option<Kinematic>,
    /// One mass on a spring.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sdof: Option<Sdof>,
    /// The rotor of a travelling-wave motor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor: Option<Rotor>,
    /// A belt under a vibrating horn (experiment 2).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub belt: Option<Belt>,
    /// A torso in its seat belt, over a D-ring, in a crash.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dring: Option<Dring>,
    /// A carriage that is moved by the forces on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carriage: Option<Carriage>,
}

/// A slider at constant speed; the tip of a driven stack vibrates along the motion. For scenes with
/// `[controller]`.
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
    /// Sliding speed of the slider, m/s.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub speed_m_per_s: f64,
    /// Ripple of the speed, rms relative to the speed: Gaussian, in a narrow band about
    /// `ripple_hz`.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ripple_rms: f64,
    /// Frequency of the ripple, Hz.
    #[serde(default = "default::ripple_hz", skip_serializing_if = "is_usual_ripple")]
    #[schemars(range(min = 0.1, max = 1e3), extend("default" = default::ripple_hz()))]
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
    /// Typical of a hand, a roller or a chain.
    pub(super) fn ripple_hz() -> f64 {
        10.0
    }
    pub(super) fn full_amplitude_m() -> f64 {
        85e-6
    }
    /// Fitted together with the law of the belt.
    pub(super) fn lag_s() -> f64 {
        0.45
    }
}

/// A prescribed vibration velocity, independent of the friction: no system dynamics (thesis 4.1,
/// 4.2). For scenes with `[excitation]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Kinematic {
    /// Peak vibration velocity Vv, m/s; across the surface for a Hertzian or a compliant contact,
    /// else along the motion. With a measured waveform: reference of the ratios.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e4))]
    pub vibration_m_per_s: Option<f64>,
    /// Peak displacement of the vibration, m, instead of its velocity: that of a sine at
    /// `excitation.frequency_hz`, Vv / w.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 0.01))]
    pub vibration_amplitude_m: Option<f64>,
}

impl Kinematic {
    /// Returns the peak vibration velocity at a frequency, m/s.
    pub fn vibration_m_per_s(&self, frequency_hz: f64) -> f64 {
        let of_amplitude = || std::f64::consts::TAU * frequency_hz * self.vibration_amplitude_m.unwrap_or(0.0);
        self.vibration_m_per_s.unwrap_or_else(of_amplitude)
    }
}

/// One mass on a spring, m x'' + c x' + Ks x = force - friction (thesis 4.14). On a Hertzian
/// contact it moves across the surface, m d'' + c d' + Ks (d - d0) = normal_n + force - K d^1.5.
/// For scenes with `[excitation]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sdof {
    /// Mass m of the oscillator, kg.
    #[schemars(range(min = 1e-9, max = 1e6))]
    pub mass_kg: f64,
    /// System stiffness Ks, N/m.
    #[schemars(range(min = 1e-3, max = 1e15))]
    pub stiffness_n_per_m: f64,
    /// Damping ratio, c / (2 sqrt(m Ks)). The thesis has no damping.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub damping_ratio: f64,
}

/// A rigid rotor that is pressed on the crests of a stator through a compliant layer and driven by
/// friction. For scenes with `[stator]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rotor {
    /// Moment of inertia, kg m^2.
    #[schemars(range(min = 1e-12, max = 1e3))]
    pub inertia_kg_m2: f64,
    /// Load torque against forward rotation, for example of a weight on a drum, N m.
    #[serde(default)]
    #[schemars(range(min = -1e3, max = 1e3))]
    pub torque_nm: f64,
    /// Force that presses the rotor on, N.
    #[schemars(range(min = 1e-3, max = 1e5))]
    pub preload_n: f64,
    /// Coefficient of friction between rotor and stator.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub mu: f64,
    /// Mean radius of the contact, m.
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub radius_m: f64,
    /// Stiffness of the contact layer for contact all round, N/m. With the preload it determines
    /// the angle over which a crest is in contact.
    #[schemars(range(min = 1e3, max = 1e12))]
    pub contact_stiffness_n_per_m: f64,
}

/// A seat belt, pulled at constant speed between a base and the horn of a welder, which vibrates
/// across it. The horn is the tip of the driven stack, and the controller controls its amplitude.
/// For scenes with `[controller]` and `[contact.empirical]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Belt {
    /// Force of the horn on the belt, N.
    #[schemars(range(min = 1.0, max = 1e4))]
    pub load_n: f64,
    /// Speed of the belt, m/s.
    #[schemars(range(min = -10.0, max = 10.0))]
    pub speed_m_per_s: f64,
    /// Set point of the amplitude, as a part of the full amplitude: 0.7 is 70 %. Replaces
    /// `drive.velocity_m_per_s`.
    #[schemars(range(min = 1e-3, max = 1.0))]
    pub amplitude_fraction: f64,
    /// Full amplitude of the horn, zero to peak, m.
    #[serde(default = "default::full_amplitude_m")]
    #[schemars(range(min = 1e-9, max = 1e-2))]
    pub full_amplitude_m: f64,
    /// Time constant with which the pull falls to its reduced value and rises again, s: air
    /// cylinder, belt and load cell together.
    #[serde(default = "default::lag_s")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub lag_s: f64,
    /// Delay from the trigger, which is the start of a window of `[controller.burst]`, to the
    /// vibration, s.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub trigger_delay_s: f64,
    /// Damping of the horn by the belt for each newton of load: N s/m per N, or s/m.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e3))]
    pub damping_s_per_m: f64,
    /// Ripple of the speed, rms relative to the speed: Gaussian, in a narrow band about
    /// `ripple_hz`.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ripple_rms: f64,
    /// Frequency of the ripple, Hz.
    #[serde(default = "default::ripple_hz", skip_serializing_if = "is_usual_ripple")]
    #[schemars(range(min = 0.1, max = 1e3), extend("default" = default::ripple_hz()))]
    pub ripple_hz: f64,
}
