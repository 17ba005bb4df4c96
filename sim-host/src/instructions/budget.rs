//! What may be spent: a bound for each kernel, in instructions, and for the error of the sine that it buys.
//!
//! A block of 32 samples at 1 Msps lasts 32 us, 5440 cycles of the reference board's 170 MHz: 170 a sample. What the controller takes
//! of it must leave room for what an instruction is not: wait states, taken branches, the interrupt itself, and the slow side.

use super::target::{Counted, find};
use super::{Row, Trouble};

/// A bound.
pub struct Bound {
    /// What is bounded: the group and the kernel, as counted.
    pub of: (&'static str, &'static str),
    /// Its name in the table.
    pub name: &'static str,
    /// In what.
    pub unit: Unit,
    /// The most that it may be.
    pub at_most: f64,
}

/// What a bound is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Instructions a sample.
    Sample,
    /// Instructions a block of 32 samples.
    Block,
    /// The largest error of a generator of amplitude one.
    Error,
}

/// A bound, with what was counted.
pub struct Judged {
    /// The bound.
    pub bound: &'static Bound,
    /// What was counted.
    pub found: f64,
}

impl Judged {
    /// Whether it is kept.
    pub fn holds(&self) -> bool {
        self.found <= self.bound.at_most
    }
}

const fn sample(group: &'static str, kernel: &'static str, name: &'static str, at_most: f64) -> Bound {
    Bound { of: (group, kernel), name, unit: Unit::Sample, at_most }
}

const fn block(kernel: &'static str, name: &'static str, at_most: f64) -> Bound {
    Bound { of: ("worst block", kernel), name, unit: Unit::Block, at_most }
}

/// Every bound. Half a step of a 14-bit converter is 6.1e-5 of its half range.
pub const BUDGET: [Bound; 10] = [
    sample("process", "one lane, run", "process, one lane, tracked, ON", 60.0),
    sample("process", "four lanes, run", "process, four lanes, tracked, ON", 100.0),
    sample("generator", "firmware rotation", "sine and cosine of the controller", 24.0),
    Bound { of: ("generator", "firmware rotation"), name: "error of the same", unit: Unit::Error, at_most: 3.2e-5 },
    sample("stage", "lock-in", "lock-in of voltage and current", 24.0),
    sample("stage", "guard", "guard", 20.0),
    sample("stage", "tracker", "tracker", 12.0),
    block("one lane, run", "worst block ON, one lane", 2400.0),
    block("four lanes, run", "worst block ON, four lanes", 3600.0),
    block("four lanes, run at an edge", "worst block at an edge, four lanes", 5440.0),
];

/// Holds what was counted against the budget.
pub fn judge(counted: &[Counted], generators: &[Row]) -> Result<Vec<Judged>, Trouble> {
    let judge = |bound: &'static Bound| {
        let (group, kernel) = bound.of;
        let counted = find(counted, group, kernel)?;
        let found = match bound.unit {
            Unit::Sample => counted.per_sample(),
            Unit::Block => counted.per_block(),
            Unit::Error => {
                let row = generators.iter().find(|row| row.known.name == kernel);
                row.ok_or_else(|| Trouble::Printed(format!("{kernel:?} is no generator")))?.quality.largest_error
            }
        };
        Ok(Judged { bound, found })
    };
    BUDGET.iter().map(judge).collect()
}
