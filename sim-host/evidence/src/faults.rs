//! Injects faults between a board and the controller, in many transducers and drives, and judges
//! the response.
//!
//! ```text
//! plant --> converters --> [corrupted] --> controller --> [corrupted] --> amplifier --> plant
//!                              (injected)                     |
//!                       record, compared with the plant (verdict) --> tables
//! ```
//!
//! A failure begins during the drive or during the start, and lasts. For each place, runs without a
//! failure show the rate of false reports.

mod codes;
mod injected;
mod kinds;
mod place;
mod table;
mod verdict;

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use self::kinds::Kind;
use self::place::{PLACES, Place, Running};
use self::verdict::{Verdict, judge};
use crate::campaign::{self, KindRuns};
use crate::evidence::{Error, Evidence, Options};

/// Number of runs of each kind, spread over all places in which it can happen.
const KIND_RUNS: u32 = 1200;
/// Number of runs without a failure.
const CALM_RUNS: u32 = 12_000;
/// Number of runs of each kind in each place, in the quick variant.
const QUICK_RUNS: u32 = 2;
/// Number of runs without a failure in each place, in the quick variant.
const QUICK_CALM_RUNS: u32 = 8;
/// Ratio of runs without a failure to runs of each kind, if the user gives the number of runs.
const CALM_PER_RUN: u32 = 10;

/// A run with its verdict.
struct FaultRun {
    place: &'static Place,
    seed: u64,
    verdict: Verdict,
}

/// Runs all kinds in all places, and returns the evidence.
pub(crate) fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let each = |quick, all| if options.quick { RunCount::InEach(quick) } else { RunCount::OfAll(all) };
    let (failing, calm) = match options.count {
        Some(count) => (RunCount::InEach(count), RunCount::InEach(CALM_PER_RUN * count)),
        None => (each(QUICK_RUNS, KIND_RUNS), each(QUICK_CALM_RUNS, CALM_RUNS)),
    };
    (options.progress)("pilots");
    let places = PLACES.par_iter().map(Place::pilot).collect::<Result<Vec<_>, _>>()?;
    let mut tried = Vec::new();
    for kind in kinds::all() {
        (options.progress)(kind.name);
        tried.push(KindRuns { kind, runs: runs(&places, Some(kind), failing)? });
    }
    (options.progress)("without a failure");
    let calm = runs(&places, None, calm)?;
    (options.progress)("every code");
    let (codes, not_raised) = codes::raise_all()?;
    let missed = table::missed(&tried, &calm).into_iter().chain(not_raised).collect();
    let tables = table::tables(&tried, &calm).into_iter().chain([codes]).collect();
    let subtitle = "Simulated: the controller on the host, against the simulated stack and its converters";
    let files = vec![("faults.csv", table::csv(&tried, &calm)?)];
    Ok(campaign::evidence("Fault response of the controller", subtitle, tables, files, missed))
}

/// Number of runs, in each place or in all places together.
#[derive(Clone, Copy)]
enum RunCount {
    InEach(u32),
    OfAll(u32),
}

/// Runs a kind, or no failure, in all places in which it can happen.
fn runs(places: &[Running], kind: Option<&Kind>, number: RunCount) -> Result<Vec<FaultRun>, Error> {
    let here: Vec<&Running> = places.iter().filter(|running| kind.is_none_or(|kind| running.has(kind))).collect();
    let number = match number {
        RunCount::InEach(number) => number,
        RunCount::OfAll(number) => number.div_ceil(here.len() as u32),
    };
    let all: Vec<_> = here.iter().flat_map(|&running| (0..u64::from(number)).map(move |seed| (running, seed))).collect();
    let one = |&(running, seed): &(&Running, u64)| {
        Ok(FaultRun { place: running.place, seed, verdict: judge(&running.fail(kind, seed)?) })
    };
    all.par_iter().map(one).collect()
}
