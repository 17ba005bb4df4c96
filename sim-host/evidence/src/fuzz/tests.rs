//! The quick variant: nothing fails, and every target comes as deep as it is meant to.

use super::*;

/// Outcomes that each target must reach: what a generator that only breaks things would not come to.
const REACHED: [(&str, &[&str]); 7] = [
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
        &["Nothing", "Stored", "Damaged", "Version(3)", "stored over it", "started, Some(Refused)", "started, Some(Partly)"],
    ),
    ("scenes", &["a scene", "unknown key * at the top level", "* is out of range"]),
    ("suites", &["a suite"]),
    ("scripts", &["a script", "an expectation that holds", "this quote is not closed"]),
    ("updates", &["packed", "a manifest", "Damaged"]),
];

#[test]
fn quick_fuzzing_finds_nothing_and_reaches_what_it_is_for() {
    let mut wrong = Vec::new();
    for (target, (name, reached)) in TARGETS.iter().zip(REACHED) {
        let (seen, failures) = target.run(0..target.seeds(MILLIONS[1]), None).unwrap();
        println!("{name}: {} inputs, {} bytes, {:#?}", seen.inputs, seen.bytes, seen.outcomes);
        assert_eq!(target.name, name);
        wrong.extend(failures);
        let missing: Vec<_> = reached.iter().filter(|kind| !seen.outcomes.contains_key(**kind)).collect();
        if !missing.is_empty() {
            wrong.push(format!("{name} has not reached {missing:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
