//! What the frequency does while running.

use config_macro::settings;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the frequency does while running.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Sweep {
    /// The frequency stays where it is tracked, or where it was put.
    #[default]
    Hold,
    /// The frequency follows a chirp.
    Chirp(Chirp),
}

/// A chirp while running.
#[settings(table = "sweep", scene = Sweep)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chirp {
    /// How it gets from one end to the other.
    #[setting(default)]
    pub kind: ChirpKind,
    /// Where it begins, Hz; about a resonance, as an offset from it.
    #[setting(min = -450e3, max = 450e3)]
    pub start_hz: f32,
    /// Where it ends, Hz.
    #[setting(min = -450e3, max = 450e3)]
    pub stop_hz: f32,
    /// How long that takes, s; whole blocks.
    #[setting(min = 1e-5, max = 1e5)]
    pub time_s: f64,
    /// What follows the end of the chirp.
    #[setting(default)]
    pub then: Then,
    /// What the frequencies count from.
    #[setting(default)]
    pub around: Around,
}

/// How a chirp gets from one end to the other.
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

/// What follows the end of a chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Then {
    /// The last frequency is held.
    #[default]
    Hold,
    /// The same chirp is repeated.
    Repeat,
    /// The way back, and so on.
    UpDown,
}

/// What the frequencies of a chirp count from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Around {
    /// From 0 Hz. Nothing is tracked.
    #[default]
    Zero,
    /// From the resonance, which is tracked meanwhile. Linear only.
    Resonance,
}
