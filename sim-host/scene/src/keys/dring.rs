//! `[rig.dring]`: a torso in its seat belt, over a D-ring, in a crash.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Profile;

/// Default frequency of a ring's vibration, Hz: that of experiment 2.
pub(crate) const RING_HZ: f64 = 20e3;
/// Default radius of the ring, m: ASSUMED.
const RING_RADIUS_M: f64 = 8e-3;

/// A torso in its seat belt, over a D-ring whose friction the drive reduces, in a crash. For scenes
/// with `[stack]` and without `[contact]`. Give either `pulse_g` and `pulse_ms`, or `pulse`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Dring {
    /// Angle of wrap of the webbing around the D-ring, degrees.
    #[schemars(range(min = 1.0, max = 720.0))]
    pub wrap_deg: f64,
    /// Coefficient of friction of the webbing on the D-ring without drive.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub mu_high: f64,
    /// Lowest coefficient of friction that any actuator reaches.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub mu_low: f64,
    /// Force at the retractor at which its load limiter releases webbing, N.
    #[schemars(range(min = 100.0, max = 1e5))]
    pub limiter_n: f64,
    /// Size of the occupant, by percentile of adults.
    pub occupant: Occupant,
    /// Mass of the torso, kg. Default: that of `occupant`, 14, 22 or 29 kg.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 200.0))]
    pub torso_kg: Option<f64>,
    /// Relative error of the torso mass that the seat measures; positive: too high.
    #[serde(default)]
    #[schemars(range(min = -0.9, max = 10.0))]
    pub seat_error: f64,
    /// `true` if the seat measures the mass of the torso.
    #[serde(default = "default::seat_reads")]
    pub seat_reads: bool,
    /// Peak of the half-sine pulse, g of 9.81 m/s^2.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.1, max = 200.0))]
    pub pulse_g: Option<f64>,
    /// Length of the half-sine pulse, ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1e3))]
    pub pulse_ms: Option<f64>,
    /// Measured deceleration of the vehicle, m/s^2, instead of the half sine; zero after its last
    /// sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pulse: Option<Profile>,
    /// Beginning of the crash, s.
    #[serde(default = "default::at_s")]
    #[schemars(range(min = 0.0, max = 1e3))]
    pub at_s: f64,
    /// Stiffness of the belt between torso and D-ring, N/m.
    #[schemars(range(min = 1e3, max = 1e7))]
    pub belt_stiffness_n_per_m: f64,
    /// Stiffness of the belt between D-ring and retractor, N/m.
    #[serde(default = "default::retractor_stiffness")]
    #[schemars(range(min = 1e3, max = 1e7))]
    pub retractor_stiffness_n_per_m: f64,
    /// Travel of the torso before the belt stretches, m.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.5))]
    pub slack_m: f64,
    /// Tension before the crash, from the spring of the retractor, N.
    #[serde(default = "default::pretension")]
    #[schemars(range(min = 0.1, max = 2e3))]
    pub pretension_n: f64,
    /// Actuator that reduces the friction.
    pub actuator: ActuatorKind,
    /// Peak velocity of a tangential tip, m/s.
    #[serde(default = "default::tip")]
    #[schemars(range(min = 1e-6, max = 1e3))]
    pub tip_m_per_s: f64,
    /// Power that the actuator `power` feeds into the contact, W.
    #[serde(default = "default::power")]
    #[schemars(range(min = 1e-3, max = 1e6))]
    pub power_w: f64,
    /// Direction in which the whole D-ring vibrates, for the actuators `ring` and `stack`: in the
    /// plane of the wrap, degrees from the outward normal at the middle of the wrap towards the
    /// shoulder. 0 is radial at the middle, 90 is along the webbing there. The law then depends on
    /// the angle of wrap.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = -180.0, max = 180.0))]
    pub ring_angle_deg: Option<f64>,
    /// Angle of that direction out of the plane of the wrap, towards the axis of the D-ring,
    /// degrees: 0 in the plane, 90 along the axis. Default: 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 90.0))]
    pub ring_axis_deg: Option<f64>,
    /// Assumed effect (default `none`) of the component of the ring's vibration across the webbing;
    /// the true effect lies between the two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ring_normal_part: Option<NormalPartKind>,
    /// Frequency of the ring's vibration, Hz, which determines its amplitude; with
    /// `ring_normal_part = "fitted"`. Default: 20 kHz.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 5e3, max = 2e5))]
    pub ring_hz: Option<f64>,
    /// Radius of the ring that the webbing bends around, m; with `ring_normal_part = "fitted"`.
    /// Default: 8 mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 0.1))]
    pub ring_radius_m: Option<f64>,
    /// Time that an actuator other than `stack` takes from OFF to ON and back, ms.
    #[serde(default = "default::edge")]
    #[schemars(range(min = 0.01, max = 1e3))]
    pub edge_ms: f64,
}

