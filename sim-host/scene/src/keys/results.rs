//! `[grid]`, `[trace]` and `[[expect]]`: requested and expected results.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Equal;

/// Largest number of contour lines in a map.
pub const MAX_CONTOURS: usize = 16;

/// Metrics at every combination of the values of some keys; each point is this scene with these
/// values.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Title of the grid.
    pub title: String,
    /// Metrics of each point. Default: all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub metrics: Vec<String>,
    /// Levels of the contour lines in the map of each metric, in the unit of the metric. Needs two
    /// keys with `from`, `to` and `points`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = MAX_CONTOURS))]
    pub contours: Vec<f64>,
    /// Keys that change; the last changes fastest.
    #[schemars(length(min = 1, max = 16))]
    pub over: Vec<Over>,
    /// Further changes for every point, each as `key=value` (for example a shorter timeline).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
}

/// A key of a grid with its values. Give `values`, or `from`, `to` and `points`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Over {
    /// Path of the key: tables and key, separated by dots.
    pub key: String,
    /// Values of the key, in its unit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(min = 1, max = 10_000))]
    pub values: Vec<f64>,
    /// First value, in the unit of the key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Last value, in the unit of the key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// Number of values from first to last.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 2, max = 10_000))]
    pub points: Option<u32>,
    /// `true` for equal ratios between the values instead of equal differences.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub log: bool,
}

/// Signals that are recorded in addition to the standard figures, to `trace.csv` or a file of
/// another `format`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Trace {
    /// Names of the signals.
    #[schemars(length(min = 1))]
    pub signals: Vec<Signal>,
    /// Record every n-th sample; 1 is the full rate.
    #[serde(default = "default::every")]
    #[schemars(range(min = 1, max = 1_000_000))]
    pub every: u32,
    /// Format of the file.
    #[serde(default)]
    pub format: TraceFormat,
    /// Beginning of the recording, s.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e5))]
    pub from_s: f64,
    /// End of the recording, s. Default: the end of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e5))]
    pub to_s: Option<f64>,
}

/// Format of a trace file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TraceFormat {
    /// `trace.csv`, one column per signal.
    #[default]
    Csv,
    /// `trace.npy`, for NumPy: an array of records with one field per signal.
    Npy,
    /// `trace.parquet`, one column per signal, compressed.
    Parquet,
}

/// A signal that can be recorded at the sample rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Signal {
    /// DAC code of the first lane, with `dac_bits` of `[sensors]`. The voltage is
    /// `amplifier.full_scale_v * (code / 2^(dac_bits - 1) - 1)`.
    #[serde(rename = "drive_code_0")]
    DriveCode0,
    /// DAC code of the second lane, with `dac_bits` of `[sensors]`. The voltage is
    /// `amplifier.full_scale_v * (code / 2^(dac_bits - 1) - 1)`.
    #[serde(rename = "drive_code_1")]
    DriveCode1,
    /// DAC code of the third lane, with `dac_bits` of `[sensors]`. The voltage is
    /// `amplifier.full_scale_v * (code / 2^(dac_bits - 1) - 1)`.
    #[serde(rename = "drive_code_2")]
    DriveCode2,
    /// DAC code of the fourth lane, with `dac_bits` of `[sensors]`. The voltage is
    /// `amplifier.full_scale_v * (code / 2^(dac_bits - 1) - 1)`.
    #[serde(rename = "drive_code_3")]
    DriveCode3,
    /// Code of the voltage sense, with `adc_bits`. The voltage is
    /// `sensors.v_full_scale_v * (code / 2^(adc_bits - 1) - 1)`.
    VCode,
    /// Code of the current sense, with `adc_bits`. The current is
    /// `sensors.i_full_scale_a * (code / 2^(adc_bits - 1) - 1)`.
    ICode,
    /// Frequency of the drive, Hz.
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

impl Signal {
    /// Returns the name of the signal in scenes and column headings.
    pub fn name(self) -> String {
        match serde_json::to_value(self) {
            Ok(serde_json::Value::String(name)) => name,
            _ => format!("{self:?}"),
        }
    }
}

/// An expected result. Give `min` and/or `max`, or `value` and `tolerance`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// Metric that is expected.
    pub metric: String,
    /// Case of the comparison, instead of the scene's own run. With `match`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<String>,
    /// Comparison at equal peak, rms, power or reduction. With `case`.
    #[serde(rename = "match", skip_serializing_if = "Option::is_none")]
    pub matched: Option<Equal>,
    /// Smallest value that is expected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Largest value that is expected.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
    /// Value that is expected, within `tolerance`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Largest difference from `value`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1e12))]
    pub tolerance: Option<f64>,
    /// Source of the expected value.
    #[serde(default)]
    pub source: String,
}

/// Defaults that serde needs as functions.
mod default {
    pub(super) fn every() -> u32 {
        1
    }
}
