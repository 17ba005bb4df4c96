//! The file of a suite: cases, targets and tables, and their schema.

use std::sync::LazyLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::schema::{self, Schema};

/// Quantities of a case that no single run has, beside the metrics: name and meaning.
pub const DERIVED: &[(&str, &str)] = &[
    ("bound_20hz_ms", "Cramer-Rao bound of the time to play the resonance within 20 Hz at 95 %, from rest or from the step"),
    ("bound_4hz_ms", "the same within 4 Hz"),
    ("bound_ramp_hz", "Cramer-Rao bound of an estimate that takes the resonance for constant while it moves, Hz rms"),
    ("friction_floor", "least friction ratio at the maximum amplitude, by the closed form of steady Dahl friction"),
    ("friction_ratio_estimate_error", "largest difference of estimated and true friction ratio, of ratios that are not refused"),
    ("friction_ratios", "number of friction ratios that were set and held"),
    ("ratios_by_bursts", "number of friction ratios that were held by bursts"),
];

/// The set points of a friction ratio, each with the error of the true ratio: in place of a metric, in a column.
pub const STEPS: &str = "steps";

/// Cases, targets and tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// One line that says what the suite shows.
    pub title: String,
    /// What a reader of the report should know, a paragraph each.
    #[serde(default)]
    pub notes: Vec<String>,
    /// The scene of every case that names none: a built-in name, or a file relative to this one.
    pub scene: String,
    /// Changes of every case, each as `key=value`.
    #[serde(default)]
    pub set: Vec<String>,
    /// How often each case is run that does not say it itself.
    #[serde(default = "once")]
    #[schemars(range(min = 1, max = 100_000))]
    pub runs: u32,
    /// What is less in the quick variant.
    pub quick: Option<Quick>,
    /// Changes with a name, for several cases.
    #[serde(default)]
    pub preset: Vec<Preset>,
    /// The cases of the suite.
    #[schemars(length(min = 1, max = 1000))]
    pub case: Vec<SuiteCase>,
    /// What must come of them.
    #[serde(default)]
    pub target: Vec<Target>,
    /// What is shown of them. Without tables: of every group the metrics of its targets.
    #[serde(default)]
    pub table: Vec<SuiteTable>,
}

/// The quick variant of a suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quick {
    /// Most runs of each case.
    #[schemars(range(min = 1, max = 100_000))]
    pub runs: Option<u32>,
    /// The cases that are run; without it, all.
    #[serde(default)]
    pub cases: Vec<String>,
}

/// Changes with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Preset {
    /// Name of the preset, for `use` and `each` of a case.
    pub name: String,
    /// The changes, each as `key=value`.
    pub set: Vec<String>,
}

/// A scene with changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SuiteCase {
    /// Name of the case, in tables and targets.
    pub name: String,
    /// The group that tables and targets know it by.
    #[serde(default)]
    pub group: String,
    /// Scene of the case, if it is not that of the suite.
    pub scene: Option<String>,
    /// How often it is run, if not as often as the suite says.
    #[schemars(range(min = 1, max = 100_000))]
    pub runs: Option<u32>,
    /// Presets that it takes, one laid over the other.
    #[serde(default, rename = "use")]
    pub presets: Vec<String>,
    /// Presets of which each makes a case of its own, with its name behind.
    #[serde(default)]
    pub each: Vec<String>,
    /// Changes of this case, over those of its presets, each as `key=value`.
    #[serde(default)]
    pub set: Vec<String>,
}

/// What must come of some cases. Give `min` and/or `max`, `value` and `tolerance`, or `one_of`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// The metric; of several runs the median, or with `_p95` or `_max` behind.
    pub metric: String,
    /// Groups whose cases the target is for; without them and `cases`, it is for all cases.
    #[serde(default)]
    pub groups: Vec<String>,
    /// Cases that the target is for.
    #[serde(default)]
    pub cases: Vec<String>,
    /// Smallest value that is allowed.
    pub min: Option<f64>,
    /// Largest value that is allowed.
    pub max: Option<f64>,
    /// Value that is demanded, within `tolerance`.
    pub value: Option<f64>,
    /// How far from the value it may be.
    pub tolerance: Option<f64>,
    /// In every run one of these.
    #[serde(default)]
    pub one_of: Vec<f64>,
    /// Where the target comes from.
    #[serde(default)]
    pub source: String,
}

/// A table, with a row for each case of some groups.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SuiteTable {
    /// Heading of the table.
    pub title: String,
    /// The groups whose cases it shows; without them, all cases.
    #[serde(default)]
    pub groups: Vec<String>,
    /// What a reader must know of its columns.
    #[serde(default)]
    pub caption: String,
    /// The columns behind the name of the case.
    #[schemars(length(min = 1, max = 16))]
    pub column: Vec<Column>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Heading of the column, with the unit.
    pub title: String,
    /// The metrics that it shows, beside each other.
    #[schemars(length(min = 1, max = 8))]
    pub metrics: Vec<String>,
    /// What of each metric is shown.
    #[serde(default = "median")]
    #[schemars(length(min = 1, max = 4))]
    pub show: Vec<Statistic>,
    /// What its numbers are multiplied with.
    #[serde(default = "one")]
    pub scale: f64,
    /// Digits after the point; without it three significant digits.
    #[schemars(range(max = 9))]
    pub digits: Option<u32>,
}

/// What is shown of a metric of several runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Statistic {
    /// The 5th percentile of the runs.
    P5,
    /// The median; of what is counted, the sum.
    Median,
    /// The 95th percentile of the runs.
    P95,
    /// The largest value of the runs.
    Max,
    /// All values that there are.
    Values,
}

fn once() -> u32 {
    1
}

fn one() -> f64 {
    1.0
}

fn median() -> Vec<Statistic> {
    vec![Statistic::Median]
}

static SCHEMA: LazyLock<Value> = LazyLock::new(schema::of_type::<Suite>);

/// The schema of a suite.
pub(crate) fn root() -> Schema {
    Schema::of(&SCHEMA)
}

/// The JSON Schema of a suite.
pub fn schema() -> Value {
    SCHEMA.clone()
}
