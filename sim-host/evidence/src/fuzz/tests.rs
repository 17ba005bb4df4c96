//! The quick variant: nothing fails, and every target reaches the depth that it is meant to.

use super::*;

/// Outcomes that each target must reach; input that is only damaged would not reach them.
const REACHED: [(&str, &[&str]); 8] = [
    (
        "link",
        &[
            "mode Run",
            "mode Calibrate",
            "refused: Damaged",
            "refused: Version",
            "refused: Unknown",
            "refused: Session",
            "refused: Busy",
            "refused: Driving",
            "Captured",
            "Parameter",
        ],
    ),
    ("replies", &["a frame", "too long", "damaged", "unknown"]),
    (
        "settings",
        &["Nothing", "Stored", "Damaged", "Version(3)", "overwritten", "started, Some(Refused)", "started, Some(Partly)"],
    ),
    ("scenes", &["a scene", "unknown key * at the top level", "* is out of range"]),
    ("suites", &["a suite"]),
    ("scripts", &["a script", "an expectation that holds", "this quote is not closed"]),
    ("updates", &["packed", "a manifest", "Damaged"]),
    ("tables", &["admittance", "log", "signal", "converted"]),
];

#[test]
fn quick_fuzzing_finds_nothing_and_reaches_all_outcomes() {
    let mut wrong = Vec::new();
    for (target, (name, reached)) in TARGETS.iter().zip(REACHED) {
        let (tally, failures) = target.run(0..target.seeds(MILLIONS[1]), None).unwrap();
        println!("{name}: {} inputs, {} bytes, {:#?}", tally.inputs, tally.bytes, tally.outcomes);
        assert_eq!(target.name, name);
        wrong.extend(failures);
        let missing: Vec<_> = reached.iter().filter(|kind| !tally.outcomes.contains_key(**kind)).collect();
        if !missing.is_empty() {
            wrong.push(format!("{name} does not reach {missing:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
