use std::io::Write as _;

use super::limits::Verdict;
use super::*;

/// Runs of each kind here; the campaign's first ones.
const FEW: u32 = 3;
/// What the image does not withstand: `docs/evidence/board-faults.md`, "What fails".
const KNOWN: [&str; 6] = ["adc-trigger-lost", "code-two-bits", "static-memory-bit", "stack-bit", "fast-code-bit", "register-bit"];

#[test]
fn few_runs_of_each_kind_hold_but_for_what_is_known() {
    if let Some(missing) = pil::missing_to_build() {
        let _ = writeln!(std::io::stderr(), "SKIPPED, faults of the board: {missing}");
        return;
    }
    let elf = std::fs::read(pil::board_image().unwrap()).unwrap();
    for tried in campaign(&elf, KINDS, FEW, SEED, &mut |_| ()).unwrap() {
        let failed: Vec<_> = tried.outcomes.iter().filter(|outcome| outcome.failed.is_some()).collect();
        assert!(failed.is_empty() || KNOWN.contains(&tried.kind.name), "{}: {failed:#?}", tried.kind.name);
        let must_be_off = matches!(tried.kind.verdict, Verdict::Off(_)) && failed.is_empty();
        assert!(!must_be_off || tried.outcomes.iter().all(|outcome| outcome.off_s.is_some()), "{}", tried.kind.name);
    }
}

#[test]
fn every_kind_has_a_name_of_its_own() {
    for kind in KINDS {
        assert_eq!(KINDS.iter().filter(|other| other.name == kind.name).count(), 1, "{}", kind.name);
    }
}
