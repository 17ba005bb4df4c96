//! Faults: what fails at the seam between a board and the controller, in which transducer and how driven, and what becomes of it.
//!
//! ```text
//! plant --> converters --> [spoilt] --> controller --> [spoilt] --> amplifier --> plant
//!                              (injected)                  |
//!                       record, against the plant (verdict) --> tables
//! ```
//!
//! A failure comes while the drive runs, and lasts. Beside each place as many runs without a failure show how often something is said of nothing.

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
use crate::evidence::{Error, Evidence, Options};
use report::Report;

/// Runs of each kind in each place, and of its quick variant; and those without a failure.
const RUNS: [u32; 2] = [170, 2];
const CALM: [u32; 2] = [CALM_EACH * RUNS[0], 8];
const CALM_EACH: u32 = 10;

/// A run, judged.
struct Tried {
    place: &'static Place,
    seed: u64,
    verdict: Verdict,
}

/// Runs all kinds in all places.
pub(crate) fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let quick = usize::from(options.quick);
    (options.progress)("pilots");
    let places = PLACES.par_iter().map(Place::pilot).collect::<Result<Vec<_>, _>>()?;
    let mut tried = Vec::new();
    for kind in kinds::all() {
        (options.progress)(kind.name);
        tried.push(runs(&places, Some(kind), options.count.unwrap_or(RUNS[quick]))?);
    }
    (options.progress)("without a failure");
    let calm = runs(&places, None, options.count.map_or(CALM[quick], |count| CALM_EACH * count))?;
    let missed = table::missed(&tried, &calm);
    let tables = table::tables(&tried, &calm);
    Ok(Evidence {
        report: Report {
            title: "Faults: what fails at the seam, and what becomes of it".into(),
            subtitle: "Simulated: the controller on the host, against the simulated stack and its converters".into(),
            tables: tables.clone(),
            ..Report::default()
        },
        files: vec![("faults.csv", table::csv(&tried, &calm)?)],
        docs: tables,
        missed,
        ..Evidence::default()
    })
}

fn runs(places: &[Running], kind: Option<&Kind>, number: u32) -> Result<Vec<Tried>, Error> {
    let here = places.iter().filter(|running| kind.is_none_or(|kind| running.has(kind)));
    let all = here.flat_map(|running| (0..u64::from(number)).map(move |seed| (running, seed)));
    let all: Vec<_> = all.collect();
    let one =
        |&(running, seed): &(&Running, u64)| Ok(Tried { place: running.place, seed, verdict: judge(&running.fail(kind, seed)?) });
    all.par_iter().map(one).collect()
}
