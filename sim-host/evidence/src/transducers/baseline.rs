//! The baseline: what was counted when it was written, and nothing may be worse.
//!
//! `baseline.csv` has a row for each kind of the random set, for all of it by the phase loop, and for each case, of the quick and of the full variant. A row is worse than its baseline if fewer runs lock,
//! more lock silently outside the bound, or more end in a fault that does not hold. `UPDATE_DOCS=1 cargo test -p sonoglide-evidence docs -- --include-ignored` writes it, with the tables.

use std::fmt::Write;

use super::draw::KINDS;
use super::summary::Counts;
use super::{Tried, TriedCase, TriedTransducer};
use crate::transducers::outcome::Outcome;

/// Name of the file.
pub(super) const FILE: &str = "baseline.csv";
const BASELINE: &str = include_str!("baseline.csv");
const HEADER: &str = "variant;what;runs;locked;silent;accused";

/// What is counted of one row, and a run that is worse than a lock.
#[derive(Clone, Debug)]
pub(super) struct Counted {
    /// Variant and name of the row.
    key: (&'static str, String),
    /// What is counted of its runs.
    counts: Counts,
    /// Command of the first run that is silently wrong, and of the first that is accused.
    silent: Option<String>,
    accused: Option<String>,
}

/// Counts each kind and each case.
pub(super) fn count(quick: bool, set: &[TriedTransducer], cases: &[TriedCase]) -> Vec<Counted> {
    let variant = if quick { "quick" } else { "full" };
    let counted = |name: &str, runs: Vec<&Tried>| {
        let first = |is: fn(&Outcome) -> bool| runs.iter().find(|run| is(&run.judged.outcome)).map(|run| run.command.clone());
        Counted {
            key: (variant, name.to_owned()),
            counts: Counts::of(runs.iter().map(|run| &run.judged)),
            silent: first(|outcome| *outcome == Outcome::Silent),
            accused: first(|outcome| matches!(outcome, Outcome::Accused(_))),
        }
    };
    let of_kind = |name: &str| set.iter().filter(|tried| tried.transducer.kind.name == name).map(|tried| &tried.tried).collect();
    let kinds = KINDS.iter().map(|kind| counted(kind.name, of_kind(kind.name)));
    let phase_lock = counted("all, phase_lock", set.iter().map(|tried| &tried.phase_lock).collect());
    kinds.chain([phase_lock]).chain(cases.iter().map(|case| counted(&case.name, case.runs.iter().collect()))).collect()
}

/// What has become worse, a line each.
pub(super) fn compare(counted: &[Counted]) -> Vec<String> {
    counted.iter().flat_map(|row| worse(row, &recorded(BASELINE, &row.key))).collect()
}

/// The counts that a baseline has of a row: runs, locked, silent, accused.
fn recorded(baseline: &str, (variant, what): &(&'static str, String)) -> Option<[usize; 4]> {
    let cells = baseline.lines().map(|line| line.split(';').collect::<Vec<_>>());
    let row = cells.into_iter().find(|cells| cells.len() == 6 && cells[0] == *variant && cells[1] == what)?;
    let numbers = [2, 3, 4, 5].map(|place| row[place].parse().ok());
    match numbers {
        [Some(runs), Some(locked), Some(silent), Some(accused)] => Some([runs, locked, silent, accused]),
        _ => None,
    }
}

/// In what a row is worse than its baseline.
fn worse(row: &Counted, baseline: &Option<[usize; 4]>) -> Vec<String> {
    let (variant, what) = &row.key;
    let counts = &row.counts;
    let Some([runs, locked, silent, accused]) = *baseline else {
        return vec![format!(
            "{what} ({variant}): the baseline has no such row; `UPDATE_DOCS=1 cargo test -p sonoglide-evidence docs -- --include-ignored` writes it"
        )];
    };
    if runs != counts.runs {
        return vec![format!(
            "{what} ({variant}): {} runs, where the baseline has {runs}; `UPDATE_DOCS=1 cargo test -p sonoglide-evidence docs -- --include-ignored`",
            counts.runs
        )];
    }
    let repeated =
        |command: &Option<String>| command.as_ref().map_or_else(String::new, |command| format!("; the first is `{command}`"));
    let mut worse = Vec::new();
    if counts.locked < locked {
        worse.push(format!("{what}: {} of {runs} runs lock within the bound, {locked} before", counts.locked));
    }
    if counts.silent > silent {
        worse.push(format!(
            "{what}: {} silent wrong locks in {runs} runs, {silent} before{}",
            counts.silent,
            repeated(&row.silent)
        ));
    }
    if counts.accused > accused {
        let first = repeated(&row.accused);
        worse.push(format!("{what}: {} of {runs} healthy transducers accused, {accused} before{first}", counts.accused));
    }
    worse
}

/// The rows as the file has them.
pub(super) fn text(counted: &[Counted]) -> String {
    let mut text = format!("{HEADER}\n");
    for Counted { key: (variant, what), counts, .. } in counted {
        let Counts { runs, locked, silent, accused, .. } = counts;
        let _ = writeln!(text, "{variant};{what};{runs};{locked};{silent};{accused}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(locked: usize, silent: usize, accused: usize) -> Counted {
        let counts = Counts { runs: 12, locked, silent, accused, late: 12 - locked - silent - accused, ..Counts::default() };
        Counted { key: ("full", "ring".into()), counts, silent: Some("sim-host run a".into()), accused: None }
    }

    #[test]
    fn only_what_is_worse_is_said_with_its_command() {
        let text = text(&[row(8, 1, 2)]);
        let baseline = recorded(&text, &("full", "ring".to_owned()));
        assert_eq!(baseline, Some([12, 8, 1, 2]));
        for same_or_better in [row(8, 1, 2), row(9, 1, 2), row(10, 0, 0)] {
            assert_eq!(worse(&same_or_better, &baseline), [""; 0]);
        }
        assert_eq!(worse(&row(7, 1, 2), &baseline), ["ring: 7 of 12 runs lock within the bound, 8 before"]);
        assert_eq!(
            worse(&row(8, 2, 2), &baseline),
            ["ring: 2 silent wrong locks in 12 runs, 1 before; the first is `sim-host run a`"]
        );
        assert_eq!(worse(&row(8, 1, 3), &baseline), ["ring: 3 of 12 healthy transducers accused, 2 before"]);
        assert!(worse(&row(8, 1, 2), &None)[0].contains("no such row"));
        assert!(worse(&row(8, 1, 2), &recorded("full;ring;24;8;1;2", &("full", "ring".into())))[0].contains("24"));
    }
}
