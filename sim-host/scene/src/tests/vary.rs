//! Several runs and `[[vary]]`, and messages about mistakes in them.

use super::{example, load_text, loaded, report, says, sets};

/// Returns the report on the example with appended text.
fn with(text: &str) -> String {
    report(&format!("{}\n{text}", example()), &[])
}

fn vary(key: &str, how: &str) -> String {
    with(&format!("[[vary]]\nkey = \"{key}\"\n{how}\n"))
}

#[test]
fn unknown_varied_keys_have_a_nearest_name() {
    says(
        &vary("stack.bvd.serie_resonance_hz", "spread = 0.02"),
        &[
            "`stack.bvd.serie_resonance_hz` is not a number of a scene",
            "did you mean `stack.bvd.series_resonance_hz`?",
            "key = \"stack.bvd.serie_resonance_hz\"",
            "^^^",
            "\n1 problem in a.toml",
        ],
    );
    says(&vary("controller.drive.shape", "spread = 0.1"), &["`controller.drive.shape` is not a number of a scene"]);
}

#[test]
fn varying_an_absent_optional_key_is_refused() {
    says(
        &vary("controller.tracking.nominal_lm_h", "spread = 0.1"),
        &["`controller.tracking.nominal_lm_h` is varied, but the scene does not have it", "give it a value first", "1 problem"],
    );
    // A key with a default may be absent.
    let text = format!("{}\n[[vary]]\nkey = \"sensors.noise_lsb\"\nfactor = 2\n", example());
    assert!(load_text("a.toml", &text, &[]).is_ok());
}

#[test]
fn variation_needs_one_valid_range() {
    says(&vary("contact.dahl.mu", "spread = 0.1\nfactor = 2"), &["vary", "exclude each other", "1 problem"]);
    says(&vary("contact.dahl.mu", ""), &["[[vary]] is incomplete", "give either `spread`, or `factor`, or `from` and `to`"]);
    says(
        &vary("contact.dahl.mu", "from = 0.3\nto = 0.2"),
        &["the range from 0.3 to 0.2 is empty", "`to` must be more than `from`"],
    );
    says(&vary("contact.dahl.mu", "factor = 0.5"), &["`vary.0.factor` is out of range", "must be from 1 to 1000"]);
    let twice = "[[vary]]\nkey = \"contact.dahl.mu\"\nspread = 0.1\n".repeat(2);
    says(&with(&twice), &["`contact.dahl.mu` is varied twice"]);
    says(&vary("seed", "from = 1\nto = 5"), &["`seed` cannot be varied"]);
    says(&vary("runs", "from = 1\nto = 5"), &["`runs` cannot be varied"]);
    says(&vary("sensors.skew_s", "spread = 0.1"), &["`sensors.skew_s` would not vary", "give `from` and `to` instead"]);
}

/// An end of a variation is refused if it is out of range or breaks a rule.
#[test]
fn both_ends_must_be_scenes() {
    says(
        &vary("contact.dahl.mu", "from = 0.1\nto = 7"),
        &["`contact.dahl.mu` varied to 7: `contact.dahl.mu` is out of range", "a.toml"],
    );
    says(
        &vary("controller.drive.scan_v", "factor = 100"),
        &["`controller.drive.scan_v` varied to 300: `controller.drive.scan_v` is 300 V, more than"],
    );
}

#[test]
fn several_runs_exclude_a_comparison() {
    let compared =
        ["runs=2", "comparison.metrics=[\"friction_on_n\"]", "comparison.match=[\"peak\"]", "comparison.case.0.name=a"];
    says(&report(example(), &compared), &["a scene with several `runs` cannot have a [comparison]", "must be 1"]);
    assert!(load_text("a.toml", example(), &["runs=2".to_owned()]).is_ok(), "a grid of several runs");
    says(&report(example(), &["runs=0"]), &["`runs` is out of range", "must be from 1 to 100000"]);
}

#[test]
fn set_variation_replaces_the_scenes_variation() {
    let changes = ["vary.0.key=contact.dahl.mu", "vary.0.spread=0.1", "vary.0.from=0.1", "vary.0.to=0.2"];
    says(&report(example(), &changes), &["exclude each other"]);
    let text = format!("{}\n[[vary]]\nkey = \"contact.dahl.mu\"\nspread = 0.1\n", example());
    let scene = load_text("a.toml", &text, &sets(&["vary.0.from=0.1", "vary.0.to=0.2"])).unwrap().scene;
    assert_eq!((scene.vary[0].spread, scene.vary[0].from), (None, Some(0.1)));
    assert_eq!(loaded(&[]).runs, 1);
}

/// Expectations can use percentiles over several runs.
#[test]
fn percentiles_are_metrics() {
    let expect = |metric: &str| format!("{}\n[[expect]]\nmetric = \"{metric}\"\nmax = 1\n", example());
    assert!(load_text("a.toml", &expect("lock_time_20hz_ms_p95"), &[]).is_ok());
    says(&report(&expect("lock_time_20hz_ms_p96"), &[]), &["there is no metric", "did you mean `lock_time_20hz_ms`?", "`_p95`"]);
}

/// A value is refused if each run draws a new one: on an axis of a grid, in `grid.set`, by `--set`,
/// and over a base.
#[test]
fn values_replaced_by_vary_are_refused() {
    let mu = "contact.dahl.mu";
    let text = format!("{}\n[[vary]]\nkey = \"{mu}\"\nfrom = 0.1\nto = 0.2\n", example());
    let with = |sets_: &[&str]| load_text("a.toml", &text, &sets(sets_)).map(drop).map_err(|error| error.to_string());
    let axis = ["runs=2", "grid.over.1.key=contact.dahl.mu", "grid.over.1.values=[0.05, 0.5]"];
    let refused = [&axis[..], &["runs=2", "grid.set=[\"contact.dahl.mu=0.3\"]"], &["runs=2", "contact.dahl.mu=0.3"]];
    for sets in refused {
        let report = with(sets).expect_err("a value without effect");
        let drawn = format!("`{mu}` is drawn in each run, by its distribution or [[vary]]");
        says(&report, &[&drawn, "--> --set:", "^ other values have no effect", "`vary = []`", "`spread`", "1 problem"]);
    }
    let samples = ["runs=2", "vary.0.samples=[0.1, 0.2]", axis[1], axis[2]];
    says(&with(&samples).expect_err("a value without effect"), &["is drawn in each run"]);
    let about = ["runs=2", "vary.0.spread=0.1", "contact.dahl.mu=0.3"];
    let apart = ["runs=2", "grid.set=[\"runs=1\"]", axis[1], axis[2]];
    // The newer entry draws about the newer value.
    let newer = ["runs=2", "contact.dahl.mu=0.3", "vary.0.from=0.2", "vary.0.to=0.4"];
    assert_eq!(with(&newer), Ok(()));
    for sets in [&["runs=2"][..], &["contact.dahl.mu=0.3"], &axis[1..], &about, &apart] {
        assert_eq!(with(sets), Ok(()), "{sets:?}");
    }
}
