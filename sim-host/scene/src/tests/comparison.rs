//! Invalid comparisons, and their messages.

use super::{example, loaded, report, says};
use crate::Equal;
use crate::load::load_text;

/// Returns the example with an amplitude instead of a velocity, and a comparison.
fn compared(lines: &[(&str, &str)]) -> String {
    let driven = example().replacen("velocity_m_per_s = 0.175", "amplitude_v = 3.0", 1);
    let comparison = "
[comparison]
title = \"Shapes\"
metrics = [\"friction_ratio\", \"drive_rms_v\"]
amplitude_key = \"controller.drive.amplitude_v\"
match = [\"peak\", \"rms\", \"power\"]
set = [\"duration_s=0.7\", \"controller.burst.on_s=[0.4]\", \"controller.burst.off_s=[0.6]\"]

[[comparison.case]]
name = \"sine\"

[[comparison.case]]
name = \"square\"
set = [\"controller.drive.shape=square\"]

[[expect]]
metric = \"friction_ratio\"
case = \"square\"
match = \"rms\"
max = 0.5
";
    let text = format!("{driven}{comparison}");
    lines.iter().fold(text, |text, (old, new)| {
        assert!(text.contains(old), "no `{old}`");
        text.replacen(old, new, 1)
    })
}

/// Returns the report on the comparison with some of its text replaced.
fn wrong(lines: &[(&str, &str)]) -> String {
    report(&compared(lines), &[])
}

#[test]
fn a_comparison_is_read() {
    let scene = load_text("a.toml", &compared(&[]), &[]).unwrap_or_else(|error| panic!("{error}")).scene;
    let comparison = scene.comparison.unwrap();
    assert_eq!(comparison.matched, [Equal::Peak, Equal::Rms, Equal::Power]);
    assert_eq!(comparison.case[1].set, ["controller.drive.shape=square"]);
    let expect = scene.expect.last().unwrap();
    assert_eq!((expect.case.as_deref(), expect.matched), (Some("square"), Some(Equal::Rms)));
    assert!(loaded(&[]).comparison.is_none());
}

#[test]
fn comparison_keys_and_metrics_must_exist() {
    says(
        &wrong(&[("amplitude_key = \"controller.drive.amplitude_v\"", "amplitude_key = \"controller.drive.amplitude\"")]),
        &["is not a number of a scene", "did you mean `controller.drive.amplitude_v`?", "a.toml:54:17"],
    );
    says(
        &wrong(&[("amplitude_key = \"controller.drive.amplitude_v\"", "amplitude_key = \"rig.slider.load_n\"")]),
        &["is not the peak of the firmware's drive", "must be `controller.drive.amplitude_v`"],
    );
    says(
        &wrong(&[("amplitude_v = 3.0", "velocity_m_per_s = 0.175")]),
        &["`controller.drive.amplitude_v` is not given in this scene", "1 problem"],
    );
    says(&wrong(&[("\"drive_rms_v\"]", "\"drive_rms\"]")]), &["there is no metric `drive_rms`", "did you mean `drive_rms_v`?"]);
    says(&wrong(&[("match = [\"peak\", \"rms\"", "match = [\"peak\", \"peak\"")]), &["appears twice", "a.toml:55:18"]);
    says(&wrong(&[("match = [\"peak\", \"rms\"", "match = [\"peak\", \"rsm\"")]), &["did you mean `rms`?"]);
}

#[test]
fn cases_need_unique_names_and_valid_scenes() {
    says(
        &wrong(&[("name = \"sine\"", "name = \"square\"")]),
        &["\"square\" appears twice", "is the name of another case", "a.toml:62:8"],
    );
    says(&wrong(&[("name = \"sine\"", "name = \" \"")]), &["a case without a name"]);
    says(
        &wrong(&[("\"controller.drive.shape=square\"", "\"controller.drive.amplitude_v = 2\"")]),
        &["a case cannot set `controller.drive.amplitude_v`", "a.toml:63:8"],
    );
    says(
        &wrong(&[("\"controller.drive.shape=square\"", "\"controller.drive.shape=sqare\"")]),
        &["in the case `square`: `controller.drive.shape` cannot be \"sqare\"", "did you mean `square`?", "a.toml:63:8"],
    );
    says(
        &wrong(&[("\"controller.drive.shape=square\"", "\"duration_s=0.3\"")]),
        &["in the case `square`: `controller.burst.on_s.0` is 0.4 s, but the run ends at 0.3 s", "--> a.toml:56:"],
    );
    says(&wrong(&[("name = \"sine\"", "name = \"sine\"\npicture = true")]), &["a picture without a sweep", "a.toml:60:11"]);
    says(
        &wrong(&[("[[comparison.case]]\nname = \"square\"\nset = [\"controller.drive.shape=square\"]\n", "")]),
        &["`comparison.case` has 1 entry", "needs at least 2"],
    );
}

#[test]
fn expectations_need_an_existing_case() {
    says(&wrong(&[("case = \"square\"", "case = \"sqare\"")]), &["the comparison has no case `sqare`", "did you mean `square`?"]);
    says(&wrong(&[("match = \"rms\"", "")]), &["`case` needs `match` as well"]);
    says(&wrong(&[("case = \"square\"", "")]), &["`match` needs `case` as well"]);
    says(
        &wrong(&[("match = [\"peak\", \"rms\", \"power\"]", "match = [\"peak\"]")]),
        &["the comparison does not match by `rms`"],
    );
    let alone = ["expect.0.case=square", "expect.0.match=rms"];
    says(&report(example(), &alone), &["the comparison has no case `square`", "there is no [comparison]", "--set:1:15"]);
}

#[test]
fn contact_studies_match_only_by_peak() {
    let study = include_str!("excited.toml");
    let comparison = "
[comparison]
title = \"Forces\"
metrics = [\"friction_ratio\"]
amplitude_key = \"excitation.force_n\"
match = [\"peak\"]
[[comparison.case]]
name = \"sine\"
[[comparison.case]]
name = \"square\"
set = [\"excitation.waveform=square\"]
";
    let text = format!("{study}{comparison}");
    assert!(load_text("a.toml", &text, &[]).is_ok(), "{}", report(&text, &[]));
    says(
        &report(&text.replace("[\"peak\"]", "[\"power\"]"), &[]),
        &["a contact study cannot be compared at equal power", "must be \"peak\""],
    );
}

#[test]
fn equal_reduction_needs_a_slider() {
    let comparison = "[comparison]
title = \"Bursts\"
metrics = [\"mean_power_w\"]
amplitude_key = \"controller.drive.amplitude_v\"
match = [\"reduction\"]
[[comparison.case]]
name = \"continuous\"
[[comparison.case]]
name = \"bursts\"
set = [\"controller.burst.period_s=0.01\", \"controller.burst.duty=0.5\"]
";
    let over = |base: &str| format!("base = \"{base}\"\nexpect = []\ngrid = false\n{comparison}");
    says(&report(&over("burst"), &[]), &["without a slider, the cases have no reduction", "nothing slides"]);
    assert!(load_text("a.toml", &over("least-power"), &[]).is_ok(), "{}", report(&over("least-power"), &[]));
}
