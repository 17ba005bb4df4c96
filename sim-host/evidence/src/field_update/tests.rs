use std::io::Write as _;

use super::*;

#[test]
fn a_few_cuts_of_each_phase_leave_a_board_that_starts() {
    if let Some(missing) = pil::missing_to_build() {
        let _ = writeln!(std::io::stderr(), "SKIPPED, power cuts during an update: {missing}");
        return;
    }
    // Marking has its own test with a small update (`image-scenarios`); a whole one takes half a
    // minute here.
    let phases = [Phase::Receiving, Phase::Installing, Phase::Confirming, Phase::Returning];
    let tried = campaign(&FieldImages::built().unwrap(), &phases, QUICK_CUTS, &mut |_| ()).unwrap();
    for PhaseRuns { phase, operations, outcomes } in &tried {
        let expected = match phase {
            Phase::Receiving => 17,
            Phase::Marking | Phase::Confirming => 4,
            Phase::Installing | Phase::Returning => 50_000,
        };
        assert!(*operations >= expected, "{phase:?}: {operations}");
        assert!(outcomes.iter().all(Result::is_ok), "{phase:?}: {outcomes:?}");
    }
    let answered = |version| tried.iter().flat_map(|tried| &tried.outcomes).any(|outcome| *outcome == Ok(version));
    assert!(answered(1) && answered(2));
}
