//! Comparison of two results: metrics with tolerances, and overlaid figures.
//!
//! ```text
//! folder of a run, or a measurement --> Side --+
//!                                              +--> Comparison (a row per metric) --> table, report, verdict
//! folder of a run, or a measurement --> Side --+
//! ```
//!
//! It compares runs at two levels (SIL, PIL, the flashed image, a board), two versions, or a run
//! with a measurement.

mod figures;
mod side;
mod tolerance;

#[cfg(test)]
mod tests;

use serde_json::{Value, json};

pub use self::side::Side;
pub use self::tolerance::{Tolerance, Tolerances};
use crate::numbers::{number, precise};
use report::{Report, TableBlock, verdict};
use scene::metrics::metric;

/// Reason that two results cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The folder or file does not exist, or is not a result.
    #[error("`{path}` {why}")]
    NoResult {
        /// Path as given.
        path: String,
        /// Missing part.
        why: String,
    },
    /// A line of a measurement cannot be read.
    #[error("{file}, line {line}: {why}")]
    Line {
        /// File of the measurement.
        file: String,
        /// Line number, from 1.
        line: u64,
        /// Reason.
        why: String,
    },
    /// A tolerance cannot be read.
    #[error("`{text}` is not a tolerance: {why} (for example `1%`, `friction_ratio=0.01`, `lock_time_20hz_ms=5%`)")]
    Tolerance {
        /// Text as written.
        text: String,
        /// Reason.
        why: String,
    },
    /// A metric that is to be compared is missing.
    #[error("{of} has no metric `{metric}`")]
    Missing {
        /// Side without the metric.
        of: String,
        /// Name of the metric.
        metric: String,
    },
    /// The two sides have no metric in common.
    #[error("{a} and {b} have no metric in common")]
    NothingInCommon {
        /// First side.
        a: String,
        /// Second side.
        b: String,
    },
}

/// A metric of both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the metric.
    pub metric: String,
    /// Value of the first side, if it has the metric.
    pub a: Option<f64>,
    /// Value of the second side, if it has the metric.
    pub b: Option<f64>,
    /// Maximum allowed difference.
    pub allowed: f64,
}

impl Row {
    /// Returns the second value minus the first, if both sides have the metric.
    pub fn difference(&self) -> Option<f64> {
        // Two infinite statistics are equal.
        self.a.zip(self.b).map(|(a, b)| if a == b { 0.0 } else { b - a })
    }

    /// Returns `true` if the difference is within the tolerance; `None` if one side lacks the
    /// metric.
    pub fn holds(&self) -> Option<bool> {
        self.difference().map(|difference| difference.abs() <= self.allowed)
    }
}

/// Comparison of two results.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// First result.
    pub a: Side,
    /// Second result.
    pub b: Side,
    /// Metrics of both, in the order of the table of metrics.
    pub rows: Vec<Row>,
}

impl Comparison {
    /// Compares two results in the named metrics; without names, in all that either side has.
    ///
    /// # Errors
    /// If a named metric is missing on a side, or if the two sides have no metric in common.
    pub fn new(a: Side, b: Side, tolerances: &Tolerances, names: &[String]) -> Result<Self, CompareError> {
        for side in [&a, &b] {
            if let Some(missing) = names.iter().find(|name| side.metric(name).is_none()) {
                return Err(CompareError::Missing { of: side.label.clone(), metric: missing.clone() });
            }
        }
        let mut all: Vec<&String> = if names.is_empty() {
            a.metrics.iter().chain(&b.metrics).map(|measured| &measured.metric).collect()
        } else {
            names.iter().collect()
        };
        all.sort_by_key(|name| (scene::metrics::rank(name), *name));
        all.dedup();
        let row = |name: &&String| {
            let (one, other) = (a.metric(name), b.metric(name));
            let sd = [one, other].into_iter().flatten().filter_map(|measured| measured.sd).map(|sd| sd * sd).sum::<f64>().sqrt();
            let [one, other] = [one, other].map(|measured| measured.map(|measured| measured.value));
            let size =
                [one, other].into_iter().flatten().filter(|value| value.is_finite()).fold(0.0, |most: f64, v| most.max(v.abs()));
            Row { metric: (*name).clone(), a: one, b: other, allowed: tolerances.allowed(name, size, sd) }
        };
        let rows: Vec<Row> = all.iter().map(row).collect();
        if rows.iter().all(|row| row.difference().is_none()) {
            return Err(CompareError::NothingInCommon { a: a.label, b: b.label });
        }
        Ok(Comparison { a, b, rows })
    }

