//! The budget: a bound for the instructions of each kernel, and for the error of the sine.
//!
//! The counts are those of the emulated image, and show a kernel that has grown by its name. The
//! flashed image is compiled differently; `evidence board-scenes` checks that its blocks have
//! enough cycles.

use serde::Deserialize;

use super::Row;
use super::target::{Counted, find};
use crate::evidence::Error;

/// Every bound, one per line; `aim` is a lower target. Half a step of a 14-bit converter is 6.1e-5
/// of its half range.
const BUDGET: &str = include_str!("budget.csv");

/// Bound of the cost or error of kernels.
#[derive(Clone, Debug, Deserialize)]
pub struct Bound {
    /// Group of the kernels, as counted.
    pub group: String,
    /// A kernel, or several with ` + ` between whose sum is bounded.
    pub kernels: String,
    /// Name of the bound in the table.
    pub name: String,
    /// Unit of the bound.
    pub unit: Unit,
    /// Largest allowed value.
    pub at_most: f64,
    /// Target value, if it is lower.
    pub aim: Option<f64>,
}

/// Unit of a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Instructions per sample.
    Sample,
    /// Instructions per block.
    Block,
    /// Largest error of a generator of amplitude one.
    Error,
}

/// A bound with its counted value.
pub struct Judged {
    /// Bound that was judged.
    pub bound: Bound,
    /// Counted or computed value.
    pub found: f64,
}

impl Judged {
    /// Returns `true` if the count is within its bound.
    pub fn holds(&self) -> bool {
        self.found <= self.bound.at_most
    }
}

/// Compares the counts with the budget.
pub fn judge(counted: &[Counted], generators: &[Row]) -> Result<Vec<Judged>, Error> {
    let judge = |bound: Result<Bound, csv::Error>| {
        let bound = bound?;
        let found = |kernel: &str| {
            let counted = find(counted, &bound.group, kernel)?;
            Ok(match bound.unit {
                Unit::Sample => counted.per_sample(),
                Unit::Block => counted.per_block(),
                Unit::Error => {
                    let row = generators.iter().find(|row| row.generator.name == kernel);
                    row.ok_or_else(|| Error::Counts(format!("{kernel:?} is not a generator")))?.quality.largest_error
                }
            })
        };
        let found = bound.kernels.split(" + ").map(found).sum::<Result<f64, Error>>()?;
        Ok(Judged { bound, found })
    };
    csv::Reader::from_reader(BUDGET.as_bytes()).deserialize().map(judge).collect()
}
