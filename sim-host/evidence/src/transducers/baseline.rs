//! The baseline: recorded counts, of which none may become worse.
//!
//! `baseline.csv` has a row for each kind of the random set and of the wider one, one for the whole
//! set by the phase loop, and one for each case, in the quick and the full variant. A row is worse
//! than its baseline if fewer runs lock within the bound, if fewer are good (these included), if
//! more lock with a larger loss without a report, or if more end in a false fault.
//! `UPDATE_DOCS=1 cargo test -p sonoglide-evidence docs -- --include-ignored` writes it, with the
//! tables.

use std::fmt::Write;

use super::draw::KINDS;
use super::summary::Counts;
use super::{CaseRuns, RepeatableRun, TransducerRuns};
use crate::transducers::outcome::Outcome;

/// Name of the file.
pub(super) const FILE: &str = "baseline.csv";
const BASELINE: &str = include_str!("baseline.csv");
const HEADER: &str = "variant;what;runs;locked;good;silent;accused"; // words: columns of the file

/// Counts of one row, with commands of bad runs.
#[derive(Clone, Debug)]
pub(super) struct Counted {
    /// Variant and name of the row.
    key: (&'static str, String),
    /// Counts of its runs.
    counts: Counts,
    /// Command of the first run with a silent wrong lock.
    silent: Option<String>,
    /// Command of the first run with a false fault.
    false_faults: Option<String>,
}

/// Counts each kind and each case.
pub(super) fn count(quick: bool, set: &[TransducerRuns], wide: &[TransducerRuns], cases: &[CaseRuns]) -> Vec<Counted> {
    let variant = if quick { "quick" } else { "full" };
    let counted = |name: &str, runs: Vec<&RepeatableRun>| {
        let first = |is: fn(&Outcome) -> bool| runs.iter().find(|run| is(&run.judged.outcome)).map(|run| run.command.clone());
        Counted {
            key: (variant, name.to_owned()),
            counts: Counts::from_runs(runs.iter().map(|run| &run.judged)),
            silent: first(|outcome| *outcome == Outcome::Silent),
            false_faults: first(|outcome| matches!(outcome, Outcome::FalseFault(_))),
        }
    };
    fn of_kind<'a>(set: &'a [TransducerRuns], name: &str) -> Vec<&'a RepeatableRun> {
        set.iter().filter(|member| member.transducer.kind.name == name).map(|member| &member.observer).collect()
    }
    let kinds = KINDS.iter().map(|kind| counted(kind.name, of_kind(set, kind.name)));
    let wider = KINDS.iter().map(|kind| counted(&format!("wider: {}", kind.name), of_kind(wide, kind.name)));
    let phase_lock = counted("all, phase_lock", set.iter().filter_map(|member| member.phase_lock.as_ref()).collect());
    kinds
        .chain(wider)
        .chain([phase_lock])
        .chain(cases.iter().map(|case| counted(&case.name, case.runs.iter().collect())))
        .collect()
}

/// Lists each count that has become worse.
pub(super) fn compare(counted: &[Counted]) -> Vec<String> {
    counted.iter().flat_map(|row| worse(row, &recorded(BASELINE, &row.key))).collect()
}

/// Finds the counts of a row in a baseline: runs, locked, good, silent, false faults.
fn recorded(baseline: &str, (variant, what): &(&'static str, String)) -> Option<[usize; 5]> {
    let cells = baseline.lines().map(|line| line.split(';').collect::<Vec<_>>());
    let row = cells.into_iter().find(|cells| cells.len() == 7 && cells[0] == *variant && cells[1] == what)?;
    let numbers = [2, 3, 4, 5, 6].map(|place| row[place].parse().ok());
    match numbers {
        [Some(runs), Some(locked), Some(good), Some(silent), Some(false_faults)] => {
            Some([runs, locked, good, silent, false_faults])
        }
        _ => None,
    }
}

/// Lists the counts of a row that are worse than its baseline.
fn worse(row: &Counted, baseline: &Option<[usize; 5]>) -> Vec<String> {
    let (variant, what) = &row.key;
    let counts = &row.counts;
    let Some([runs, locked, good, silent, false_faults]) = *baseline else {
        return vec![format!(
            "{what} ({variant}): the baseline has no such row; write it with `UPDATE_DOCS=1 cargo test -p \
             sonoglide-evidence docs -- --include-ignored`"
        )];
    };
    if runs != counts.runs {
        return vec![format!(
            "{what} ({variant}): {} runs, but the baseline has {runs}; write it with `UPDATE_DOCS=1 cargo test -p \
             sonoglide-evidence docs -- --include-ignored`",
            counts.runs
        )];
    }
    let repeated =
        |command: &Option<String>| command.as_ref().map_or_else(String::new, |command| format!("; the first is `{command}`"));
    let mut worse = Vec::new();
    if counts.locked < locked {
        worse.push(format!("{what}: {} of {runs} runs lock within the bound, {locked} before", counts.locked));
    }
    if counts.locked + counts.good < good {
        worse.push(format!("{what}: {} of {runs} runs lock well, {good} before", counts.locked + counts.good));
    }
    if counts.silent > silent {
        worse.push(format!(
            "{what}: {} silent wrong locks in {runs} runs, {silent} before{}",
            counts.silent,
            repeated(&row.silent)
        ));
    }
    if counts.false_faults > false_faults {
        let first = repeated(&row.false_faults);
        worse.push(format!("{what}: {} of {runs} runs end in a false fault, {false_faults} before{first}", counts.false_faults));
    }
    worse
}

/// Formats the rows of the file.
pub(super) fn text(counted: &[Counted]) -> String {
    let mut text = format!("{HEADER}\n");
    for Counted { key: (variant, what), counts, .. } in counted {
        let Counts { runs, locked, good, silent, false_faults, .. } = counts;
        let _ = writeln!(text, "{variant};{what};{runs};{locked};{};{silent};{false_faults}", locked + good);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(locked: usize, silent: usize, false_faults: usize) -> Counted {
        let counts =
            Counts { runs: 12, locked, silent, false_faults, late: 12 - locked - silent - false_faults, ..Counts::default() };
        Counted { key: ("full", "ring".into()), counts, silent: Some("sim-host run a".into()), false_faults: None }
    }

    #[test]
    fn only_worse_counts_are_reported() {
        let text = text(&[row(8, 1, 2)]);
        let baseline = recorded(&text, &("full", "ring".to_owned()));
        assert_eq!(baseline, Some([12, 8, 8, 1, 2]));
        for same_or_better in [row(8, 1, 2), row(9, 1, 2), row(10, 0, 0)] {
            assert_eq!(worse(&same_or_better, &baseline), [""; 0]);
        }
        let fewer = ["ring: 7 of 12 runs lock within the bound, 8 before", "ring: 7 of 12 runs lock well, 8 before"];
        assert_eq!(worse(&row(7, 1, 2), &baseline), fewer);
        assert_eq!(
            worse(&row(8, 2, 2), &baseline),
            ["ring: 2 silent wrong locks in 12 runs, 1 before; the first is `sim-host run a`"]
        );
        assert_eq!(worse(&row(8, 1, 3), &baseline), ["ring: 3 of 12 runs end in a false fault, 2 before"]);
        assert!(worse(&row(8, 1, 2), &None)[0].contains("no such row"));
        assert!(worse(&row(8, 1, 2), &recorded("full;ring;24;8;8;1;2", &("full", "ring".into())))[0].contains("24"));
    }
}
