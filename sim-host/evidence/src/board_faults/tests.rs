use std::io::Write as _;

use super::limits::Verdict;
use super::*;

/// Number of runs of each kind here; the first ones of the campaign.
const FEW_RUNS: u32 = 3;
/// Kinds that the image does not withstand: `docs/evidence/board-faults.md`, "What fails".
const FAILING_KINDS: [&str; 5] = ["code-two-bits", "static-memory-bit", "stack-bit", "fast-code-bit", "register-bit"];

#[test]
fn few_runs_of_each_kind_hold_but_for_what_is_known() {
    if let Some(missing) = pil::missing_to_build() {
        let _ = writeln!(std::io::stderr(), "SKIPPED, faults of the board: {missing}");
        return;
    }
    let elf = std::fs::read(pil::board_image().unwrap()).unwrap();
    for tried in campaign(&elf, KINDS, FEW_RUNS, SEED, &mut |_| ()).unwrap() {
        let failed: Vec<_> = tried.runs.iter().filter(|outcome| outcome.failed.is_some()).collect();
        assert!(failed.is_empty() || FAILING_KINDS.contains(&tried.kind.name), "{}: {failed:#?}", tried.kind.name);
        let must_be_off = matches!(tried.kind.verdict, Verdict::Off(_)) && failed.is_empty();
        assert!(!must_be_off || tried.runs.iter().all(|outcome| outcome.off_s.is_some()), "{}", tried.kind.name);
    }
}

#[test]
fn kind_names_are_unique() {
    for kind in KINDS {
        assert_eq!(KINDS.iter().filter(|other| other.name == kind.name).count(), 1, "{}", kind.name);
    }
}
