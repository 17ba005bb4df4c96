//! What may be spent: a bound for each kernel, in instructions, and for the error of the sine that it buys.
//!
//! A block of 32 samples at 1 Msps lasts 32 us, 5440 cycles of the reference board's 170 MHz: 170 a sample. What the controller takes
//! of it must leave room for what an instruction is not: wait states, taken branches, the interrupt itself, and the slow side.

use super::Row;
use super::target::{Counted, find};
use crate::bench::Error;

/// Cycles of a block of 32 samples: nothing may take more instructions.
const BLOCK: f64 = 5440.0;
/// Of these, what is aimed at for four lanes and for one. What is left is for what an instruction is not.
const FOUR: f64 = 0.75 * BLOCK;
const ONE: f64 = 0.45 * BLOCK;

/// A bound.
pub struct Bound {
    /// What is bounded: group and kernel, as counted; of several, the sum.
    pub of: &'static [(&'static str, &'static str)],
    /// Its name in the table.
    pub name: &'static str,
    /// In what.
    pub unit: Unit,
    /// The most that it may be.
    pub at_most: f64,
    /// What is aimed at, where that is less: the bound follows as the controller gets there.
    pub aim: Option<f64>,
}

/// What a bound is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Instructions a sample.
    Sample,
    /// Instructions a block.
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

const fn bound(of: &'static [(&'static str, &'static str)], name: &'static str, unit: Unit, at_most: f64) -> Bound {
    Bound { of, name, unit, at_most, aim: None }
}

const fn aiming(of: &'static [(&'static str, &'static str)], name: &'static str, unit: Unit, at_most: f64, aim: f64) -> Bound {
    Bound { of, name, unit, at_most, aim: Some(aim) }
}

