//! Two results side by side: metrics with tolerances, and figures laid over each other.
//!
//! ```text
//! folder of a run, or a measurement --> Side --+
//!                                              +--> Comparison (a row a metric) --> table, report, verdict
//! folder of a run, or a measurement --> Side --+
//! ```
//!
//! A run at one level beside one at another (SIL, PIL, the flashed image, a board), one version beside another, or a run beside what was measured.

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

/// Why two results cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// There is no such folder or file, or it is no result.
    #[error("`{path}` {why}")]
    NoResult {
        /// As it was named.
        path: String,
        /// What is missing.
        why: String,
    },
    /// A line of a measurement cannot be read.
    #[error("{file}, line {line}: {why}")]
    Line {
        /// The file.
        file: String,
        /// The line, from 1.
        line: u64,
        /// What is wrong.
        why: String,
    },
    /// A tolerance cannot be read.
    #[error("`{text}` is no tolerance: {why} (for example `1%`, `friction_ratio=0.01`, `lock_time_20hz_ms=5%`)")]
    Tolerance {
        /// As it was written.
        text: String,
        /// What is wrong.
        why: String,
    },
    /// A metric that is to be compared is missing.
    #[error("{of} has no metric `{metric}`")]
    Missing {
        /// The side that lacks it.
        of: String,
        /// The metric.
        metric: String,
    },
    /// The two have nothing in common.
    #[error("{a} and {b} have no metric in common")]
    NothingInCommon {
        /// The first side.
        a: String,
        /// The second.
        b: String,
    },
}

/// A metric on both sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the metric.
    pub metric: String,
    /// Value of the first side; none where it does not have the metric.
    pub a: Option<f64>,
    /// Value of the second side.
    pub b: Option<f64>,
    /// The most that the two may differ by.
    pub allowed: f64,
}

impl Row {
    /// By how much the second is above the first, if both have the metric.
    pub fn difference(&self) -> Option<f64> {
        // Two statistics that are infinite are the same.
        self.a.zip(self.b).map(|(a, b)| if a == b { 0.0 } else { b - a })
    }

    /// Whether the difference is within the tolerance; none where one side lacks the metric.
    pub fn holds(&self) -> Option<bool> {
        self.difference().map(|difference| difference.abs() <= self.allowed)
    }
}

/// Two results side by side.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The first result.
    pub a: Side,
    /// The second.
    pub b: Side,
    /// Their metrics, in the order of the table of metrics.
    pub rows: Vec<Row>,
}

impl Comparison {
    /// Compares two results in some metrics; without names, in all that either has.
    ///
    /// # Errors
    /// If a named metric is missing on a side, or the two have none in common.
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

    /// Whether every metric that both have is within its tolerance.
    pub fn holds(&self) -> bool {
        self.rows.iter().all(|row| row.holds() != Some(false))
    }

    /// Whether both have played the same drive codes; none where either played none.
    pub fn same_drive(&self) -> Option<bool> {
        self.a.drive_hash.as_ref().zip(self.b.drive_hash.as_ref()).map(|(a, b)| a == b)
    }

    /// The metrics as a table.
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
            Some(true) => "Both have played the same drive codes, bit for bit.",
            Some(false) => "The drive codes that they have played differ.",
            None => "",
        };
        format!("A is {}; B is {}. {drive}", self.a.description(), self.b.description()).trim_end().to_owned()
    }

    /// The table, and the figures that both have, laid over each other.
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

    /// The comparison for programs.
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
