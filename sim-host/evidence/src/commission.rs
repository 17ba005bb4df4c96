//! Commissioning: how many transducers of the random set of [`transducers`](crate::transducers) `sim-host link PORT commission` finds from a band alone.
//!
//! ```text
//! transducer (draw), its front end, a band --> simulated board --> `commission` --> judged against the plant --> tables, commission.csv
//! ```
//!
//! All of it is simulated (SIL).

mod judged;
mod tables;
mod watched_board;

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use self::judged::{Judged, judge};
use crate::evidence::{Error, Evidence, Options};
use crate::transducers::draw::Transducer;
use report::Report;
use sim::study::StudyError;

/// Transducers, and those of the quick variant, where no other number is given: as many of each kind.
const SET: [u32; 2] = [60, 12];
/// Part of the transducers that is to be right, and in time.
const RIGHT: f64 = 0.98;

/// A transducer, and what its commissioning has come to.
struct Tried {
    transducer: Transducer,
    command: String,
    judged: Judged,
}

/// Commissions the transducers.
pub(crate) fn run(options: &mut Options) -> Result<Evidence, Error> {
    let number = options.count.unwrap_or(SET[usize::from(options.quick)]);
    (options.progress)(&format!("{number} transducers"));
    let stop = options.stop;
    let try_one = |number: u32| {
        if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Err(StudyError::Interrupted.into());
        }
        let transducer = Transducer::draw(number);
        let (command, judged) = judge(&transducer)?;
        Ok(Tried { transducer, command, judged })
    };
    let set = (0..number).into_par_iter().map(try_one).collect::<Result<Vec<Tried>, Error>>()?;
    let tables = tables::tables(&set);
    Ok(Evidence {
        report: Report {
            title: "Commissioning: how many transducers are found from a band alone".into(),
            subtitle: "Simulated: `sim-host link PORT commission` against the firmware on the host and the simulated stack"
                .into(),
            tables: tables.clone(),
            ..Report::default()
        },
        files: vec![("commission.csv", tables::csv(&set)?)],
        docs: tables,
        missed: missed(&set),
        ..Evidence::default()
    })
}

/// The targets that are missed.
fn missed(set: &[Tried]) -> Vec<String> {
    let mut missed = Vec::new();
    let right = set.iter().filter(|tried| tried.judged.is_right() && tried.judged.is_in_time()).count();
    if (right as f64) < RIGHT * set.len() as f64 {
        missed.push(format!("{right} of {} right and in time, and {:.0} % are to be", set.len(), 100.0 * RIGHT));
    }
    for tried in set {
        let Judged { loudest_v, loudest_a, .. } = tried.judged;
        if tried.judged.is_silent() {
            missed.push(format!("silently wrong: {}", tried.command));
        }
        if loudest_v > 1.0 || loudest_a > 1.0 {
            missed.push(format!("too loud, {loudest_v:.3} of the volts, {loudest_a:.3} of the amperes: {}", tried.command));
        }
    }
    missed
}

#[cfg(test)]
mod tests {
    use super::run;
    use crate::evidence::Options;

    /// The quick variant has no silent failure and is never too loud. How many are right stands in docs/evidence/transducers.md.
    #[test]
    fn none_is_silently_wrong_or_too_loud() {
        let mut options = Options { quick: true, count: None, seed: None, counted: None, stop: None, progress: &mut |_| () };
        let evidence = run(&mut options).unwrap_or_else(|error| panic!("{error}"));
        let missed: Vec<_> = evidence.missed.iter().filter(|missed| !missed.contains("right and in time")).collect();
        assert!(missed.is_empty(), "{missed:?}");
    }
}
