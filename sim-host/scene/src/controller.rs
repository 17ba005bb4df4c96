//! `[controller]`: the firmware that drives, and what it is told.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Friction;
use super::limits::{Limits, Thermometer};
use super::restraint::Restraint;

/// The firmware that drives, and what it is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// Samples in a block.
    #[serde(default = "default::block_samples")]
    #[schemars(range(min = 8, max = 64))]
    pub block_samples: u16,
    /// The drive.
    pub drive: Drive,
    /// A chirp while running. Without it the frequency is the tracked one, or stays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sweep: Option<Sweep>,
    /// Lane offsets and trims of a multi-phase drive.
    #[serde(default)]
    pub phasing: Phasing,
    /// When the drive is ON. Without it: always, once locked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst: Option<Burst>,
    /// The friction that is wanted. Without it amplitude and bursts are what they are told to be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
    /// How the frequency is found and kept, and what a user knows of the transducer beforehand.
    pub tracking: Tracking,
    /// The stack as a thermometer of itself.
    #[serde(default, skip_serializing_if = "Thermometer::is_none")]
    pub thermometer: Thermometer,
    /// What must never be exceeded.
    #[serde(default)]
    pub limits: Limits,
    /// When a crash makes the friction of a D-ring LOW, in place of a burst. For scenes with `[rig.dring]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restraint: Option<Restraint>,
}

/// The drive. Give exactly one of `amplitude_v` and `velocity_m_per_s`; with `rig.belt`, which has its amplitude, neither.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Nominal frequency: the centre of the scan, Hz.
    #[schemars(range(min = 100.0, max = 450e3))]
    pub frequency_hz: f64,
    /// Peak voltage, V.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e4))]
    pub amplitude_v: Option<f64>,
    /// Peak tip velocity, held by the motional-current loop, m/s. Needs `tracking.nominal_force_factor_n_per_v`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 100.0))]
    pub velocity_m_per_s: Option<f64>,
    /// Peak voltage of self-test and scan, V. Default: `amplitude_v`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e4))]
    pub scan_v: Option<f64>,
    /// How far beside the resonance to drive while running, Hz; beside `frequency_hz` where nothing is tracked.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -450e3, max = 450e3))]
    pub detune_hz: f64,
    /// Waveform while running.
    #[serde(default)]
    pub shape: Shape,
    /// Lower end of a noise's band, Hz. Default: 0.75 of `frequency_hz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 100.0, max = 450e3))]
    pub noise_low_hz: Option<f64>,
    /// Upper end of a noise's band, Hz. Default: 1.25 of `frequency_hz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 100.0, max = 450e3))]
    pub noise_high_hz: Option<f64>,
    /// Adds random steps of up to one code before rounding, so that rounding leaves noise in place of harmonics.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub dither: bool,
    /// Drive lanes; the stack hangs on the first.
    #[serde(default = "default::lanes")]
    #[schemars(range(min = 1, max = 4))]
    pub lanes: u8,
}

/// Waveform while running; self-test and scan are by sines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Sine.
    #[default]
    Sine,
    /// Square, band-limited.
    Square,
    /// Sawtooth, rising, band-limited.
    Sawtooth,
    /// Gaussian noise within a band, clipped at the peak, which is four times its rms. Nothing can be tracked by it.
    Noise,
}

/// A chirp while running.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// How it gets from one end to the other.
    #[serde(default)]
    pub kind: ChirpKind,
    /// Where it begins, Hz; about a resonance, as an offset from it.
    #[schemars(range(min = -450e3, max = 450e3))]
    pub start_hz: f64,
    /// Where it ends, Hz.
    #[schemars(range(min = -450e3, max = 450e3))]
    pub stop_hz: f64,
    /// How long that takes, s; whole blocks.
    #[schemars(range(min = 1e-5, max = 1e5))]
    pub time_s: f64,
    /// What follows.
    #[serde(default)]
    pub then: Then,
    /// What the frequencies count from.
    #[serde(default)]
    pub around: Around,
}

/// How a chirp gets from one end to the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ChirpKind {
    /// By equal steps.
    #[default]
    Linear,
    /// By equal ratios.
    Exponential,
}

/// What follows the end of a chirp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Then {
    /// The last frequency.
    #[default]
    Hold,
    /// The same chirp again.
    Repeat,
    /// The way back, and so on.
    Updown,
}

/// What the frequencies of a chirp count from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Around {
    /// From 0 Hz. Nothing is tracked.
    #[default]
    Zero,
    /// From the resonance, which is tracked meanwhile. Linear only.
    Resonance,
}

