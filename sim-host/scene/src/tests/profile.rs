//! Measured profiles: reading from files, and messages about unusable ones.

use std::fs;
use std::path::{Path, PathBuf};

use super::{example, says, sets};
use crate::Scene;
use crate::load::{LoadError, load_text};

/// Creates a folder for one test.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("sonoglide-profile-{}-{name}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Returns the example without the speeds of its grid.
fn example_of_one_speed() -> String {
    let speeds = "    { key = \"rig.slider.speed_m_per_s\", values = [0.038, 0.068] },\n";
    assert!(example().contains(speeds));
    example().replace(speeds, "")
}

/// Returns the example without its grid.
fn plain() -> String {
    let (before, rest) = example().split_once("[grid]").unwrap();
    let (_, after) = rest.split_once("[[expect]]").unwrap();
    format!("{before}[[expect]]{after}")
}

/// Loads the example with a disturbance that follows `speed.csv` with this text, in its own folder.
fn with(name: &str, csv: &str, more: &str) -> Result<Scene, LoadError> {
    let folder = folder(name);
    fs::write(folder.join("speed.csv"), csv).unwrap();
    let course = "[[disturbance]]\nat_s = 0\nkey = \"rig.slider.speed_m_per_s\"\nprofile.file = \"speed.csv\"\n";
    let text = format!("{}\n{course}{more}", example_of_one_speed());
    let loaded = load_text(&folder.join("a.toml").to_string_lossy(), &text, &[]).map(|loaded| loaded.scene);
    fs::remove_dir_all(folder).unwrap();
    loaded
}

fn refused(name: &str, csv: &str, more: &str) -> String {
    with(name, csv, more).expect_err("something is wrong").to_string()
}

const LONG: &str = "t [ms],v [mm/s],load [N]\n0,38,1\n2000,40,2\n9000,30,3\n";

#[test]
fn a_column_is_read_in_the_unit_of_its_key() {
    let scene = with("read", LONG, "profile.column = \"v\"\n").unwrap_or_else(|error| panic!("{error}"));
    let profile = scene.disturbance[0].profile.clone().unwrap();
    assert_eq!((&*profile.time_s, &*profile.values), (&[0.0, 2.0, 9.0][..], &[0.038, 0.04, 0.03][..]));
    assert_eq!((profile.at(1.0), profile.file.clone()), (0.039, None));
    assert_eq!(profile.source, "speed.csv: v [mm/s] over t [ms], 3 samples");
}

#[test]
fn a_path_is_converted_to_speed() {
    let csv = "time_s;payout [mm]\n0;0\n1;38\n3;152\n9;152\n";
    let profile = with("payout", csv, "").unwrap_or_else(|error| panic!("{error}")).disturbance[0].profile.clone().unwrap();
    let near = |time: f64, speed: f64| assert!((profile.at(time) - speed).abs() < 1e-12, "{time}: {}", profile.at(time));
    [(0.0, 0.038), (0.5, 0.038), (2.0, 0.057), (6.0, 0.0), (9.0, 0.0)].into_iter().for_each(|(time, speed)| near(time, speed));
}

#[test]
fn a_scene_with_samples_needs_no_file() {
    let scene = with("again", LONG, "profile.column = \"2\"\n").unwrap_or_else(|error| panic!("{error}"));
    let text = crate::resolved::resolved_toml(&scene);
    let again = load_text("elsewhere.toml", &text, &[]).unwrap_or_else(|error| panic!("{error}\n{text}")).scene;
    assert_eq!(again, scene);
}

#[test]
fn profile_paths_are_relative_to_their_text() {
    let folder = folder("profile");
    fs::create_dir_all(folder.join("rig")).unwrap();
    fs::write(
        folder.join("rig/base.toml"),
        format!("{}\n[[disturbance]]\nat_s = 0\nkey = \"rig.slider.load_n\"\nprofile.file = \"load.csv\"\n", plain()),
    )
    .unwrap();
    fs::write(folder.join("rig/load.csv"), "t [s],F [N]\n0,1\n9,2\n").unwrap();
    let read = load_text(&folder.join("a.toml").to_string_lossy(), "base = \"rig/base.toml\"", &[]);
    fs::remove_dir_all(&folder).unwrap();
    assert!(
        (read.unwrap_or_else(|error| panic!("{error}")).scene.disturbance[0].profile.as_ref().unwrap().at(4.5) - 1.5).abs()
            < 1e-12
    );
}

