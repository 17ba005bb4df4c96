//! The run: every peer at every setting, all in turn, several times over, the least time counting.
//!
//! Noise of the machine passes over all peers alike, because between two runs of one peer all others have had theirs.

use std::collections::{BTreeMap, BTreeSet};

use crate::case::Case;
use crate::interpolate::Measured;
use crate::peer::{Family, Peer, Setting};
use crate::reference::Reference;

/// A run longer than this, ns, is long enough to be timed once.
const LONG_NS: f64 = 2e9;

/// A peer with what was measured of it.
pub struct Entry {
    peer: Box<dyn Peer>,
    /// Name of the peer and its method.
    pub name: String,
    /// Where it comes from.
    pub family: Family,
    /// Periods that it was run over.
    pub periods: u32,
    /// One for each setting, from coarse to fine.
    pub points: Vec<Point>,
}

/// A peer at a setting.
pub struct Point {
    /// Setting of the peer's accuracy.
    pub setting: Setting,
    /// What came out, or why nothing did; nothing before the first run.
    pub result: Option<Result<Run, String>>,
}

/// Errors and least time.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// Least wall time over the periods, ns.
    pub ns_per_period: f64,
    /// Error of the mean friction ratio.
    pub mean_error: f64,
    /// Largest error of friction at quarter periods, over the largest friction.
    pub force_error: f64,
}

/// What an error is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The mean friction ratio.
    Mean,
    /// The friction over time.
    Force,
}

impl Entry {
    /// A peer, to be run over so many periods.
    pub fn new(peer: Box<dyn Peer>, periods: u32) -> Self {
        let points = peer.settings().into_iter().map(|setting| Point { setting, result: None }).collect();
        Entry { name: peer.name(), family: peer.family(), periods, points, peer }
    }

    /// The work-precision curve; without the runs that failed.
    pub fn curve(&self, quantity: Quantity) -> Vec<Measured> {
        let runs = self.points.iter().filter_map(|point| point.result.as_ref()?.as_ref().ok());
        let point = |run: &Run| {
            let error = if quantity == Quantity::Mean { run.mean_error } else { run.force_error };
            Measured { error, cost: run.ns_per_period }
        };
        runs.map(point).collect()
    }

    /// Settings that gave nothing, and why.
    pub fn failures(&self) -> impl Iterator<Item = (Setting, &str)> {
        self.points.iter().filter_map(|point| Some((point.setting, point.result.as_ref()?.as_ref().err()?.as_str())))
    }

    fn run(&mut self, index: usize, case: &Case, reference: &Reference) {
        let Some(point) = self.points.get_mut(index) else { return };
        if matches!(&point.result, Some(Err(_))) {
            return;
        }
        let known = point.result.as_ref().and_then(|result| result.as_ref().ok()).map(|run| run.ns_per_period);
        let periods = f64::from(case.periods);
        if known.is_some_and(|ns| ns * periods > LONG_NS) {
            return;
        }
        let run = self.peer.run(case, point.setting).map(|outcome| {
            let (mean_error, force_error) = reference.errors(&outcome);
            let ns = outcome.wall_ns / periods;
            Run { ns_per_period: known.map_or(ns, |least| least.min(ns)), mean_error, force_error }
        });
        point.result = Some(match run {
            Ok(run) if run.mean_error.is_finite() && run.force_error.is_finite() => Ok(run),
            Ok(_) => Err("no numbers came out".into()),
            Err(error) => Err(format!("{error:#}")),
        });
    }
}

/// Runs all entries in turn so many times, and tells after each round.
///
/// # Errors
/// If there is no reference for a number of periods.
pub fn run(entries: &mut [Entry], rounds: u32, report: impl Fn(&str)) -> anyhow::Result<()> {
    let lengths: BTreeSet<u32> = entries.iter().map(|entry| entry.periods).collect();
    let mut cases = BTreeMap::new();
    for periods in lengths {
        let case = Case::new(periods);
        let reference = Reference::new(&case)?;
        let (mean, force) = reference.apart;
        report(&format!(
            "reference over {periods} periods: mean friction ratio {:.15}; two methods differ by {mean:.0e}, in F by {force:.0e}",
            reference.mean()
        ));
        cases.insert(periods, (case, reference));
    }
    let finest = entries.iter().map(|entry| entry.points.len()).max().unwrap_or(0);
    for round in 1..=rounds {
        for index in 0..finest {
            for entry in entries.iter_mut() {
                if let Some((case, reference)) = cases.get(&entry.periods) {
                    entry.run(index, case, reference);
                }
            }
        }
        report(&format!("round {round} of {rounds} done"));
    }
    Ok(())
}
