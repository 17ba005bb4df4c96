//! Fuzzing: random and damaged input for whatever reads what others have written, made by its structure, so that it comes past the first check.
//!
//! ```text
//! seed --> input (honest | damaged | of parts of the corpus) --> what reads it --> no panic, and the target's own judgement --> outcomes, failures
//! ```
//!
//! An input follows from its target and its seed alone: `evidence fuzz --seed N` repeats those of one seed. The folder `corpus` has inputs that
//! reach deep, from which others are made, and which are run first.

mod corpus;
mod flash;
mod frames;
mod link;
mod replies;
mod scenes;
mod scripts;
pub(crate) mod soak;
mod suites;
mod target;
mod text;
mod updates;

#[cfg(test)]
mod tests;

use std::time::Instant;

use self::target::{Seen, Target};
use crate::evidence::{Error, Evidence, Options};
use report::{Report, TableBlock};
use sim::study::StudyError;

/// Millions of bytes that are sent over the link, and those of the quick variant; the other targets follow in proportion.
const MILLIONS: [u32; 2] = [100, 2];
/// Failures that are named, of each target.
const NAMED: usize = 20;

/// All targets.
const TARGETS: [Target; 7] =
    [link::TARGET, replies::TARGET, flash::TARGET, scenes::TARGET, suites::TARGET, scripts::TARGET, updates::TARGET];

/// Runs all targets.
pub(crate) fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let millions = options.count.unwrap_or(MILLIONS[usize::from(options.quick)]);
    let (mut rows, mut kinds, mut missed) = (Vec::new(), Vec::new(), Vec::new());
    for target in &TARGETS {
        (options.progress)(target.name);
        let began = Instant::now();
        let (seen, failures) = match options.seed {
            Some(seed) => target.run(seed..seed + 1, options.stop),
            None => target.run(0..target.seeds(millions), options.stop),
        }
        .ok_or(StudyError::Interrupted)?;
        rows.push(row(target, &seen, failures.len(), began.elapsed().as_secs_f64()));
        kinds.extend(seen.outcomes.iter().map(|(kind, count)| vec![target.name.into(), kind.clone(), count.to_string()]));
        missed.extend(failures.into_iter().take(NAMED));
    }
    let header = ["target", "what is fed", "inputs", "bytes", "distinct outcomes", "failures", "time [s]", "Mbyte/s"];
    let caption = "Inputs: pieces of traffic, contents of a flash, texts, files. Failures: panics, and whatever the target's own judgement does not let pass.";
    let table = TableBlock::new("fuzz", "Fuzzed", caption, &header, rows);
    let outcomes = TableBlock::new("outcomes", "Outcomes", "How often each was reached.", &["target", "outcome", "count"], kinds);
    Ok(Evidence {
        printed: Some(vec![table.clone()]),
        docs: vec![table.clone()],
        report: Report { title: "Fuzzing: random and damaged input".into(), tables: vec![table, outcomes], ..Report::default() },
        missed,
        ..Evidence::default()
    })
}

fn row(target: &Target, seen: &Seen, failures: usize, seconds: f64) -> Vec<String> {
    vec![
        target.name.into(),
        target.what.into(),
        seen.inputs.to_string(),
        seen.bytes.to_string(),
        seen.outcomes.len().to_string(),
        failures.to_string(),
        format!("{seconds:.1}"),
        format!("{:.2}", seen.bytes as f64 / seconds.max(1e-3) / 1e6),
    ]
}
