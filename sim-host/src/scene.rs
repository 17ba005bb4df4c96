//! A scene: everything a run needs, as one TOML file. The same file is command-line input, test case and snapshot.
//!
//! These types are the one description of what a scene may say. The JSON Schema, the checks on keys, types and ranges, and
//! the comments of `sim-host show` are all derived from them; [`rules`] adds what a schema cannot say.

pub mod builtin;
pub mod diagnostic;
pub mod load;
pub mod resolved;
pub mod rules;
pub mod schema;

mod nearest;
mod overlay;
mod tree;
mod units;
mod unknown;
mod walk;

#[cfg(test)]
mod tests;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// One line that says what the scene shows.
    pub title: String,
    /// Where its numbers come from.
    #[serde(default)]
    pub source: String,
    /// What a reader of the report should know, a paragraph each: what was chosen, and why.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Simulated time, s.
    #[schemars(range(min = 1e-4, max = 1e5))]
    pub duration_s: f64,
    /// Seed of all noise: the same seed gives the same run, bit for bit.
    #[serde(default = "default::seed")]
    #[schemars(range(max = 9_007_199_254_740_992_u64))] // every JSON reader keeps it exactly
    pub seed: u64,
    /// The firmware that drives, and what it is told.
    pub controller: Controller,
    /// The power amplifier between DAC and stack.
    #[serde(default)]
    pub amplifier: Amplifier,
    /// The converters and the load cell.
    #[serde(default)]
    pub sensors: Sensors,
    /// The piezo stack.
    pub stack: Stack,
    /// The friction contact at the stack's tip. Needs a rig that presses on it and moves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<Contact>,
    /// What presses on the contact and moves it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rig: Option<Rig>,
    /// What changes on the way.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disturbance: Vec<Disturbance>,
    /// What breaks on the way.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fault: Vec<Fault>,
    /// A table of one metric over two keys, run after the scene itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<Grid>,
    /// What is recorded besides the standard figures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trace: Option<Trace>,
    /// What must come out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub expect: Vec<Expect>,
}

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
    /// Lane offsets and trims of a multi-phase drive.
    #[serde(default)]
    pub phasing: Phasing,
    /// When the drive is ON. Without it: always, once locked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burst: Option<Burst>,
    /// How the frequency is found and kept, and what a user knows of the transducer beforehand.
    pub tracking: Tracking,
    /// What must never be exceeded.
    #[serde(default)]
    pub limits: Limits,
}

/// The drive. Give exactly one of `amplitude_v` and `velocity_m_per_s`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Nominal frequency: the centre of the scan, Hz.
    #[schemars(range(min = 100.0, max = 450e3))]
    pub frequency_hz: f64,
    /// Peak voltage, V.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e4))]
    pub amplitude_v: Option<f64>,
    /// Peak tip velocity, held by the motional-current loop, m/s. Needs `tracking.nominal_force_factor_n_per_v`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub velocity_m_per_s: Option<f64>,
    /// Peak voltage of self-test and scan, V. Default: `amplitude_v`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-3, max = 1e4))]
    pub scan_v: Option<f64>,
    /// Waveform of one period.
    #[serde(default)]
    pub shape: Shape,
    /// Drive lanes; the stack hangs on the first.
    #[serde(default = "default::lanes")]
    #[schemars(range(min = 1, max = 4))]
    pub lanes: u8,
}

/// Waveform of one period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Sine.
    #[default]
    Sine,
    /// Square, band-limited.
    Square,
}

/// Lane offsets and trims of a multi-phase drive.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Phasing {
    /// Turning direction.
    #[serde(default)]
    pub direction: Direction,
    /// Phase correction of each lane, turns.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 4), inner(range(min = -0.5, max = 0.5)))]
    pub phase_trim_turns: Vec<f64>,
    /// Gain correction of each lane.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 4), inner(range(min = 0.0, max = 2.0)))]
    pub gain_trim: Vec<f64>,
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
    /// Clamped capacitance, F.
    #[schemars(range(min = 1e-12, max = 1e-3))]
    pub nominal_c0_f: f64,
    /// Force factor, N/V: tip force per volt, and ampere of motional current per m/s of tip velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 1e4))]
    pub nominal_force_factor_n_per_v: Option<f64>,
}

/// What is tracked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrackingMode {
    /// The phase of the motional current: the series resonance, at any load.
    #[default]
    PhaseLock,
    /// The phase of the total current: the plain V-I loop, the reference that fails under load.
    ZeroPhase,
    /// Nothing: the nominal frequency is held.
    Off,
}

