//! Faults: what fails at the seam between a board and the controller, in which transducer and how driven, and what becomes of it.
//!
//! ```text
//! plant --> converters --> [spoilt] --> controller --> [spoilt] --> amplifier --> plant
//!                              (injected)                  |
//!                       record, against the plant (verdict) --> tables
//! ```
//!
//! A failure comes while the drive runs, or on its way there, and lasts. Beside each place as many runs without a failure show how often something is said of nothing.

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
use crate::evidence::{Error, Evidence, Options};
use report::Report;

/// Runs of each kind, by turns in all places that it can happen in, and those without a failure.
const RUNS: u32 = 1200;
const CALM: u32 = 12_000;
/// Those in each place of the quick variant.
const QUICK: u32 = 2;
const QUICK_CALM: u32 = 8;
/// Runs without a failure to each run of a kind.
const CALM_EACH: u32 = 10;

/// A run, judged.
struct Tried {
    place: &'static Place,
    seed: u64,
    verdict: Verdict,
}

/// Runs all kinds in all places.
pub(crate) fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let each = |quick, all| if options.quick { Number::InEach(quick) } else { Number::OfAll(all) };
    let (failing, calm) = match options.count {
        Some(count) => (Number::InEach(count), Number::InEach(CALM_EACH * count)),
        None => (each(QUICK, RUNS), each(QUICK_CALM, CALM)),
    };
    (options.progress)("pilots");
    let places = PLACES.par_iter().map(Place::pilot).collect::<Result<Vec<_>, _>>()?;
    let mut tried = Vec::new();
    for kind in kinds::all() {
        (options.progress)(kind.name);
        tried.push(runs(&places, Some(kind), failing)?);
    }
    (options.progress)("without a failure");
    let calm = runs(&places, None, calm)?;
    (options.progress)("every code");
    let (codes, not_raised) = codes::raised()?;
    let missed = table::missed(&tried, &calm).into_iter().chain(not_raised).collect();
    let tables: Vec<_> = table::tables(&tried, &calm).into_iter().chain([codes]).collect();
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

/// How many runs.
#[derive(Clone, Copy)]
enum Number {
    InEach(u32),
    OfAll(u32),
}

/// Runs in which this kind fails, or nothing does, in all places that it can fail in.
fn runs(places: &[Running], kind: Option<&Kind>, number: Number) -> Result<Vec<Tried>, Error> {
    let here: Vec<&Running> = places.iter().filter(|running| kind.is_none_or(|kind| running.has(kind))).collect();
    let number = match number {
        Number::InEach(number) => number,
        Number::OfAll(number) => number.div_ceil(here.len() as u32),
    };
    let all: Vec<_> = here.iter().flat_map(|&running| (0..u64::from(number)).map(move |seed| (running, seed))).collect();
    let one =
        |&(running, seed): &(&Running, u64)| Ok(Tried { place: running.place, seed, verdict: judge(&running.fail(kind, seed)?) });
    all.par_iter().map(one).collect()
}
