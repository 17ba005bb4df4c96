//! Counts and statistics of many judged runs.

use std::collections::BTreeMap;

use firmware::seam::fault::Fault;
use sim::study::monte_carlo::statistics::{Spread, spread_of};

use super::outcome::{JudgedRun, Outcome, PARAMETERS};

/// Number of standard deviations within which 95 of 100 stated values should be.
pub(super) const COVERED_SIGMAS: f64 = 2.0;

/// Counts of some runs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Number of runs.
    pub runs: usize,
    /// Runs that end locked within the absolute bound.
    pub locked: usize,
    /// Runs that end locked outside the absolute bound, with a loss of at most 1 %.
    pub good: usize,
    /// Runs that reported a doubtful lock.
    pub reported: usize,
    /// Runs that end locked with a larger loss, without a report.
    pub silent: usize,
    /// Runs that ended in a false fault.
    pub false_faults: usize,
    /// Runs that ended in a true fault.
    pub true_faults: usize,
    /// Runs that were not locked in time.
    pub late: usize,
}

impl Counts {
    /// Counts these runs.
    pub(super) fn from_runs<'a>(runs: impl Iterator<Item = &'a JudgedRun>) -> Self {
        let mut counts = Counts::default();
        for judged in runs {
            counts.runs += 1;
            *match judged.outcome {
                Outcome::Locked => &mut counts.locked,
                Outcome::Good => &mut counts.good,
                Outcome::Reported => &mut counts.reported,
                Outcome::Silent => &mut counts.silent,
                Outcome::FalseFault(_) => &mut counts.false_faults,
                Outcome::TrueFault(_) => &mut counts.true_faults,
                Outcome::Late(_) => &mut counts.late,
            } += 1;
        }
        counts
    }
}

/// Statistics of some runs.
#[derive(Clone, Debug)]
pub(super) struct Summary {
    /// Counts of the runs.
    pub counts: Counts,
    /// Absolute bias of all runs that end locked, Hz.
    pub bias_hz: Spread,
    /// Time from the first block of the lock stage to the bound, of all runs that end locked, ms;
    /// infinite if the drive leaves the bound at the end.
    pub lock_ms: Spread,
    /// Time from power-on to the bound, of all runs that end locked, ms.
    pub power_on_ms: Spread,
    /// Runs that end locked with a bias beyond three stated standard deviations.
    pub beyond_stated: usize,
    /// Runs that end locked with a bias beyond half a bandwidth.
    pub beyond_half_bandwidth: usize,
    /// Runs that state standard deviations.
    pub stated: usize,
    /// Number of these runs for which the truth of each [parameter](PARAMETERS) is within two
    /// stated standard deviations.
    pub covered: [usize; PARAMETERS.len()],
}

impl Summary {
    /// Computes the statistics of these runs.
    pub(super) fn from_runs<'a>(runs: impl Iterator<Item = &'a JudgedRun> + Clone) -> Self {
        let end_locked = || runs.clone().filter(|judged| judged.bias_hz.is_some());
        let times =
            |of: fn(&JudgedRun) -> Option<f64>| spread_of(end_locked().map(|run| of(run).unwrap_or(f64::INFINITY)).collect());
        let stated = || end_locked().filter_map(|judged| judged.stated);
        let covers = |place: usize| stated().filter(|stated| stated[place].covers(COVERED_SIGMAS)).count();
        Summary {
            counts: Counts::from_runs(runs.clone()),
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

/// Returns the fault that ended a run, with `true` if it is a true fault; faults 31 and 32 report a
/// missing lock and are always true.
pub(super) fn fault_of(judged: &JudgedRun) -> Option<(Fault, bool)> {
    match judged.outcome {
        Outcome::FalseFault(fault) => Some((fault, false)),
        Outcome::TrueFault(fault) => Some((fault, true)),
        Outcome::Late(fault) => fault.map(|fault| (fault, true)),
        Outcome::Locked | Outcome::Good | Outcome::Reported | Outcome::Silent => None,
    }
}

/// Counts the faults that ended runs, by fault number: all of them, and the true ones.
pub(super) fn faults<'a>(runs: impl Iterator<Item = &'a JudgedRun>) -> BTreeMap<u8, (Fault, usize, usize)> {
    let mut faults = BTreeMap::new();
    for (fault, holds) in runs.filter_map(fault_of) {
        let (_, all, holding) = faults.entry(fault.code()).or_insert((fault, 0, 0));
        *all += 1;
        *holding += usize::from(holds);
    }
    faults
}
