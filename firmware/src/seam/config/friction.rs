//! Settings of the friction switch.

use config_macro::settings;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Choice, Config, Optional, Parameter, Setting, Tracking};
use crate::seam::block::Target;
use crate::seam::error::Error;

/// The friction switch: the set point of the friction, and the nominal contact. The switch sets amplitude and bursts, up to
/// the drive's amplitude, which is its maximum.
#[settings(table = "friction", scene = Friction, optional)]
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
    #[setting(default, key = 77)]
    pub law: FrictionLaw,
    /// What is preferred where amplitude and bursts are both possible. Bursts need `burst.period_s`; their duty is set by the switch.
    #[setting(default, key = 78)]
    pub prefer: Prefer,
    /// Amperes of motional current per m/s of tip velocity: the force factor, N/V.
    #[setting(controller)]
    pub force_factor_n_per_v: f32,
    /// Nominal sliding speed, m/s, where no encoder measures it.
    #[setting(min = 1e-6, max = 100.0, key = 80)]
    pub speed_m_per_s: f32,
    /// Nominal Dahl length Fc / Kt, m, where no force channel allows a survey.
    #[setting(default = 0.5e-6, min = 1e-9, max = 1e-3, key = 81)]
    pub dahl_length_m: f32,
    /// For how long the force is averaged at each place of the survey, s.
    #[setting(default = 0.05, min = 1e-3, max = 100.0, key = 82)]
    pub average_s: f32,
    /// Distance of two detents of a knob, m: towards each the friction rises from its set point to `detent_ratio`, and falls again. Zero: there are
    /// none. Needs `sensors.encoder_counts_per_mm`, by which the knob's position counts from power-up.
    #[setting(default = 0.0, min = 0.0, max = 10.0, key = 96)]
    pub detent_pitch_m: f32,
    /// Friction at a detent, as a part of that without vibration.
    #[setting(default = 1.0, min = 0.0, max = 1.0, key = 97)]
    pub detent_ratio: f32,
}

impl Friction {
    /// The force factor is what the user knows of the transducer.
    pub(crate) const FORCE_FACTOR_N_PER_V: Setting =
        Setting { name: "friction.force_factor_n_per_v", ..Tracking::NOMINAL_FORCE_FACTOR_N_PER_V };

    /// Parameters that are no field of a scene. A set point is of one kind: zero is that it is of the other.
    pub(crate) const OTHERS: &'static [Parameter] = &[
        Parameter {
            key: 75,
            name: Self::TARGET_RATIO.name,
            range: Self::TARGET_RATIO.range(),
            read: |config| if let Target::Ratio(ratio) = of(config).target { ratio } else { 0.0 },
            write: |config, value| set(config, |friction| friction.target = Target::Ratio(value)),
        },
        Parameter {
            key: 76,
            name: Self::TARGET_FORCE_N.name,
            range: Self::TARGET_FORCE_N.range(),
            read: |config| if let Target::Force(newtons) = of(config).target { newtons } else { 0.0 },
            write: |config, value| set(config, |friction| friction.target = Target::Force(value)),
        },
        Parameter {
            key: 79,
            name: Self::FORCE_FACTOR_N_PER_V.name,
            range: Self::FORCE_FACTOR_N_PER_V.range(),
            read: |config| of(config).force_factor_n_per_v,
            write: |config, value| set(config, |friction| friction.force_factor_n_per_v = value),
        },
    ];

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

/// The friction switch of a configuration, or that of its defaults.
fn of(config: &Config) -> &Friction {
    Friction::of(config).unwrap_or(&Friction::DEFAULT)
}

/// Changes the friction switch of a configuration, if it has one.
fn set(config: &mut Config, change: impl FnOnce(&mut Friction)) {
    if let Some(friction) = Friction::of_mut(config) {
        change(friction);
    }
}

impl Optional for Friction {
    /// With force factor and speed of the prototype.
    const DEFAULT: Self = Friction {
        target: Target::Ratio(1.0),
        law: FrictionLaw::Dahl,
        prefer: Prefer::Amplitude,
        force_factor_n_per_v: 5.566,
        speed_m_per_s: 0.038,
        dahl_length_m: 0.5e-6,
        average_s: 0.05,
        detent_pitch_m: 0.0,
        detent_ratio: 1.0,
    };

    fn of(config: &Config) -> Option<&Self> {
        config.friction.as_ref()
    }

    fn of_mut(config: &mut Config) -> Option<&mut Self> {
        config.friction.as_mut()
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

impl Choice for FrictionLaw {
    const ALL: &'static [Self] = &[FrictionLaw::Dahl, FrictionLaw::Coulomb];
    const NAMES: &'static [&'static str] = &["dahl", "coulomb"];
}

impl Choice for Prefer {
    const ALL: &'static [Self] = &[Prefer::Amplitude, Prefer::Bursts];
    const NAMES: &'static [&'static str] = &["amplitude", "bursts"];
}
