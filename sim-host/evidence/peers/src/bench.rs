//! The run of one case: a search over every peer's settings, then the cheapest of them timed in rounds.
//!
//! Noise of the machine passes over all peers alike, because between two runs of one peer all others have had theirs.

use crate::case::{Case, Kind};
use crate::choice;
use crate::peer::{Family, Peer, Setting, Way};
use crate::reference::Reference;
use report::statistics::{ascending, median};

/// A run longer than this, ns, ends the search over finer settings of its way.
const TOO_LONG_NS: f64 = 4e9;
/// In a round, a setting is run again until this has passed, ns; the least time counts.
const ROUND_NS: f64 = 20e6;
/// Most runs of a setting in a round.
const MOST_RUNS: u32 = 30;

/// A peer in a case, with what was measured of it.
pub struct Entry {
    /// Name of the peer.
    pub name: String,
    /// Where it comes from.
    pub family: Family,
    /// Periods that it was run over.
    pub periods: u32,
    /// The settings of all its ways.
    pub points: Vec<Point>,
}

/// A setting of a peer.
pub struct Point {
    /// Which of its ways.
    pub way: Way,
    /// The accuracy that was asked for.
    pub setting: Setting,
    /// What came out, or why nothing did.
    pub result: Result<Run, String>,
    /// Time in each round, ns a period; empty if it is nowhere among the cheapest.
    pub rounds: Vec<f64>,
}

/// Errors and time in the search.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// Wall time in the search, ns a period.
    pub searched_ns: f64,
    /// Error of the mean friction ratio.
    pub mean_error: f64,
    /// Error of the state at the end.
    pub end_error: f64,
}

/// What an error is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The mean friction ratio.
    Mean,
    /// The state at the end.
    End,
}

impl Quantity {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Mean => "mean",
            Quantity::End => "end",
        }
    }
}

impl Run {
    /// Error of a quantity.
    pub fn error(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Mean => self.mean_error,
            Quantity::End => self.end_error,
        }
    }
}

impl Point {
    /// What is stated as its cost: the median of the rounds, or of those that were not timed what the search saw, ns a period.
    pub fn ns(&self) -> Option<f64> {
        if self.rounds.is_empty() {
            return self.result.as_ref().ok().map(|run| run.searched_ns);
        }
        Some(median(&ascending(self.rounds.iter().copied())))
    }
}

/// All entries of a case.
pub struct Results {
    /// Which case.
    pub kind: Kind,
    /// One for each peer.
    pub entries: Vec<Entry>,
    /// What the reference is, in words.
    pub reference: String,
}

/// Runs a case.
///
/// # Errors
/// If there is no reference.
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
        "{}: mean friction ratio {:.15}, {} reversals in {} periods; the two references differ by {mean:.0e} in the mean, {end:.0e} at the end",
        kind.name(),
        reference.mean(),
        reference.reversals,
        long.1.periods
    );
    Ok(Results { kind, entries, reference })
}

/// Every setting of a peer; the quick ones twice, as the first run of a process is slow.
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
            let too_long = result.as_ref().is_ok_and(|run| run.searched_ns * f64::from(case.periods) > TOO_LONG_NS);
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
        Err("no numbers came out".into())
    }
}

/// A setting's time in a round, ns a period.
fn time(peer: &mut dyn Peer, case: &Case, point: &Point) -> Option<f64> {
    let (mut least, mut spent, mut runs) = (f64::INFINITY, 0.0, 0);
    while spent < ROUND_NS && runs < MOST_RUNS {
        let wall_ns = peer.run(case, &point.way, point.setting).ok()?.wall_ns;
        (least, spent, runs) = (least.min(wall_ns), spent + wall_ns, runs + 1);
    }
    Some(least / f64::from(case.periods))
}
