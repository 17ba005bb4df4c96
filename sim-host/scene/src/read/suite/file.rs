//! The file of a suite: cases, targets and tables, and their schema.

use std::sync::LazyLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::schema::{self, Schema};

/// Quantities of a case in addition to the metrics of a single run: name and meaning.
pub const DERIVED: &[(&str, &str)] = &[
    ("bound_20hz_ms", "Cramer-Rao bound of the time to reach the resonance within 20 Hz at 95 %, from rest or from the step"),
    ("bound_4hz_ms", "the same within 4 Hz"),
    ("bound_ramp_hz", "Cramer-Rao bound of an estimate that assumes a constant resonance while it moves, Hz rms"),
    ("friction_floor", "smallest friction ratio at the maximum amplitude, by the closed form of steady Dahl friction"),
    ("friction_ratio_estimate_error", "largest difference of estimated and true friction ratio, of ratios that are not refused"),
    ("friction_ratios", "number of friction ratios that were set and held"),
    ("ratios_by_bursts", "number of friction ratios that were held by bursts"),
];

/// Column value for the set points of a friction ratio, each with the error of the true ratio. Used
/// instead of a metric.
pub const STEPS: &str = "steps";

/// Cases, targets and tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Suite {
    /// One line that states what the suite shows.
    pub title: String,
    /// Notes for the reader of the report, one paragraph each.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Default scene of the cases: a built-in name, or a file relative to this one.
    pub scene: String,
    /// Changes of every case, each as `key=value`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Default number of runs of the cases.
    #[serde(default = "once")]
    #[schemars(range(min = 1, max = 100_000))]
    pub runs: u32,
    /// Restrictions of the quick variant.
    pub quick: Option<Quick>,
    /// Named changes, for use in several cases.
    #[serde(default)]
    pub preset: Vec<Preset>,
    /// The cases of the suite.
    #[schemars(length(min = 1, max = 1000))]
    pub case: Vec<SuiteCase>,
    /// Required results of the cases.
    #[serde(default)]
    pub target: Vec<Target>,
    /// Tables of results. Without tables, each group shows the metrics of its targets.
    #[serde(default)]
    pub table: Vec<SuiteTable>,
}

/// The quick variant of a suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quick {
    /// Largest number of runs of each case.
    #[schemars(range(min = 1, max = 100_000))]
    pub runs: Option<u32>,
    /// Cases to run. Default: all.
    #[serde(default)]
    pub cases: Vec<String>,
}

/// A named set of changes.
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
    /// Group of the case, for tables and targets.
    #[serde(default)]
    pub group: String,
    /// Scene of the case, if it differs from that of the suite.
    pub scene: Option<String>,
    /// Number of runs, if it differs from that of the suite.
    #[schemars(range(min = 1, max = 100_000))]
    pub runs: Option<u32>,
    /// Presets of the case, applied in this order.
    #[serde(default, rename = "use")]
    pub presets: Vec<String>,
    /// Presets that each make a separate case, whose name ends in that of the preset.
    #[serde(default)]
    pub each: Vec<String>,
    /// Changes of this case, applied after its presets, each as `key=value`.
    #[serde(default)]
    pub set: Vec<String>,
}

/// A required result of some cases. Give `min` and/or `max`, `value` and `tolerance`, or `one_of`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// The metric; over several runs the median, or another statistic with `_p95` or `_max`
    /// appended.
    pub metric: String,
    /// Groups whose cases the target applies to. Without `groups` and `cases` it applies to all
    /// cases.
    #[serde(default)]
    pub groups: Vec<String>,
    /// Cases that the target applies to.
    #[serde(default)]
    pub cases: Vec<String>,
    /// Smallest value that is allowed.
    pub min: Option<f64>,
    /// Largest value that is allowed.
    pub max: Option<f64>,
    /// Required value, within `tolerance`.
    pub value: Option<f64>,
    /// Largest difference from the value.
    pub tolerance: Option<f64>,
    /// Allowed values: every run must have one of these.
    #[serde(default)]
    pub one_of: Vec<f64>,
    /// Source of the target.
    #[serde(default)]
    pub source: String,
}

/// A table, with one row for each case of some groups.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SuiteTable {
    /// Heading of the table.
    pub title: String,
    /// Groups whose cases it shows. Default: all cases.
    #[serde(default)]
    pub groups: Vec<String>,
    /// Explanation of its columns.
    #[serde(default)]
    pub caption: String,
    /// Columns after the name of the case.
    #[schemars(length(min = 1, max = 16))]
    pub column: Vec<Column>,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Heading of the column, with the unit.
    pub title: String,
    /// Metrics that it shows, side by side.
    #[schemars(length(min = 1, max = 8))]
    pub metrics: Vec<String>,
    /// Statistics that are shown of each metric.
    #[serde(default = "median")]
    #[schemars(length(min = 1, max = 4))]
    pub show: Vec<Statistic>,
    /// Factor that multiplies its numbers.
    #[serde(default = "one")]
    pub scale: f64,
    /// Digits after the decimal point. Default: three significant digits.
    #[schemars(range(max = 9))]
    pub digits: Option<u32>,
}

/// Statistic of a metric over several runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Statistic {
    /// The 5th percentile of the runs.
    P5,
    /// The median; for counts, the sum.
    Median,
    /// The 95th percentile of the runs.
    P95,
    /// The largest value of the runs.
    Max,
    /// All values.
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

/// Returns the schema of a suite.
pub(crate) fn root() -> Schema {
    Schema::new(&SCHEMA)
}

/// Returns the JSON Schema of a suite.
pub fn schema() -> Value {
    SCHEMA.clone()
}