/// Every bound. Half a step of a 14-bit converter is 6.1e-5 of its half range.
pub const BUDGET: [Bound; 46] = [
    bound(
        &[("stage", "sine, four lanes"), ("stage", "lock-in"), ("stage", "tracker, observer")],
        "sine on four lanes, lock-in and tracker",
        Unit::Sample,
        77.5,
    ),
    bound(
        &[("stage", "sine, one lane"), ("stage", "lock-in"), ("stage", "tracker, observer")],
        "sine on one lane, lock-in and tracker",
        Unit::Sample,
        57.8,
    ),
    aiming(&[("process", "four lanes, run")], "the whole controller, four lanes, tracked, ON", Unit::Sample, 116.0, 100.0),
    aiming(&[("process", "one lane, run")], "the whole controller, one lane, tracked, ON", Unit::Sample, 96.5, 60.0),
    bound(&[("process", "four lanes, run, 64 samples a block")], "the same in blocks of 64, four lanes", Unit::Sample, 75.5),
    aiming(&[("process", "one lane, run, 64 samples a block")], "the same in blocks of 64, one lane", Unit::Sample, 59.0, 51.0),
    bound(&[("process", "four lanes, phase loop, run")], "the whole controller, four lanes, phase loop, ON", Unit::Sample, 105.0),
    bound(&[("process", "one lane, phase loop, run")], "the whole controller, one lane, phase loop, ON", Unit::Sample, 85.5),
    bound(&[("generator", "rotation")], "sine and cosine of the controller", Unit::Sample, 24.0),
    bound(&[("generator", "rotation")], "error of the same", Unit::Error, 3.2e-5),
    bound(&[("stage", "lock-in")], "lock-in of voltage and current", Unit::Sample, 24.0),
    bound(&[("stage", "guard")], "guard", Unit::Sample, 5.0),
    aiming(&[("stage", "tracker, observer")], "tracker, led by the observer", Unit::Sample, 17.0, 10.0),
    bound(&[("stage", "tracker, observer, 64 samples a block")], "the same in blocks of 64", Unit::Sample, 10.0),
    bound(&[("stage", "observer alone")], "the observer of it", Unit::Sample, 10.5),
    bound(&[("stage", "tracker, phase loop")], "tracker, led by the phase loop", Unit::Sample, 7.0),
    aiming(&[("worst block", "one lane, run")], "worst block ON, one lane", Unit::Block, 3305.0, ONE),
    aiming(&[("worst block", "one lane, run at an edge")], "worst block at an edge, one lane", Unit::Block, 3850.0, ONE),
    aiming(
        &[("worst block", "one lane, boosted, run at an edge")],
        "worst block at a boosted edge, one lane",
        Unit::Block,
        4425.0,
        ONE,
    ),
    aiming(
        &[("worst block", "one lane, clamped branch")],
        "worst block of the clamped branch, one lane",
        Unit::Block,
        4045.0,
        ONE,
    ),
    aiming(&[("worst block", "one lane, scan")], "worst block of the scan, one lane", Unit::Block, 4055.0, ONE),
    bound(&[("worst block", "four lanes, run")], "worst block ON, four lanes", Unit::Block, 3930.0),
    bound(
        &[("worst block", "four lanes, run after a step of the load")],
        "worst block after a step of the load, four lanes",
        Unit::Block,
        3920.0,
    ),
    bound(&[("worst block", "four lanes, lock")], "worst block until the lock, four lanes", Unit::Block, 3910.0),
    bound(&[("worst block", "four lanes, self-test")], "worst block of the self-test, four lanes", Unit::Block, 4080.0),
    aiming(&[("worst block", "four lanes, run at an edge")], "worst block at an edge, four lanes", Unit::Block, 4610.0, FOUR),
    aiming(
        &[("worst block", "four lanes, phase loop, run at an edge")],
        "worst block at an edge, four lanes, phase loop",
        Unit::Block,
        4300.0,
        FOUR,
    ),
    aiming(
        &[("worst block", "four lanes, boosted, run at an edge")],
        "worst block at a boosted edge, four lanes",
        Unit::Block,
        5170.0,
        FOUR,
    ),
    aiming(
        &[("worst block", "four lanes, clamped branch")],
        "worst block of the clamped branch, four lanes",
        Unit::Block,
        4270.0,
        FOUR,
    ),
    aiming(
        &[("worst block", "four lanes, clamped branch, two resonances")],
        "the same with a second resonance",
        Unit::Block,
        4270.0,
        FOUR,
    ),
    aiming(&[("worst block", "four lanes, scan")], "worst block of the scan, four lanes", Unit::Block, 4685.0, FOUR),
    aiming(&[("worst block", "four trimmed lanes, run")], "worst block ON, four trimmed lanes", Unit::Block, 4335.0, FOUR),
    aiming(
        &[("worst block", "four trimmed lanes, run at an edge")],
        "worst block at an edge, four trimmed lanes",
        Unit::Block,
        5120.0,
        FOUR,
    ),
    aiming(
        &[("worst block", "four trimmed lanes, boosted, run")],
        "worst block beside a boosted edge, four trimmed lanes",
        Unit::Block,
        5575.0,
        FOUR,
    ),
    bound(&[("worst block", "one lane, run, 64 samples a block")], "in blocks of 64: ON, one lane", Unit::Block, 3995.0),
    bound(
        &[("worst block", "one lane, run at an edge, 64 samples a block")],
        "in blocks of 64: at an edge, one lane",
        Unit::Block,
        4890.0,
    ),
    aiming(
        &[("worst block", "one lane, boosted, run at an edge, 64 samples a block")],
        "in blocks of 64: at a boosted edge, one lane",
        Unit::Block,
        5710.0,
        2.0 * ONE,
    ),
    aiming(
        &[("worst block", "one lane, clamped branch, 64 samples a block")],
        "in blocks of 64: clamped branch, one lane",
        Unit::Block,
        4545.0,
        2.0 * ONE,
    ),
    aiming(
        &[("worst block", "one lane, scan, 64 samples a block")],
        "in blocks of 64: scan, one lane",
        Unit::Block,
        5250.0,
        2.0 * ONE,
    ),
    bound(&[("worst block", "four lanes, run, 64 samples a block")], "in blocks of 64: ON, four lanes", Unit::Block, 5060.0),
    bound(
        &[("worst block", "four lanes, run at an edge, 64 samples a block")],
        "in blocks of 64: at an edge, four lanes",
        Unit::Block,
        6180.0,
    ),
    bound(
        &[("worst block", "four lanes, boosted, run at an edge, 64 samples a block")],
        "in blocks of 64: at a boosted edge, four lanes",
        Unit::Block,
        6995.0,
    ),
    bound(
        &[("worst block", "four lanes, clamped branch, 64 samples a block")],
        "in blocks of 64: clamped branch, four lanes",
        Unit::Block,
        5085.0,
    ),
    bound(&[("worst block", "four lanes, scan, 64 samples a block")], "in blocks of 64: scan, four lanes", Unit::Block, 6300.0),
    bound(
        &[("worst block", "four trimmed lanes, run, 64 samples a block")],
        "in blocks of 64: ON, four trimmed lanes",
        Unit::Block,
        5710.0,
    ),
    bound(
        &[("worst block", "four trimmed lanes, boosted, run at an edge, 64 samples a block")],
        "in blocks of 64: at a boosted edge, four trimmed lanes",
        Unit::Block,
        7915.0,
    ),
];

/// Holds what was counted against the budget.
pub fn judge(counted: &[Counted], generators: &[Row]) -> Result<Vec<Judged>, Error> {
    let judge = |bound: &'static Bound| {
        let found = |&(group, kernel): &(&str, &str)| {
            let counted = find(counted, group, kernel)?;
            Ok(match bound.unit {
                Unit::Sample => counted.per_sample(),
                Unit::Block => counted.per_block(),
                Unit::Error => {
                    let row = generators.iter().find(|row| row.generator.name == kernel);
                    row.ok_or_else(|| Error::Counts(format!("{kernel:?} is no generator")))?.quality.largest_error
                }
            })
        };
        Ok(Judged { bound, found: bound.of.iter().map(found).sum::<Result<f64, Error>>()? })
    };
    BUDGET.iter().map(judge).collect()
}