/// A template, a cell of a grid and a sweep can change the beginning of a profile without reading
/// the file again.
#[test]
fn profile_start_can_be_set_like_a_number() {
    let folder = folder("template");
    fs::write(folder.join("speed.csv"), LONG).unwrap();
    let text = format!(
        "{}\n[[disturbance]]\nat_s = 0\nkey = \"rig.slider.speed_m_per_s\"\nprofile = \
         {{ file = \"speed.csv\", column = \"v\" }}\n",
        example_of_one_speed()
    );
    let loaded = load_text(&folder.join("a.toml").to_string_lossy(), &text, &[]).unwrap_or_else(|error| panic!("{error}"));
    let template = loaded.template().unwrap_or_else(|error| panic!("{error}"));
    let begins = |set: &str| template.scene(&sets(&[set])).map(|scene| scene.disturbance[0].profile.as_ref().unwrap().at(0.0));
    assert_eq!(begins("disturbance.0.profile.from_s=1").unwrap(), 0.039);
    says(&begins("disturbance.0.profile.from_s=8").unwrap_err().to_string(), &["too short for the run", "--set:1:30"]);
    fs::write(folder.join("other.csv"), "t [s],v [m/s]\n0,0.05\n9,0.05\n").unwrap();
    let other = format!("disturbance.0.profile={{file = {:?}, column = \"v\"}}", folder.join("other.csv").display().to_string());
    assert_eq!(begins(&other).unwrap(), 0.05);
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn unreadable_profiles_are_reported_with_their_place() {
    let v = "profile.column = \"v\"\n";
    says(&refused("which", LONG, ""), &["has 2 columns other than `t [ms]`", "a.toml:", "`v [mm/s]` or `load [N]`"]);
    says(
        &refused("name", LONG, "profile.column = \"laod\"\n"),
        &["has no column `laod`", "did you mean `load", "profile.column = \"laod\""],
    );
    says(
        &refused("time", "zeit [s];zeit [s];v [m/s]\n0;0;1\n1;1;1\n9;9;9\n", "profile.time_column = \"tiem\"\n"),
        &["has no column `tiem`"],
    );
    says(
        &refused("order", "t [s],v [m/s]\n0,1\n2,1\n2,1\n9,1\n", v),
        &["speed.csv:4:1", "the time in `speed.csv` does not increase: 2 s follows 2 s"],
    );
    says(&refused("number", "t [s],v [m/s]\n0,1\n2,1\n3,n/a\n9,1\n", v), &["speed.csv:4:1", "`v [m/s]` is `n/a`"]);
    says(&refused("unit", "t [s],v [furlong]\n0,1\n9,1\n", v), &["there is no unit `furlong`", "m/s"]);
    says(&refused("no-unit", "t [s],v\n0,1\n9,1\n", v), &["the column `v` has no unit", "needs `unit`", "`unit = \"m/s\"`"]);
    says(&refused("other-unit", "t [s],v [N]\n0,1\n9,1\n", v), &["`v [N]` is in N, but m/s is needed"]);
    says(&refused("time-unit", "t,v [m/s]\n0,1\n9,1\n", v), &["the column `t` has no unit", "needs `time_unit`"]);
    says(
        &refused("short", "t [s],v [m/s]\n0,1\n1,1\n", v),
        &["the profile is too short for the run", "ends at 1 s", "`duration_s` can be at most 1"],
    );
    says(&refused("late", "t [s],v [m/s]\n1,1\n19,1\n", v), &["no sample at 0 s", "with `from_s = 1`, playback begins"]);
    says(
        &refused("range", "t [s],v [m/s]\n0,1\n5,11\n9,1\n", v),
        &["leaves the range of `rig.slider.speed_m_per_s`: it is 11 at 5 s", "from -10 to 10 m/s"],
    );
    says(&refused("text", "Dear reader,\nno numbers\n", v), &["is not a table of numbers", "begins with `Dear reader,`"]);
    says(&refused("two", LONG, "profile.column = \"v\"\nto = 1\n"), &["`to` and [disturbance.profile] exclude each other"]);
    let twice = "profile.column = \"v\"\n[[disturbance]]\nat_s = 1\nkey = \"rig.slider.speed_m_per_s\"\nto = 0.05\n";
    says(&refused("twice", LONG, twice), &["another disturbance changes it as well"]);
}

#[test]
fn missing_files_have_a_nearest_name() {
    let folder = folder("absent");
    fs::write(folder.join("speed.csv"), LONG).unwrap();
    let text = format!("{}\n[[disturbance]]\nat_s = 0\nkey = \"rig.slider.load_n\"\nprofile.file = \"sped.csv\"\n", example());
    let report = load_text(&folder.join("a.toml").to_string_lossy(), &text, &[]).unwrap_err().to_string();
    fs::remove_dir_all(&folder).unwrap();
    says(&report, &["the file `sped.csv` cannot be read", "did you mean `speed.csv`?", "the path that was tried is"]);
    assert!(!Path::new("sped.csv").exists());
}

#[test]
fn samples_in_a_scene_are_checked_like_a_file() {
    let report =
        |profile: &str| super::report(example(), &["disturbance.0.at_s=0", "disturbance.0.key=rig.slider.load_n", profile]);
    says(&report("disturbance.0.profile={time_s=[0,9]}"), &["`time_s` without `values`"]);
    says(&report("disturbance.0.profile={time_s=[0,9], values=[1]}"), &["has 2 times and 1 values"]);
    says(&report("disturbance.0.profile={time_s=[0,1,1,9], values=[1,1,1,1]}"), &["does not increase: 1 s follows 1 s"]);
    says(&report("disturbance.0.profile={time_s=[0,9], values=[1,-1]}"), &["leaves the range of `rig.slider.load_n`"]);
    says(&report("disturbance.0.profile={time_s=[0,9], values=[1,\"a\"]}"), &["cannot be a string"]);
    says(&report("disturbance.0.profile={column=\"v\"}"), &["`column` without `file`"]);
    says(&report("disturbance.0.profile={}"), &["a profile without samples", "needs `file`"]);
    let both = "disturbance.0.profile={file=\"a.csv\", time_s=[0,9], values=[1,1]}";
    says(&report(both), &["`file` and `time_s` exclude each other"]);
}

#[test]
fn excitations_and_pulses_can_be_measured() {
    let measured =
        ["excitation.waveform=measured", "excitation.profile={time_s=[0,1e-4,1], values=[0,300,0]}"].map(str::to_owned);
    let scene = crate::load::load("contact", &measured).unwrap_or_else(|error| panic!("{error}")).scene;
    let study = scene.excited().unwrap();
    let problem = crate::problem::problem(&study, crate::problem::law(&study.model).unwrap()).unwrap();
    assert!((problem.waveform.value(0.5e-4) - 150.0).abs() < 1e-9);
    let without = |set: &str| crate::load::load("contact", &[set.to_owned()]).unwrap_err().to_string();
    says(&without("excitation.waveform=measured"), &["a measured excitation without `profile`"]);
    says(&without("excitation.profile={time_s=[0,1], values=[0,1]}"), &["is only for a measured waveform"]);

    let pulse = ["rig.dring.pulse={time_s=[0,0.05,0.1], values=[0,200,0]}".to_owned()];
    let scene = crate::load::load("dring-crash", &pulse).unwrap_or_else(|error| panic!("{error}")).scene;
    let dring = scene.rig.unwrap().dring.unwrap();
    assert_eq!((dring.pulse_s(), dring.pulse_g), (0.1, None));
    let high = crate::load::load("dring-crash", &["rig.dring.pulse={time_s=[0,1], values=[0,9000]}".to_owned()]);
    says(&high.unwrap_err().to_string(), &["leaves the range of `rig.dring.pulse`"]);
    let turned = crate::load::load("dring-crash", &["rig.dring.pulse={time_s=[0,0.05,0.1], values=[0,-200,0]}".to_owned()]);
    says(&turned.unwrap_err().to_string(), &["does not slow the vehicle: its speed falls by -10 m/s", "turn the sign"]);
}

#[test]
fn measured_normal_force_becomes_steps() {
    let load = [
        "disturbance.0.at_s=1e-3",
        "disturbance.0.key=contact.normal_n",
        "disturbance.0.profile={time_s=[0,1e-3,1], values=[0.2,0.4,0.4]}",
    ];
    let scene = crate::load::load("contact", &sets(&load)).unwrap_or_else(|error| panic!("{error}")).scene;
    let study = scene.excited().unwrap();
    let problem = crate::problem::problem(&study, crate::problem::law(&study.model).unwrap()).unwrap();
    let steps: Vec<f64> = problem.load_steps.iter().map(|(_, force)| force / study.model.mu()).collect();
    assert!((problem.load_steps[1].0 - 2e-3).abs() < 1e-12 && (steps[0] - 0.3).abs() < 1e-12 && steps.len() == 3, "{steps:?}");
}

#[test]
fn values_replaced_by_a_profile_cannot_be_varied() {
    let with = |at_s: &str, more: &[&str]| {
        let at_s = format!("disturbance.0.at_s={at_s}");
        let course = ["disturbance.0.key=rig.slider.speed_m_per_s", "disturbance.0.profile={time_s=[0,9], values=[0.03,0.04]}"];
        let changes = sets(&[&[at_s.as_str()], &course[..], more].concat());
        load_text("a.toml", &example_of_one_speed(), &changes).map(|loaded| loaded.scene).map_err(|error| error.to_string())
    };
    let grid = ["grid.over.1.key=rig.slider.speed_m_per_s", "grid.over.1.values=[0.01,0.02]"];
    let drawn = ["vary.0.key=rig.slider.speed_m_per_s", "vary.0.spread=0.1"];
    let follows = "`rig.slider.speed_m_per_s` follows the measured `disturbance.0.profile` from the beginning of the run";
    let refused = |more: &[&str]| with("0", more).expect_err("a key without effect");
    says(&refused(&grid), &[follows, "other values have no effect", "`disturbance.0.profile.from_s`", "1 problem"]);
    says(&refused(&drawn), &[follows, "1 problem"]);
    // If the profile begins later, or if its beginning varies, the value has an effect.
    let begins = ["grid.over.2.key=disturbance.0.at_s", "grid.over.2.values=[0,0.1]"];
    for (at_s, more) in [("0.1", &grid[..]), ("0.1", &drawn), ("0", &[grid, begins].concat())] {
        with(at_s, more).unwrap_or_else(|error| panic!("{error}"));
    }
}
