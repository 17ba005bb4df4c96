//! Settings of the friction switch.

use config_macro::settings;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Setting, Tracking};
use crate::seam::block::Target;
use crate::seam::error::Error;

/// The friction switch: the set point of the friction, and the nominal contact. The switch sets amplitude and bursts, up to
/// the drive's amplitude, which is its maximum.
#[settings(table = "friction", scene = Friction)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Friction {
    /// Set point of the friction until an order changes it.
    #[setting(controller)]
    pub target: Target,
    /// Set point of the friction, as a part of that without vibration.
    #[setting(scene, min = 0.0, max = 1.0)]
    pub target_ratio: Option<f32>,
    /// Set point of the friction, N. Needs `sensors.force_hz`.
    #[setting(scene, min = 0.0, max = 1e6)]
    pub target_force_n: Option<f32>,
    /// Times at which other friction ratios are ordered, s.
    #[setting(scene, min = 0.0, max = 1e5)]
    pub step_s: Vec<f32>,
    /// Friction ratios that are ordered at these times.
    #[setting(scene, min = 0.0, max = 1.0)]
    pub step_ratio: Vec<f32>,
    /// The friction law that is inverted.
    #[setting(default)]
    pub law: FrictionLaw,
    /// What is preferred where amplitude and bursts are both possible. Bursts need `burst.period_s`; their duty is set by the switch.
    #[setting(default)]
    pub prefer: Prefer,
    /// Amperes of motional current per m/s of tip velocity: the force factor, N/V.
    #[setting(controller)]
    pub force_factor_n_per_v: f32,
    /// Nominal sliding speed, m/s, where no encoder measures it.
    #[setting(min = 1e-6, max = 100.0)]
    pub speed_m_per_s: f32,
    /// Nominal Dahl length Fc / Kt, m, where no force channel allows a survey.
    #[setting(default = 0.5e-6, min = 1e-9, max = 1e-3)]
    pub dahl_length_m: f32,
    /// For how long the force is averaged at each place of the survey, s.
    #[setting(default = 0.05, min = 1e-3, max = 100.0)]
    pub average_s: f32,
}

impl Friction {
    /// The force factor is what the user knows of the transducer.
    pub(crate) const FORCE_FACTOR_N_PER_V: Setting =
        Setting { name: "friction.force_factor_n_per_v", ..Tracking::NOMINAL_FORCE_FACTOR_N_PER_V };

    /// Whether every value is within its range, with those that the controller alone has.
    pub(crate) fn check_all(&self) -> Result<(), Error> {
        self.check()?;
        Self::FORCE_FACTOR_N_PER_V.check(self.force_factor_n_per_v)?;
        match self.target {
            Target::Ratio(ratio) => Self::TARGET_RATIO.check(ratio),
            Target::Force(newtons) => Self::TARGET_FORCE_N.check(newtons),
        }
    }
}

/// The friction law that is inverted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum FrictionLaw {
    /// Dahl's, with the stiffness that the survey finds.
    #[default]
    Dahl,
    // With it the ratio of a soft contact is up to 0.39 above its target.
    /// Coulomb's, the reference that is shown to err.
    Coulomb,
}

/// What is preferred where amplitude and bursts are both possible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Prefer {
    /// Amplitude, but for the velocity threshold.
    #[default]
    Amplitude,
    /// Bursts, where their duty allows them.
    Bursts,
}
