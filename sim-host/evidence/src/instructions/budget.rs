//! What may be spent: a bound for each kernel, in instructions, and for the error of the sine that it buys.
//!
//! The counts are of the emulated image, in which a grown kernel shows at once and by its name. Whether a block has time for them is a matter of the image
//! that is flashed, which is compiled otherwise: its cycles are gated by `evidence board-scenes`.

use serde::Deserialize;

use super::Row;
use super::target::{Counted, find};
use crate::evidence::Error;

/// Every bound, a line each; `aim` is what is aimed at where that is less. Half a step of a 14-bit converter is 6.1e-5 of its half range.
const BUDGET: &str = include_str!("budget.csv");

/// Bound of the cost or error of kernels.
#[derive(Clone, Debug, Deserialize)]
pub struct Bound {
    /// Group of the kernels, as counted.
    pub group: String,
    /// What is bounded: a kernel, or the sum of several with ` + ` between.
    pub kernels: String,
    /// Name of the bound in the table.
    pub name: String,
    /// Unit of the bound.
    pub unit: Unit,
    /// The most that it may be.
    pub at_most: f64,
    /// What is aimed at.
    pub aim: Option<f64>,
}

/// What a bound is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Instructions for each sample.
    Sample,
    /// Instructions for each block.
    Block,
    /// The largest error of a generator of amplitude one.
    Error,
}

/// A bound, with what was counted.
pub struct Judged {
    /// Bound that was judged.
    pub bound: Bound,
    /// Counted or computed value.
    pub found: f64,
}

impl Judged {
    /// Whether the count is within its bound.
    pub fn holds(&self) -> bool {
        self.found <= self.bound.at_most
    }
}

/// Holds what was counted against the budget.
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
                    row.ok_or_else(|| Error::Counts(format!("{kernel:?} is no generator")))?.quality.largest_error
                }
            })
        };
        let found = bound.kernels.split(" + ").map(found).sum::<Result<f64, Error>>()?;
        Ok(Judged { bound, found })
    };
    csv::Reader::from_reader(BUDGET.as_bytes()).deserialize().map(judge).collect()
}
