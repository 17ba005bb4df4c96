//! Fuzzing: random and damaged input for every parser of external data. The input is structured, so
//! that it passes the first checks.
//!
//! ```text
//! seed --> input (valid | damaged | from the corpus) --> parser or board --> no panic, and the target's own checks --> outcomes, failures
//! ```
//!
//! Target and seed determine an input: `evidence fuzz --seed N` repeats the inputs of one seed. The
//! folder `corpus` contains inputs that reach deep; they run first, and others are made from them.

mod corpus;
mod flash;
mod frames;
mod link;
mod replies;
mod scenes;
mod scripts;
pub(crate) mod soak;
mod suites;
mod tables;
mod target;
mod text;
mod updates;

#[cfg(test)]
mod tests;

use std::time::Instant;

use self::target::{Tally, Target};
use crate::campaign::{cells, columns};
use crate::evidence::{Error, Evidence, Options};
use report::{Report, TableBlock};
use sim::study::StudyError;

/// Millions of bytes sent over the link, full and quick; the other targets scale with it.
const MILLIONS: [u32; 2] = [100, 2];
/// Largest number of failures that are listed for each target.
const MAX_LISTED: usize = 20;

/// All targets.
const TARGETS: [Target; 8] = [
    link::TARGET,
    replies::TARGET,
    flash::TARGET,
    scenes::TARGET,
    suites::TARGET,
    scripts::TARGET,
    updates::TARGET,
    tables::TARGET,
];

/// Runs all targets, and returns the evidence.
pub(crate) fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let millions = options.count.unwrap_or(MILLIONS[usize::from(options.quick)]);
    let (mut rows, mut kinds, mut missed) = (Vec::new(), Vec::new(), Vec::new());
    for target in &TARGETS {
        (options.progress)(target.name);
        let began = Instant::now();
        let (tally, failures) = match options.seed {
            Some(seed) => target.run(seed..seed + 1, options.stop),
            None => target.run(0..target.seeds(millions), options.stop),
        }
        .ok_or(StudyError::Interrupted)?;
        rows.push(row(target, &tally, failures.len(), began.elapsed().as_secs_f64()));
        kinds.extend(tally.outcomes.iter().map(|(kind, count)| cells![target.name, kind, count]));
        missed.extend(failures.into_iter().take(MAX_LISTED));
    }
    let header = columns("target | kind of input | inputs | bytes | distinct outcomes | failures | time [s] | Mbyte/s");
    let caption = "Inputs: pieces of traffic, contents of a flash, texts, files. Failures: panics, and violations of the \
                   target's own checks.";
    let table = TableBlock::new("fuzz", "Fuzzing, by target", caption, &header, rows);
    let outcomes =
        TableBlock::new("outcomes", "Outcomes", "Number of times each was reached.", &["target", "outcome", "count"], kinds);
    Ok(Evidence {
        printed: Some(vec![table.clone()]),
        docs: vec![table.clone()],
        report: Report { title: "Fuzzing: random and damaged input".into(), tables: vec![table, outcomes], ..Report::default() },
        missed,
        ..Evidence::default()
    })
}

fn row(target: &Target, tally: &Tally, failures: usize, seconds: f64) -> Vec<String> {
    let (time, rate) = (format!("{seconds:.1}"), format!("{:.2}", tally.bytes as f64 / seconds.max(1e-3) / 1e6));
    cells![target.name, target.what, tally.inputs, tally.bytes, tally.outcomes.len(), failures, time, rate]
}
