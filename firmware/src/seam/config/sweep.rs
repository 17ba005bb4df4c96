//! Sweep of the frequency in a run.

use config_macro::settings;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Choice, Config, Optional, Parameter, Range, keys};

/// Sweep of the frequency in a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Sweep {
    /// The frequency is the tracked one, or the nominal one.
    #[default]
    Hold,
    /// The frequency follows a chirp.
    Chirp(Chirp),
}

/// Chirp in a run.
#[settings(table = "sweep", scene = Sweep, optional)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chirp {
    /// Law of the frequency from one end to the other.
    #[setting(default, key = 69)]
    pub kind: ChirpKind,
    /// Start frequency, Hz; about a resonance, the offset from it.
    #[setting(min = -450e3, max = 450e3, key = 70)]
    pub start_hz: f32,
    /// End frequency, Hz; about a resonance, the offset from it.
    #[setting(min = -450e3, max = 450e3, key = 71)]
    pub stop_hz: f32,
    /// Duration of the chirp, s; rounded to whole blocks.
    #[setting(min = 1e-5, max = 1e5)]
    pub time_s: f64,
    /// Behaviour after the end of the chirp.
    #[setting(default, key = 72)]
    pub then: Then,
    /// Reference of the frequencies.
    #[setting(default, key = 73)]
    pub around: Around,
}

impl Chirp {
    /// Duration as a parameter; zero means no chirp. Rounded to single precision.
    pub(crate) const TIME: &'static [Parameter] = &[Parameter {
        key: keys::SWEEP_TIME,
        name: Self::TIME_S.name,
        range: Range::Within(0.0, Self::TIME_S.max as f32),
        read: |config| Chirp::of(config).map_or(0.0, |chirp| chirp.time_s as f32),
        write: |config, value| {
            let time_s = value.into();
            match Chirp::of_mut(config) {
                _ if value == 0.0 => config.sweep = Sweep::Hold,
                Some(chirp) => chirp.time_s = time_s,
                None => config.sweep = Sweep::Chirp(Chirp { time_s, ..Chirp::DEFAULT }),
            }
        },
    }];
}

impl Optional for Chirp {
    const DEFAULT: Self =
        Chirp { kind: ChirpKind::Linear, start_hz: 0.0, stop_hz: 0.0, time_s: 0.0, then: Then::Hold, around: Around::Zero };

    fn of(config: &Config) -> Option<&Self> {
        if let Sweep::Chirp(chirp) = &config.sweep { Some(chirp) } else { None }
    }

    fn of_mut(config: &mut Config) -> Option<&mut Self> {
        if let Sweep::Chirp(chirp) = &mut config.sweep { Some(chirp) } else { None }
    }
}

/// Law of the frequency in a chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum ChirpKind {
    /// The frequency changes by equal steps.
    #[default]
    Linear,
    /// The frequency changes by equal ratios.
    Exponential,
}

/// Behaviour after the end of a chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Then {
    /// The last frequency is held.
    #[default]
    Hold,
    /// The same chirp is repeated.
    Repeat,
    /// The chirp runs back and forth.
    UpDown,
}

/// Reference of the frequencies of a chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Around {
    /// Frequencies are absolute. Nothing is tracked.
    #[default]
    Zero,
    /// Frequencies are offsets from the resonance, which is tracked during the chirp. Linear only.
    Resonance,
}

impl Choice for ChirpKind {
    const ALL: &'static [Self] = &[ChirpKind::Linear, ChirpKind::Exponential];
    const NAMES: &'static [&'static str] = &["linear", "exponential"];
}

impl Choice for Then {
    const ALL: &'static [Self] = &[Then::Hold, Then::Repeat, Then::UpDown];
    const NAMES: &'static [&'static str] = &["hold", "repeat", "updown"];
}

impl Choice for Around {
    const ALL: &'static [Self] = &[Around::Zero, Around::Resonance];
    const NAMES: &'static [&'static str] = &["zero", "resonance"];
}