/// Size of the occupant, by percentile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Occupant {
    /// 5th percentile: a torso of 14 kg.
    #[serde(rename = "5th")]
    Light,
    /// 50th percentile: 22 kg.
    #[serde(rename = "50th")]
    Medium,
    /// 95th percentile: 29 kg.
    #[serde(rename = "95th")]
    Heavy,
}

impl Occupant {
    /// Returns the torso mass, kg, as assumed for the three sizes of adult dummies (5th percentile
    /// woman, 50th and 95th percentile man).
    pub fn torso_kg(self) -> f64 {
        match self {
            Occupant::Light => 14.0,
            Occupant::Medium => 22.0,
            Occupant::Heavy => 29.0,
        }
    }
}

/// Actuator that reduces the friction of the webbing on the D-ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ActuatorKind {
    /// A perfect switch, from `mu_high` to `mu_low` at any speed.
    Ideal,
    /// A tip that vibrates along the webbing, with Coulomb's law.
    Tangential,
    /// A tip that vibrates along the webbing, with the limit of Dahl's law for a soft contact.
    TangentialDahl,
    /// A tip that vibrates along the webbing, limited by its power.
    Power,
    /// The simulated stack, which vibrates along the webbing; with `ring_angle_deg` it moves the
    /// whole D-ring in that direction.
    Stack,
    /// The whole D-ring vibrates in one direction, `ring_angle_deg`, with the peak velocity
    /// `tip_m_per_s`; Coulomb's law applies at each point of the wrap.
    Ring,
    /// A vibration across the webbing, with a law that is fitted to slow belts and extrapolated.
    Normal,
}

/// Effect on friction of the component of a ring's vibration across the webbing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum NormalPartKind {
    /// No effect: exact for a contact that is stiff along the webbing and never lost.
    None,
    /// The friction ratio is multiplied by the law that is fitted to the belt of experiment 2,
    /// extrapolated.
    Fitted,
}

/// Vibration of a D-ring that vibrates as a whole (scenes with `ring_angle_deg`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingVibration {
    /// Direction in the plane of the wrap, degrees.
    pub angle_deg: f64,
    /// Angle out of that plane, degrees.
    pub axis_deg: f64,
    /// Frequency, Hz, and radius of the ring, m, if the component across the webbing has the fitted
    /// law.
    pub fitted: Option<(f64, f64)>,
}

impl Dring {
    /// Returns the vibration of the whole D-ring, or `None` if it does not vibrate as a whole.
    pub fn ring_vibration(&self) -> Option<RingVibration> {
        let fitted = self.ring_normal_part == Some(NormalPartKind::Fitted);
        let numbers = (self.ring_hz.unwrap_or(RING_HZ), self.ring_radius_m.unwrap_or(RING_RADIUS_M));
        self.ring_angle_deg.map(|angle_deg| RingVibration {
            angle_deg,
            axis_deg: self.ring_axis_deg.unwrap_or(0.0),
            fitted: fitted.then_some(numbers),
        })
    }

    /// Returns the mass of the torso, kg.
    pub fn torso_mass_kg(&self) -> f64 {
        self.torso_kg.unwrap_or_else(|| self.occupant.torso_kg())
    }

    /// Returns the length of the pulse, s.
    pub fn pulse_s(&self) -> f64 {
        let measured = self.pulse.as_ref().and_then(|pulse| pulse.played().last());
        measured.map_or(1e-3 * self.pulse_ms.unwrap_or(0.0), |(time_s, _)| time_s)
    }

    /// Returns the torso mass that the seat measures, kg.
    pub fn seat_reading_kg(&self) -> Option<f64> {
        self.seat_reads.then(|| self.torso_mass_kg() * (1.0 + self.seat_error))
    }
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn seat_reads() -> bool {
        true
    }
    pub(super) fn at_s() -> f64 {
        0.06
    }
    pub(super) fn retractor_stiffness() -> f64 {
        200e3
    }
    pub(super) fn pretension() -> f64 {
        5.0
    }
    pub(super) fn tip() -> f64 {
        5.0
    }
    pub(super) fn power() -> f64 {
        2500.0
    }
    pub(super) fn edge() -> f64 {
        3.0
    }
}
