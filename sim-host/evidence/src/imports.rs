//! Imports synthetic measurements of varied transducers, formats, noise and fixtures, and compares
//! the results with the truth.
//!
//! ```text
//! seed -> example (import::synthetic) -> import -> values and deviations against truth and bound --+
//!                   |                                                                               +--> tables, imports.csv, friction.csv
//!                   +-> damaged bytes -> import -> refused with a reason, or imported; never a panic +
//! ```

mod friction;
mod judged;
mod tables;

use self::judged::{Damaged, Judged, damaged, judge};
use crate::campaign::{self, each};
use crate::evidence::{Error, Evidence, Options};

/// Default number of files, full and quick.
const FILES: [u32; 2] = [600, 60];
/// Number of damaged files, full and quick.
const DAMAGED: [u32; 2] = [10_000, 500];
/// Number of friction logs, full and quick.
const LOGS: [u32; 2] = [500, 40];
/// Smallest fraction of the truths within two standard deviations, for each number.
const MIN_COVERAGE: f64 = 0.93;
/// Largest fraction of the truths within two standard deviations, for each number.
const MAX_COVERAGE: f64 = 0.98;
/// Largest median ratio of a standard deviation to its Cramér-Rao bound.
const MAX_BOUND_RATIO: f64 = 1.5;

/// Imports the files, undamaged and damaged, and returns the evidence.
pub(crate) fn run(options: &mut Options) -> Result<Evidence, Error> {
    let quick = usize::from(options.quick);
    let (files, broken) = (options.count.unwrap_or(FILES[quick]), DAMAGED[quick]);
    (options.progress)(&format!("{files} files"));
    let set = each(files, options.stop, |number| Ok(judge(number.into())))?;
    (options.progress)(&format!("{broken} damaged files"));
    let ruined = each(broken, options.stop, |number| Ok(damaged(number.into())))?;
    let logs = LOGS[quick];
    (options.progress)(&format!("{logs} friction logs"));
    let logs = each(logs, options.stop, |number| Ok(friction::judge(number.into())))?;
    let mut tables = tables::tables(&set, &ruined);
    tables.push(friction::table(&logs));
    let subtitle = "Transducers, sweeps, noise, fixtures and file formats drawn from a seed";
    let files = vec![("imports.csv", tables::csv(&set)?), ("friction.csv", friction::csv(&logs)?)];
    let missed = [missed(&set, &ruined), friction::missed(&logs)].concat();
    Ok(campaign::evidence("Import: synthetic measurements against their truth", subtitle, tables, files, missed))
}

/// Returns the targets that are missed.
fn missed(set: &[Judged], ruined: &[Damaged]) -> Vec<String> {
    let mut missed: Vec<String> =
        set.iter().filter_map(|judged| judged.refused.as_ref().map(|why| format!("file {}: {why}", judged.number))).collect();
    // Additional deviation by chance in fewer files than the full number.
    let chance = |files: f64| 2.0 * (0.05 * 0.95 / files).sqrt();
    let found = set.iter().filter(|judged| judged.refused.is_none()).count().max(1);
    let slack = (chance(found as f64) - chance(f64::from(FILES[0]))).max(0.0);
    for row in judged::statistics(set) {
        if !(MIN_COVERAGE - slack..=MAX_COVERAGE + slack).contains(&row.within) {
            missed.push(format!("{}: {:.1} % of the truths within two standard deviations", row.name, 100.0 * row.within));
        }
        if row.median > MAX_BOUND_RATIO {
            missed.push(format!("{}: standard deviation {:.2} times the bound in the median", row.name, row.median));
        }
    }
    let panics: Vec<String> = ruined
        .iter()
        .filter(|file| matches!(file.end, judged::ImportResult::Panic))
        .map(|file| file.number.to_string())
        .collect();
    if !panics.is_empty() {
        missed.push(format!("panics at damaged files {}", panics.join(", ")));
    }
    missed
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_quick_variant_reaches_its_targets() {
        assert_eq!(crate::campaign::quick(super::run, None).missed, [""; 0]);
    }
}
