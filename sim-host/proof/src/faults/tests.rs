//! The quick variant: what is promised of what the hardware reports, and no more undetected than there were.

use super::*;

/// Runs of the quick variant that are dangerous in the end without a word.
const UNDETECTED: usize = 8;

#[test]
fn nothing_becomes_worse() {
    let places: Vec<Running> = PLACES.par_iter().map(|place| place.pilot().unwrap()).collect();
    let mut undetected = Vec::new();
    for kind in &KINDS {
        let runs = runs(&places, Some(kind), RUNS[1]).unwrap();
        undetected.extend(runs.iter().filter(|run| run.verdict.is_undetected()).map(|run| (kind.name, run.place.name, run.seed)));
        // What the hardware reports, or the host, is off with the next block, whatever is driven.
        for run in runs.iter().filter(|_| matches!(kind.named, [10] | [12] | [21] | [13, 14])) {
            let verdict = &run.verdict;
            assert!(kind.named.contains(&verdict.said), "{}, {}, {}: {verdict:?}", kind.name, run.place.name, run.seed);
            assert!(verdict.off_ms <= kind.off_ms, "{}, {}, {}: {verdict:?}", kind.name, run.place.name, run.seed);
        }
    }
    assert!(undetected.len() <= UNDETECTED, "{undetected:?}");
}

#[test]
fn without_a_failure_nothing_is_said() {
    let places: Vec<Running> = PLACES.par_iter().map(|place| place.pilot().unwrap()).collect();
    for run in runs(&places, None, CALM[1]).unwrap() {
        assert_eq!((run.verdict.said, run.verdict.dangerous_ms), (0, 0.0), "{}, {}", run.place.name, run.seed);
    }
}