/// What must never be exceeded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Peak drive voltage, V.
    #[schemars(range(min = 1e-3, max = 1e4))]
    pub voltage_v: f64,
    /// Peak current, A.
    #[schemars(range(min = 1e-6, max = 1e3))]
    pub current_a: f64,
    /// Slowest belt that counts as moving, m/s.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub belt_moving_m_per_s: f64,
    /// How long the drive may stay ON over a stopped belt, ms.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub belt_stop_ms: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { voltage_v: 15.466, current_a: 3.0, belt_moving_m_per_s: 0.001, belt_stop_ms: 4.0 }
    }
}

/// The power amplifier: second-order Butterworth low-pass and a source resistance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Amplifier {
    /// Output at the DAC's end of range, V; the range is this much on each side.
    #[schemars(range(min = 0.1, max = 1e4))]
    pub full_scale_v: f64,
    /// Corner frequency, Hz.
    #[schemars(range(min = 1e3, max = 1e7))]
    pub bandwidth_hz: f64,
    /// Source resistance, ohm.
    #[schemars(range(min = 1e-3, max = 1e4))]
    pub source_ohm: f64,
}

impl Default for Amplifier {
    fn default() -> Self {
        Amplifier { full_scale_v: 20.0, bandwidth_hz: 200e3, source_ohm: 0.3 }
    }
}

/// The converters and the load cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Sensors {
    /// Samples a second, of DAC and ADC, Hz.
    #[schemars(range(min = 1e5, max = 1e7))]
    pub sample_hz: f64,
    /// Bits of the ADC.
    #[schemars(range(min = 6, max = 16))]
    pub adc_bits: u8,
    /// Bits of the DAC.
    #[schemars(range(min = 6, max = 16))]
    pub dac_bits: u8,
    /// Noise of each conversion before averaging, LSB rms.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub noise_lsb: f64,
    /// Offset of each sense channel, LSB.
    #[schemars(range(min = -500.0, max = 500.0))]
    pub offset_lsb: f64,
    /// Conversions a sample, evenly spaced and summed.
    #[schemars(range(min = 1, max = 4))]
    pub oversample: u8,
    /// Voltage at the ADC's end of range, V; the range is this much on each side.
    #[schemars(range(min = 1e-3, max = 1e4))]
    pub v_full_scale_v: f64,
    /// Current at the ADC's end of range, A; the range is this much on each side.
    #[schemars(range(min = 1e-6, max = 1e3))]
    pub i_full_scale_a: f64,
    /// How much later the current is sampled than the voltage, s.
    #[schemars(range(min = -2e-7, max = 2e-7))]
    pub skew_s: f64,
    /// Bandwidth of the load cell and its conditioner, Hz.
    #[schemars(range(min = 0.1, max = 1e5))]
    pub load_cell_hz: f64,
}

impl Default for Sensors {
    fn default() -> Self {
        Sensors {
            sample_hz: 1e6,
            adc_bits: 12,
            dac_bits: 12,
            noise_lsb: 1.0,
            offset_lsb: 3.0,
            oversample: 2,
            v_full_scale_v: 20.0,
            i_full_scale_a: 4.0,
            skew_s: 0.0,
            load_cell_hz: 80.0,
        }
    }
}

/// The piezo stack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stack {
    /// Butterworth-Van Dyke equivalent circuit.
    pub bvd: Bvd,
}

/// Butterworth-Van Dyke equivalent circuit. Give `c0_f` and either `cm_f`, `lm_h`, `rm_ohm`, or `series_resonance_hz`, `q`,
/// `coupling`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bvd {
    /// Clamped capacitance, F.
    #[schemars(range(min = 1e-13, max = 1e-3))]
    pub c0_f: f64,
    /// Motional capacitance, F.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-16, max = 1e-3))]
    pub cm_f: Option<f64>,
    /// Motional inductance, H.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 1e4))]
    pub lm_h: Option<f64>,
    /// Motional resistance, ohm.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-6, max = 1e7))]
    pub rm_ohm: Option<f64>,
    /// Series resonance, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 100.0, max = 450e3))]
    pub series_resonance_hz: Option<f64>,
    /// Quality factor at series resonance.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1e6))]
    pub q: Option<f64>,
    /// Effective coupling k: `k^2 = Cm / (C0 + Cm)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-4, max = 0.99))]
    pub coupling: Option<f64>,
    /// Force factor, N/V: tip force per volt, and ampere of motional current per m/s of tip velocity.
    #[serde(default = "default::force_factor")]
    #[schemars(range(min = 1e-6, max = 1e4))]
    pub force_factor_n_per_v: f64,
}

/// The friction contact. Give exactly one model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Dahl's model.
    pub dahl: Dahl,
}

