//! Valid suites, and the messages of invalid ones.

use super::*;

const TWO: &str = r#"
title = "Two loads"
scene = "lock-cold"
runs = 30
[quick]
runs = 3
cases = ["load"]
[[preset]]
name = "Q 65"
set = []
[[preset]]
name = "Q 200"
set = ["stack.bvd.q=200", "controller.tracking.nominal_q=200"]
[[case]]
name = "load"
group = "cold"
each = ["Q 65", "Q 200"]
[[case]]
name = "noise"
runs = 10
set = ["sensors.noise_lsb=2"]
[[target]]
metric = "lock_time_20hz_ms_p95"
groups = ["cold"]
max = 0.5
"#;

fn wrong(text: &str) -> String {
    load_text("two.toml", text, false).expect_err("it is wrong").to_string()
}

#[test]
fn each_preset_makes_a_case() {
    let loaded = load_text("two.toml", TWO, false).unwrap();
    let names: Vec<&str> = loaded.cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!((loaded.name.as_str(), names), ("two", vec!["load, Q 65", "load, Q 200", "noise"]));
    let runs: Vec<u32> = loaded.cases.iter().map(|case| case.loaded.scene.runs).collect();
    assert_eq!(runs, [30, 30, 10]);
    let [_, load, noise] = &loaded.cases[..] else { panic!("three") };
    assert_eq!(noise.command, "sim-host run lock-cold --set sensors.noise_lsb=2 --set runs=10");
    assert!(load.command.contains(" --set stack.bvd.q=200 --set controller.tracking.nominal_q=200"), "{}", load.command);
    let quick = load_text("two.toml", TWO, true).unwrap();
    assert_eq!(quick.cases.iter().map(|case| case.loaded.scene.runs).collect::<Vec<_>>(), [3, 3]);
}

#[test]
fn mistakes_are_reported_with_their_place() {
    for (from, to, parts) in [
        ("runs = 30", "rums = 30", vec!["two.toml:4:1", "unknown key `rums`", "did you mean `runs`?"]),
        ("max = 0.5", "maxx = 0.5", vec!["two.toml:25:1", "unknown key `maxx` in [[target]]", "did you mean `max`?"]),
        ("[\"Q 65\", \"Q 200\"]", "[\"Q 65\", \"Q 20O\"]", vec!["two.toml:17:17", "no preset `Q 20O`", "did you mean `Q 200`?"]),
        ("groups = [\"cold\"]", "groups = [\"colt\"]", vec!["no group `colt`", "did you mean `cold`?"]),
        ("20hz_ms_p95", "20hz_p95", vec!["two.toml:23:10", "no metric", "did you mean `lock_time_20hz_ms`?"]),
        ("max = 0.5", "max = 0.5\nvalue = 0.1", vec!["no limit, or more than one"]),
        ("noise_lsb=2", "noise_lbs=2", vec!["two.toml:21:17", "in the case `noise`", "did you mean `noise_lsb`?"]),
        ("nominal_q=200", "nominal_q=-1", vec!["two.toml:13:58", "in the case `load, Q 200`", "out of range"]),
        ("lock-cold", "lock-colt", vec!["two.toml:3:9", "no scene `lock-colt`", "`lock-cold`"]),
        ("name = \"noise\"", "name = \"load\"", vec!["appears twice"]),
    ] {
        let said = wrong(&TWO.replace(from, to));
        for part in parts {
            assert!(said.contains(part), "`{part}` is missing for {to}:\n{said}");
        }
    }
}

#[test]
fn mistakes_of_suite_and_cases_are_shown_together() {
    let text =
        TWO.replace("max = 0.5", "maxx = 0.5").replace("noise_lsb=2", "noise_lbs=2").replace("title = \"Two loads\"\n", "");
    let shown = wrong(&text);
    for part in ["unknown key `maxx`", "`title` is missing", "in the case `noise`", "3 problems"] {
        assert!(shown.contains(part), "`{part}` is missing:\n{shown}");
    }
}

#[test]
fn a_mistake_in_a_case_does_not_hide_another() {
    let shown = wrong(&TWO.replace("group = \"cold\"", "colour = \"cold\"").replace("noise_lsb=2", "noise_lbs=2"));
    assert!(shown.contains("unknown key `colour`") && shown.contains("in the case `noise`"), "{shown}");
}
