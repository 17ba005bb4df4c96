//! `[excitation]`: a contact study, in which a prescribed force or velocity replaces the driven
//! stack.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Profile;

/// A contact study (thesis chapter 4): a prescribed force or velocity vibrates the contact,
/// without controller, converters and stack. Give exactly one of `velocity_ratio` and
/// `sliding_m_per_s`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Excitation {
    /// Waveform of the excitation over time.
    pub waveform: Waveform,
    /// Peak force F0 on the mass of `rig.sdof`, N. With a measured waveform: reference of the
    /// ratios.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e9))]
    pub force_n: Option<f64>,
    /// Frequency, Hz. For random, chirp and measured: reference of periods and of the velocity
    /// ratio.
    #[schemars(range(min = 1e-3, max = 1e8))]
    pub frequency_hz: f64,
    /// Sliding speed divided by vibration velocity, Vt / Vv.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e6))]
    pub velocity_ratio: Option<f64>,
    /// Vibration velocity Vv that `velocity_ratio` refers to.
    #[serde(default)]
    pub velocity_ratio_of: VibrationVelocity,
    /// Sliding speed Vt, m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e4))]
    pub sliding_m_per_s: Option<f64>,
    /// Quantity that is equal between waveforms, the peak or the root mean square of a sine with
    /// that peak.
    #[serde(default, rename = "match")]
    pub matched: Match,
    /// Time for which each value of a random waveform is held, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e5))]
    pub hold_time_s: Option<f64>,
    /// First frequency of a chirp, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e8))]
    pub start_hz: Option<f64>,
    /// Last frequency of a chirp, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e8))]
    pub stop_hz: Option<f64>,
    /// Duration of the sweep of a chirp, s; after it the frequency is constant. Default: the whole
    /// run.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e5))]
    pub sweep_s: Option<f64>,
    /// Measured waveform: the velocity of `rig.kinematic`, m/s, or the force on the mass of
    /// `rig.sdof`, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub profile: Option<Profile>,
    /// Angle of the vibration of `rig.kinematic` to the sliding, in the plane of the contact: 0
    /// along the sliding, 90 across it.
    #[serde(default, skip_serializing_if = "is_along")]
    #[schemars(range(min = 0.0, max = 90.0))]
    pub angle_deg: f64,
    /// Displacement at the beginning, m.
    #[serde(default)]
    #[schemars(range(min = -1e3, max = 1e3))]
    pub x0_m: f64,
    /// Velocity at the beginning, m/s.
    #[serde(default)]
    #[schemars(range(min = -1e4, max = 1e4))]
    pub v0_m_per_s: f64,
    /// Friction at the beginning, N; for a LuGre contact, the force in the bristles.
    #[serde(default)]
    #[schemars(range(min = -1e9, max = 1e9))]
    pub friction0_n: f64,
}

fn is_along(angle_deg: &f64) -> bool {
    *angle_deg == 0.0
}

/// Waveforms of an excitation over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Waveform {
    /// Cosine of constant amplitude.
    Sine,
    /// Square of duty one half.
    Square,
    /// Rising sawtooth of constant amplitude.
    Sawtooth,
    /// Symmetric triangle of constant amplitude.
    Triangle,
    /// Uniformly distributed values, each held for `hold_time_s`.
    Random,
    /// Linear chirp from `start_hz` to `stop_hz`.
    Chirp,
    /// As measured: `profile`.
    Measured,
    /// No excitation.
    Still,
}

/// Quantity that is equal between waveforms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Match {
    /// The peak.
    #[default]
    Peak,
    /// The root mean square.
    Rms,
}

/// Vibration velocity that a velocity ratio refers to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum VibrationVelocity {
    /// The steady forced amplitude of a sine of this force and frequency, w F0 / |Ks - m w^2 + i w
    /// c|.
    #[default]
    Steady,
    /// The largest velocity of the run without friction.
    Peak,
}