/// Lane offsets and trims of a multi-phase drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Phasing {
    /// Turning direction.
    #[serde(default)]
    pub direction: Direction,
    /// How far lanes 1 and 3 lead lanes 0 and 2, turns: a quarter runs forward, zero stands. Takes the place of `direction`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = -0.25, max = 0.25))]
    pub quadrature_turns: Option<f64>,
    /// Phase correction of each lane, turns.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 4), inner(range(min = -0.5, max = 0.5)))]
    pub phase_trim_turns: Vec<f64>,
    /// Gain correction of each lane.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 4), inner(range(min = 0.0, max = 2.0)))]
    pub gain_trim: Vec<f64>,
    /// First measure what each lane adds, and trim the lanes by it; then run. The controller listens to one lane after the other, at
    /// `drive.scan_v` and over the window of `tracking.span`. Windows of a burst count from the first sample all the same.
    #[serde(default)]
    pub calibrate: bool,
}

/// Turning direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Lane 1 leads lane 0.
    #[default]
    Forward,
    /// Lane 0 leads lane 1.
    Reverse,
}

/// When the drive is ON, counted from the first sample. Give either windows (`on_s` and `off_s`) or `period_s` and `duty`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Burst {
    /// Beginnings of the ON windows, s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 8), inner(range(min = 0.0, max = 1e5)))]
    pub on_s: Vec<f64>,
    /// Their ends, s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 8), inner(range(min = 0.0, max = 1e5)))]
    pub off_s: Vec<f64>,
    /// Period of a repeated burst, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-5, max = 1e5))]
    pub period_s: Option<f64>,
    /// Part of the period that is ON.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub duty: Option<f64>,
    /// How the envelope gets there.
    #[serde(default)]
    pub edge: Edge,
    /// Length of a soft edge, drive periods.
    #[serde(default = "default::edge_cycles")]
    #[schemars(range(min = 0.5, max = 1e4))]
    pub edge_cycles: f64,
    /// What has rung up is rung down at the end of each burst, by drive against it within `limits.voltage_v`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub brake: bool,
}

/// How the envelope gets from OFF to ON and back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Edge {
    /// At once.
    #[default]
    Hard,
    /// Along a raised cosine.
    Soft,
    /// As fast as `limits.voltage_v` allows, up by louder drive and down by drive against what rings. For sines whose resonance is tracked.
    Boost,
}

/// How the frequency is found and kept. The nominal values are what a user knows beforehand, not the truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Tracking {
    /// What is tracked.
    #[serde(default)]
    pub mode: TrackingMode,
    /// Frequency window on each side, as a fraction of the nominal frequency.
    #[serde(default = "default::span")]
    #[schemars(range(min = 1e-4, max = 0.2))]
    pub span: f64,
    /// Bandwidth of the phase loop, Hz.
    #[serde(default = "default::bandwidth_hz")]
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub bandwidth_hz: f64,
    /// Quality factor, within a factor of two.
    #[schemars(range(min = 2.0, max = 1e5))]
    pub nominal_q: f64,
    /// Motional inductance, H, within a tenth. Default: what the power-on calibration finds.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e4))]
    pub nominal_lm_h: Option<f64>,
    /// Clamped capacitance, F.
    #[schemars(range(min = 1e-12, max = 1e-3))]
    pub nominal_c0_f: f64,
    /// How fast the clamped capacitance may drift, relative, per second: the observer then measures it anew while running, as often as that demands,
    /// by small steps of the frequency. Zero: never.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub c0_drift_per_s: f64,
    /// Force factor, N/V: tip force per volt, and ampere of motional current per m/s of tip velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 1e4))]
    pub nominal_force_factor_n_per_v: Option<f64>,
}

/// What is tracked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrackingMode {
    /// The resonance itself, from how the motional current changes: does not wait for the ring-up, and needs no scan.
    #[default]
    Observer,
    /// The phase of the motional current, after a scan: the series resonance, at any load.
    PhaseLock,
    /// The phase of the total current: the plain V-I loop, the reference that fails under load.
    ZeroPhase,
    /// Nothing: the nominal frequency is held.
    Off,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn block_samples() -> u16 {
        32
    }
    pub(super) fn lanes() -> u8 {
        1
    }
    pub(super) fn edge_cycles() -> f64 {
        5.0
    }
    pub(super) fn span() -> f64 {
        0.025
    }
    pub(super) fn bandwidth_hz() -> f64 {
        200.0
    }
}
