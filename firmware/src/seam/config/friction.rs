//! Settings of the friction switch.

use config_macro::settings;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Choice, Config, Optional, Parameter, Setting, Tracking};
use crate::seam::block::Target;
use crate::seam::error::Error;

/// Friction switch: the friction set point, and the nominal contact. The switch sets amplitude and
/// bursts, up to the drive's amplitude.
#[settings(table = "friction", scene = Friction, optional)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Friction {
    /// Friction set point until an order changes it.
    #[setting(controller)]
    pub target: Target,
    /// Friction set point, relative to the friction without vibration.
    #[setting(scene, min = 0.0, max = 1.0)]
    pub target_ratio: Option<f32>,
    /// Friction set point, N. Needs `sensors.force_hz`.
    #[setting(scene, min = 0.0, max = 1e6)]
    pub target_force_n: Option<f32>,
    /// Times at which other friction ratios are ordered, s.
    #[setting(scene, min = 0.0, max = 1e5)]
    pub step_s: Vec<f32>,
    /// Friction ratios ordered at the times of `step_s`.
    #[setting(scene, min = 0.0, max = 1.0)]
    pub step_ratio: Vec<f32>,
    /// Friction law that is inverted.
    #[setting(default, key = 77)]
    pub law: FrictionLaw,
    /// Preferred means if amplitude and bursts are both possible. Bursts need `burst.period_s`; the
    /// switch sets their duty.
    #[setting(default, key = 78)]
    pub prefer: Prefer,
    /// Force factor, N/V: motional current per tip velocity.
    #[setting(controller)]
    pub force_factor_n_per_v: f32,
    /// Nominal sliding speed, m/s, if no encoder measures it.
    #[setting(min = 1e-6, max = 100.0, key = 80)]
    pub speed_m_per_s: f32,
    /// Nominal Dahl length Fc / Kt, m, if no force channel allows a survey.
    #[setting(default = 0.5e-6, min = 1e-9, max = 1e-3, key = 81)]
    pub dahl_length_m: f32,
    /// Averaging time of the force at each point of the survey, s.
    #[setting(default = 0.05, min = 1e-3, max = 100.0, key = 82)]
    pub average_s: f32,
    /// Distance between two detents of a knob, m. Towards each detent the friction rises from its
    /// set point to `detent_ratio`, then falls again. Zero: no detents. Needs
    /// `sensors.encoder_counts_per_mm`; the knob's position counts from power-up.
    #[setting(default = 0.0, min = 0.0, max = 10.0, key = 96)]
    pub detent_pitch_m: f32,
    /// Friction at a detent, relative to the friction without vibration.
    #[setting(default = 1.0, min = 0.0, max = 1.0, key = 97)]
    pub detent_ratio: f32,
}

impl Friction {
    /// Force factor as configured for the transducer, N/V.
    pub(crate) const FORCE_FACTOR_N_PER_V: Setting =
        Setting { name: "friction.force_factor_n_per_v", ..Tracking::NOMINAL_FORCE_FACTOR_N_PER_V };

    /// Parameters that are not a field of a scene. The set point is a ratio or a force; the other
    /// one reads as zero.
    pub(crate) const OTHERS: &'static [Parameter] = &[
        Parameter {
            key: 75,
            name: Self::TARGET_RATIO.name,
            range: Self::TARGET_RATIO.range(),
            read: |config| if let Target::Ratio(ratio) = configured(config).target { ratio } else { 0.0 },
            write: |config, value| set(config, |friction| friction.target = Target::Ratio(value)),
        },
        Parameter {
            key: 76,
            name: Self::TARGET_FORCE_N.name,
            range: Self::TARGET_FORCE_N.range(),
            read: |config| if let Target::Force(newtons) = configured(config).target { newtons } else { 0.0 },
            write: |config, value| set(config, |friction| friction.target = Target::Force(value)),
        },
        Parameter {
            key: 79,
            name: Self::FORCE_FACTOR_N_PER_V.name,
            range: Self::FORCE_FACTOR_N_PER_V.range(),
            read: |config| configured(config).force_factor_n_per_v,
            write: |config, value| set(config, |friction| friction.force_factor_n_per_v = value),
        },
    ];

    /// Checks that every value is within its range, including those that only the controller has.
    pub(crate) fn check_all(&self) -> Result<(), Error> {
        self.check()?;
        Self::FORCE_FACTOR_N_PER_V.check(self.force_factor_n_per_v)?;
        match self.target {
            Target::Ratio(ratio) => Self::TARGET_RATIO.check(ratio),
            Target::Force(newtons) => Self::TARGET_FORCE_N.check(newtons),
        }
    }
}

/// Returns the friction switch of a configuration, or the default one.
fn configured(config: &Config) -> &Friction {
    Friction::of(config).unwrap_or(&Friction::DEFAULT)
}

/// Changes the friction switch of a configuration, if it has one.
fn set(config: &mut Config, change: impl FnOnce(&mut Friction)) {
    if let Some(friction) = Friction::of_mut(config) {
        change(friction);
    }
}

impl Optional for Friction {
    /// Defaults, with force factor and speed of the prototype.
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

/// Friction law that is inverted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum FrictionLaw {
    /// Dahl's law, with the stiffness found by the survey.
    #[default]
    Dahl,
    // With it the ratio of a soft contact is up to 0.39 above its target.
    /// Coulomb's law, as a reference: it is wrong for soft contacts.
    Coulomb,
}

/// Preferred means if amplitude and bursts are both possible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Prefer {
    /// Amplitude, except at the velocity threshold.
    #[default]
    Amplitude,
    /// Bursts, if their duty allows it.
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
