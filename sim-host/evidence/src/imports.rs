//! Measured data in: synthetic measurements of varied transducers, formats, noise and fixtures, imported and held against their truth.
//!
//! ```text
//! seed -> example (import::synthetic) -> import -> values and deviations against truth and bound --+
//!                   |                                                                               +--> tables, imports.csv, friction.csv
//!                   +-> damaged bytes -> import -> refused by name, or taken; never a panic --------+
//! ```

mod friction;
mod judged;
mod tables;

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use self::judged::{Damaged, Judged, damaged, judge};
use crate::evidence::{Error, Evidence, Options};
use report::Report;
use sim::study::StudyError;

/// Files, and those of the quick variant, where no other number is given.
const FILES: [u32; 2] = [600, 60];
/// Damaged files, and those of the quick variant.
const DAMAGED: [u32; 2] = [10_000, 500];
/// Friction logs, and those of the quick variant.
const LOGS: [u32; 2] = [500, 40];
/// Part of the truths that is to be within two standard deviations, of each number.
const COVERAGE: (f64, f64) = (0.93, 0.98);
/// Largest median of a standard deviation over its Cramér-Rao bound.
const EFFICIENCY: f64 = 1.5;

/// Imports the files, whole and damaged.
pub(crate) fn run(options: &mut Options) -> Result<Evidence, Error> {
    let quick = usize::from(options.quick);
    let (files, broken) = (options.count.unwrap_or(FILES[quick]), DAMAGED[quick]);
    (options.progress)(&format!("{files} files"));
    let set = each(files, options.stop, |number| judge(number.into()))?;
    (options.progress)(&format!("{broken} damaged files"));
    let ruined = each(broken, options.stop, |number| damaged(number.into()))?;
    let logs = LOGS[quick];
    (options.progress)(&format!("{logs} friction logs"));
    let logs = each(logs, options.stop, |number| friction::judge(number.into()))?;
    let mut tables = tables::tables(&set, &ruined);
    tables.push(friction::table(&logs));
    Ok(Evidence {
        report: Report {
            title: "Import: synthetic measurements against their truth".into(),
            subtitle: "Transducers, sweeps, noise, fixtures and file formats drawn from a seed".into(),
            tables: tables.clone(),
            ..Report::default()
        },
        files: vec![("imports.csv", tables::csv(&set)?), ("friction.csv", friction::csv(&logs)?)],
        docs: tables,
        missed: [missed(&set, &ruined), friction::missed(&logs)].concat(),
        ..Evidence::default()
    })
}

/// Something for each number, unless it is stopped.
fn each<T: Send>(count: u32, stop: Option<&AtomicBool>, of: impl Fn(u32) -> T + Sync) -> Result<Vec<T>, Error> {
    let one = |number: u32| match stop {
        Some(stop) if stop.load(Ordering::Relaxed) => Err(StudyError::Interrupted.into()),
        _ => Ok(of(number)),
    };
    (0..count).into_par_iter().map(one).collect()
}

/// The targets that are missed.
fn missed(set: &[Judged], ruined: &[Damaged]) -> Vec<String> {
    let mut missed: Vec<String> =
        set.iter().filter_map(|judged| judged.refused.as_ref().map(|why| format!("file {}: {why}", judged.number))).collect();
    // What chance adds in fewer files than the full number.
    let chance = |files: f64| 2.0 * (0.05 * 0.95 / files).sqrt();
    let found = set.iter().filter(|judged| judged.refused.is_none()).count().max(1);
    let slack = (chance(found as f64) - chance(f64::from(FILES[0]))).max(0.0);
    for row in judged::statistics(set) {
        if !(COVERAGE.0 - slack..=COVERAGE.1 + slack).contains(&row.within) {
            missed.push(format!("{}: {:.1} % of the truths within two standard deviations", row.name, 100.0 * row.within));
        }
        if row.median > EFFICIENCY {
            missed.push(format!("{}: standard deviation {:.2} times the bound in the median", row.name, row.median));
        }
    }
    let panics: Vec<String> =
        ruined.iter().filter(|file| matches!(file.end, judged::End::Panic)).map(|file| file.number.to_string()).collect();
    if !panics.is_empty() {
        missed.push(format!("panics at damaged files {}", panics.join(", ")));
    }
    missed
}

#[cfg(test)]
mod tests {
    use super::run;
    use crate::evidence::Options;

    #[test]
    fn the_quick_variant_reaches_its_targets() {
        let mut options = Options { quick: true, count: None, seed: None, counted: None, stop: None, progress: &mut |_| () };
        let evidence = run(&mut options).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(evidence.missed, [""; 0]);
    }
}
