//! Runs one case: a search over every peer's settings, then the cheapest of them timed in rounds.
//!
//! The machine's noise affects all peers equally, because between two runs of one peer all others
//! run.

use crate::case::{Case, Kind};
use crate::choice;
use crate::peer::{Family, Peer, Setting, Way};
use crate::reference::Reference;
use report::statistics::{ascending, median};

/// Duration of a run, ns, after which the finer settings of its way are not tried.
const MAX_RUN_NS: f64 = 4e9;
/// Time for which a setting is repeated in a round, ns; the shortest run counts.
const ROUND_NS: f64 = 20e6;
/// Largest number of runs of a setting in a round.
const MAX_RUNS: u32 = 30;

/// Measurements of a peer in a case.
pub struct Entry {
    /// Name of the peer.
    pub name: String,
    /// Origin of the peer.
    pub family: Family,
    /// Number of periods of its runs.
    pub periods: u32,
    /// Settings of all its ways.
    pub points: Vec<Point>,
}

/// One setting of a peer, with its result.
pub struct Point {
    /// Way in which the peer is used.
    pub way: Way,
    /// Accuracy requested.
    pub setting: Setting,
    /// Errors and time, or the reason of the failure.
    pub result: Result<Run, String>,
    /// Time in each round, ns a period; empty if it is not among the cheapest for any error.
    pub rounds: Vec<f64>,
}

/// Errors and time of a run in the search.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// Wall time in the search, ns a period.
    pub searched_ns: f64,
    /// Error of the mean friction ratio.
    pub mean_error: f64,
    /// Error of the state at the end.
    pub end_error: f64,
}

/// Quantity whose error is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The mean friction ratio.
    Mean,
    /// The state at the end.
    End,
}

impl Quantity {
    /// Returns the name used in tables.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Mean => "mean",
            Quantity::End => "end",
        }
    }
}

impl Run {
    /// Returns the error of a quantity.
    pub fn error(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Mean => self.mean_error,
            Quantity::End => self.end_error,
        }
    }
}

impl Point {
    /// Returns the cost, ns a period: the median of the rounds, or the time in the search if it was
    /// not timed in rounds.
    pub fn ns(&self) -> Option<f64> {
        if self.rounds.is_empty() {
            return self.result.as_ref().ok().map(|run| run.searched_ns);
        }
        Some(median(&ascending(self.rounds.iter().copied())))
    }
}

/// All entries of a case.
pub struct Results {
    /// The case.
    pub kind: Kind,
    /// Entries, one per peer.
    pub entries: Vec<Entry>,
    /// Description of the reference.
    pub reference: String,
}

/// Runs a case.
///
/// # Errors
/// If the case has no reference.
pub fn run(
    kind: Kind,
    peers: &mut [Box<dyn Peer>],
    (periods, python_periods): (u32, u32),
    rounds: u32,
    report: &impl Fn(&str),
) -> anyhow::Result<Results> {
    let long = Case::new(kind, periods);
    let short = Case::new(kind, python_periods);
    let (long, short) = ((Reference::new(&long)?, long), (Reference::new(&short)?, short));
    let of = |family: Family| if family == Family::Python { &short } else { &long };
    let mut entries = Vec::new();
    for peer in peers.iter_mut() {
        let (reference, case) = of(peer.family());
        let points = search(peer.as_mut(), case, reference);
        report(&format!("{}: {} searched, {} settings", kind.name(), peer.name(), points.len()));
        entries.push(Entry { name: peer.name(), family: peer.family(), periods: case.periods, points });
    }
    let chosen: Vec<Vec<usize>> = entries.iter().map(|entry| choice::candidates(&entry.points)).collect();
    let most = chosen.iter().map(Vec::len).max().unwrap_or(0);
    for round in 1..=rounds {
        for turn in 0..most {
            for ((peer, entry), chosen) in peers.iter_mut().zip(&mut entries).zip(&chosen) {
                let Some(point) = chosen.get(turn).map(|&index| &mut entry.points[index]) else { continue };
                if let Some(ns) = time(peer.as_mut(), &of(entry.family).1, point) {
                    point.rounds.push(ns);
                }
            }
        }
        report(&format!("{}: round {round} of {rounds}", kind.name()));
    }
    let (reference, _) = &long;
    let (mean, end) = reference.apart;
    let reference = format!(
        "{}: mean friction ratio {:.15}, {} reversals in {} periods; the two references differ by {mean:.0e} in the mean, \
         {end:.0e} at the end",
        kind.name(),
        reference.mean(),
        reference.reversals,
        long.1.periods
    );
    Ok(Results { kind, entries, reference })
}

/// Runs every setting of a peer. Quick ones run twice, because the first run of a process is slow.
fn search(peer: &mut dyn Peer, case: &Case, reference: &Reference) -> Vec<Point> {
    let mut points = Vec::new();
    for way in peer.ways(case.kind) {
        for &setting in &way.settings {
            let mut result = search_once(peer, case, reference, &way, setting);
            if let Ok(run) = &mut result
                && run.searched_ns * f64::from(case.periods) < ROUND_NS
                && let Ok(again) = search_once(peer, case, reference, &way, setting)
            {
                run.searched_ns = run.searched_ns.min(again.searched_ns);
            }
            let too_long = result.as_ref().is_ok_and(|run| run.searched_ns * f64::from(case.periods) > MAX_RUN_NS);
            points.push(Point { way: way.clone(), setting, result, rounds: Vec::new() });
            if too_long {
                break;
            }
        }
    }
    points
}

fn search_once(peer: &mut dyn Peer, case: &Case, reference: &Reference, way: &Way, setting: Setting) -> Result<Run, String> {
    let outcome = peer.run(case, way, setting).map_err(|error| format!("{error:#}"))?;
    let (mean_error, end_error) = reference.errors(&outcome);
    if mean_error.is_finite() && end_error.is_finite() {
        Ok(Run { searched_ns: outcome.wall_ns / f64::from(case.periods), mean_error, end_error })
    } else {
        Err("the result is not a number".into())
    }
}

/// Returns a setting's shortest time in a round, ns a period.
fn time(peer: &mut dyn Peer, case: &Case, point: &Point) -> Option<f64> {
    let (mut least, mut spent, mut runs) = (f64::INFINITY, 0.0, 0);
    while spent < ROUND_NS && runs < MAX_RUNS {
        let wall_ns = peer.run(case, &point.way, point.setting).ok()?.wall_ns;
        (least, spent, runs) = (least.min(wall_ns), spent + wall_ns, runs + 1);
    }
    Some(least / f64::from(case.periods))
}
