//! Counts and statistics of many judged runs.

use std::collections::BTreeMap;

use firmware::seam::fault::Fault;
use sim::study::monte_carlo::statistics::{Spread, spread_of};

use super::outcome::{Judged, Outcome, PARAMETERS};

/// Standard deviations within which a stated value is to be, in 95 of 100 runs.
pub(super) const COVERED: f64 = 2.0;

/// What is counted of some runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Number of runs.
    pub runs: usize,
    /// Runs that end locked within the absolute bound.
    pub locked: usize,
    /// Runs that were locked outside it, and said so.
    pub named: usize,
    /// Runs that end locked outside it, and say nothing.
    pub silent: usize,
    /// Runs that a fault has ended that does not hold.
    pub accused: usize,
    /// Runs that a fault has ended that holds.
    pub refused: usize,
    /// Runs that were not locked in time.
    pub late: usize,
}

impl Counts {
    /// Counts these runs.
    pub(super) fn of<'a>(runs: impl Iterator<Item = &'a Judged>) -> Self {
        let mut counts = Counts::default();
        for judged in runs {
            counts.runs += 1;
            *match judged.outcome {
                Outcome::Locked => &mut counts.locked,
                Outcome::Named => &mut counts.named,
                Outcome::Silent => &mut counts.silent,
                Outcome::Accused(_) => &mut counts.accused,
                Outcome::Refused(_) => &mut counts.refused,
                Outcome::Late(_) => &mut counts.late,
            } += 1;
        }
        counts
    }
}

/// Statistics of some runs.
#[derive(Clone, Debug)]
pub(super) struct Summary {
    /// What is counted of the runs.
    pub counts: Counts,
    /// Size of the bias of all runs that end locked, Hz.
    pub bias_hz: Spread,
    /// Time to the bound, from the first block of the lock stage, of all runs that end locked, ms; infinite where the drive leaves the bound to the end.
    pub lock_ms: Spread,
    /// The same from power-on, ms.
    pub power_on_ms: Spread,
    /// Runs that end locked with a bias beyond three stated standard deviations.
    pub beyond_stated: usize,
    /// Runs that end locked further off than half a bandwidth.
    pub beyond_half_bandwidth: usize,
    /// Runs that state standard deviations.
    pub stated: usize,
    /// Of these, those of which the truth of each [parameter](PARAMETERS) is within two standard deviations.
    pub covered: [usize; PARAMETERS.len()],
}

impl Summary {
    /// Sums up these runs.
    pub(super) fn of<'a>(runs: impl Iterator<Item = &'a Judged> + Clone) -> Self {
        let end_locked = || runs.clone().filter(|judged| judged.bias_hz.is_some());
        let times =
            |of: fn(&Judged) -> Option<f64>| spread_of(end_locked().map(|run| of(run).unwrap_or(f64::INFINITY)).collect());
        let stated = || end_locked().filter_map(|judged| judged.stated);
        let covers = |place: usize| stated().filter(|stated| stated[place].covers(COVERED)).count();
        Summary {
            counts: Counts::of(runs.clone()),
            bias_hz: spread_of(end_locked().filter_map(|judged| judged.bias_hz.map(f64::abs)).collect()),
            lock_ms: times(|judged| judged.lock_ms),
            power_on_ms: times(|judged| judged.power_on_ms),
            beyond_stated: end_locked().filter(|judged| judged.beyond_stated == Some(true)).count(),
            beyond_half_bandwidth: end_locked().filter(|judged| judged.beyond_half_bandwidth == Some(true)).count(),
            stated: stated().count(),
            covered: std::array::from_fn(covers),
        }
    }
}

/// The fault that has ended a run, and whether what it says is true; the faults of a lock that has not come say only that.
pub(super) fn fault_of(judged: &Judged) -> Option<(Fault, bool)> {
    match judged.outcome {
        Outcome::Accused(fault) => Some((fault, false)),
        Outcome::Refused(fault) => Some((fault, true)),
        Outcome::Late(fault) => fault.map(|fault| (fault, true)),
        Outcome::Locked | Outcome::Named | Outcome::Silent => None,
    }
}

/// How often each fault has ended a run, by its number: in all, and where what it says is true.
pub(super) fn faults<'a>(runs: impl Iterator<Item = &'a Judged>) -> BTreeMap<u8, (Fault, usize, usize)> {
    let mut faults = BTreeMap::new();
    for (fault, holds) in runs.filter_map(fault_of) {
        let (_, all, holding) = faults.entry(fault.code()).or_insert((fault, 0, 0));
        *all += 1;
        *holding += usize::from(holds);
    }
    faults
}