/// Dahl's model with exponent one: `dF/dz = Kt (1 - F sgn(V) / Fc)`, `Fc = mu N`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Dahl {
    /// Coefficient of friction.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub mu: f64,
    /// Tangential contact stiffness Kt, N/m.
    #[schemars(range(min = 1.0, max = 1e12))]
    pub stiffness_n_per_m: f64,
}

/// What presses on the contact and moves it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rig {
    /// A slider at constant speed (experiment 1).
    pub slider: Slider,
}

/// A slider at constant speed; its tip vibrates along the motion.
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
}

/// A change of one plant value on the way. Give `to` (a step), or `rate_per_s` (a ramp), or `sine_amplitude` and `sine_hz`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disturbance {
    /// When it begins, s.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub at_s: f64,
    /// What changes.
    pub key: DisturbedKey,
    /// The new value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// Slope, per second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_per_s: Option<f64>,
    /// Amplitude of a sine about the present value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sine_amplitude: Option<f64>,
    /// Its frequency, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e4))]
    pub sine_hz: Option<f64>,
}

/// A plant value that can change on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
pub enum DisturbedKey {
    /// Series resonance, Hz; the motional inductance stays.
    #[serde(rename = "stack.bvd.series_resonance_hz")]
    SeriesResonance,
    /// Quality factor; the motional inductance stays.
    #[serde(rename = "stack.bvd.q")]
    Q,
    /// Clamped capacitance, F.
    #[serde(rename = "stack.bvd.c0_f")]
    ClampedCapacitance,
    /// Load on the slider, N.
    #[serde(rename = "rig.slider.load_n")]
    Load,
    /// Sliding speed, m/s.
    #[serde(rename = "rig.slider.speed_m_per_s")]
    Speed,
}

/// Something that breaks on the way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// When, s.
    #[schemars(range(min = 0.0, max = 1e5))]
    pub at_s: f64,
    /// What.
    pub kind: FaultKind,
}

/// What breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// The current channel reads nothing: a broken lead.
    Open,
    /// The voltage channel stays at its last code.
    SensorStuck,
    /// Both channels read the end of their range.
    Saturation,
    /// One block is delivered late.
    LateBlock,
    /// The belt sensor reads zero from now on.
    BeltStopped,
}

/// A table of one metric over two keys; each cell is this scene, run again with two values changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// What the table shows.
    pub title: String,
    /// The metric in each cell.
    pub metric: String,
    /// Key that changes from row to row.
    pub row_key: String,
    /// Its values.
    #[schemars(length(min = 1, max = 32))]
    pub rows: Vec<f64>,
    /// Key that changes from column to column.
    pub column_key: String,
    /// Its values.
    #[schemars(length(min = 1, max = 32))]
    pub columns: Vec<f64>,
    /// Further changes for every cell, each as `key=value` (a shorter timeline, say).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
}

/// What is recorded besides the standard figures, into `trace.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Trace {
    /// Names of the signals.
    #[schemars(length(min = 1))]
    pub signals: Vec<Signal>,
    /// Every how many samples; 1 is the full rate.
    #[serde(default = "default::every")]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub every: u32,
    /// From, s.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e5))]
    pub from_s: f64,
    /// To, s. Default: the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e5))]
    pub to_s: Option<f64>,
}

/// A signal that can be recorded at the sample rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Signal {
    /// DAC code of the first lane.
    #[serde(rename = "drive_code_0")]
    DriveCode0,
    /// DAC code of the second lane.
    #[serde(rename = "drive_code_1")]
    DriveCode1,
    /// DAC code of the third lane.
    #[serde(rename = "drive_code_2")]
    DriveCode2,
    /// DAC code of the fourth lane.
    #[serde(rename = "drive_code_3")]
    DriveCode3,
    /// Voltage sense code.
    VCode,
    /// Current sense code.
    ICode,
    /// Frequency driven, Hz.
    FrequencyHz,
    /// True voltage at the stack, V.
    StackVoltageV,
    /// True motional current, A.
    MotionalCurrentA,
    /// True tip velocity, m/s.
    TipVelocityMPerS,
    /// True friction force, N.
    FrictionN,
}

/// What must come out. Give `min` and/or `max`, or `value` and `tolerance`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// The metric.
    pub metric: String,
    /// Smallest value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Largest value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// The value itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// How far from `value` it may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e12))]
    pub tolerance: Option<f64>,
    /// Why.
    #[serde(default)]
    pub source: String,
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn seed() -> u64 {
        1
    }
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
    pub(super) fn force_factor() -> f64 {
        1.0
    }
    pub(super) fn every() -> u32 {
        1
    }
}