    /// Returns `true` if every metric of both sides is within its tolerance.
    pub fn holds(&self) -> bool {
        self.rows.iter().all(|row| row.holds() != Some(false))
    }

    /// Returns `true` if both have played the same drive codes; `None` if either has played none.
    pub fn same_drive(&self) -> Option<bool> {
        self.a.drive_hash.as_ref().zip(self.b.drive_hash.as_ref()).map(|(a, b)| a == b)
    }

    /// Returns the metrics as a table.
    pub fn table(&self) -> TableBlock {
        let shown = |value: Option<f64>, fine: bool| {
            value.map_or_else(|| "–".to_owned(), |value| if fine { precise(value) } else { number(value) })
        };
        let row = |row: &Row| {
            let size = row.a.unwrap_or(0.0).abs();
            let fine = row.difference().is_some_and(|difference| difference.abs() < 1e-3 * size);
            let (a, b) = (shown(row.a, fine), shown(row.b, fine));
            let verdict = match (row.holds(), row.a) {
                (Some(holds), _) => verdict(holds).to_owned(),
                (None, Some(_)) => "only A".to_owned(),
                (None, None) => "only B".to_owned(),
            };
            let unit = metric(&row.metric).map_or("", |metric| metric.unit);
            let allowed = row.difference().map(|_| row.allowed);
            vec![verdict, row.metric.clone(), unit.to_owned(), a, b, shown(row.difference(), false), shown(allowed, false)]
        };
        let header = ["", "metric", "unit", "A", "B", "B - A", "allowed"];
        TableBlock::new("metrics", "Metrics", self.caption(), &header, self.rows.iter().map(row).collect())
    }

    fn caption(&self) -> String {
        let drive = match self.same_drive() {
            Some(true) => "Both played identical drive codes.",
            Some(false) => "The drive codes differ.",
            None => "",
        };
        format!("A is {}; B is {}. {drive}", self.a.description(), self.b.description()).trim_end().to_owned()
    }

    /// Returns the report: the table, and the overlaid figures that both have.
    pub fn report(&self) -> Report {
        let beyond = self.rows.iter().filter(|row| row.holds() == Some(false)).count();
        let compared = self.rows.iter().filter(|row| row.holds().is_some()).count();
        Report {
            title: format!("{} and {}", self.a.label, self.b.label),
            subtitle: self.caption(),
            summary: vec![
                ("metrics compared".into(), compared.to_string()),
                ("beyond their tolerance".into(), beyond.to_string()),
            ],
            tables: vec![self.table()],
            figures: figures::overlaid(&self.a, &self.b),
            footer: vec![("sim-host".into(), crate::VERSION.into())],
            ..Report::default()
        }
    }

    /// Returns the comparison as JSON.
    pub fn json(&self) -> Value {
        let row = |row: &Row| {
            json!({
                "metric": row.metric, "a": row.a, "b": row.b, "difference": row.difference(), "allowed": row.allowed,
                "pass": row.holds(),
            })
        };
        json!({
            "a": self.a.json(), "b": self.b.json(), "pass": self.holds(), "same_drive": self.same_drive(),
            "metrics": self.rows.iter().map(row).collect::<Vec<_>>(),
        })
    }
}
