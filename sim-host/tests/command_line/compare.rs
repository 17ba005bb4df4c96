//! `sim-host compare`: two folders of runs, or a run and a measurement.

use super::{Folder, code, sim_host, stderr, stdout};
use serde_json::Value;

fn run(folder: &Folder, name: &str, changes: &[&str]) -> String {
    let dir = format!("{}/{name}", folder.text());
    let sets = changes.iter().flat_map(|change| ["--set", change]);
    let arguments: Vec<&str> = ["run", "contact-kinematic", "-o", &dir].into_iter().chain(sets).collect();
    assert_eq!(code(&sim_host(&arguments)), 0);
    dir
}

#[test]
fn a_change_beyond_its_tolerance_is_exit_code_4() {
    let folder = Folder::new("compare");
    let (a, b, c) = (run(&folder, "a", &[]), run(&folder, "b", &[]), run(&folder, "c", &["contact.dahl.mu=0.21", "expect=[]"]));
    assert_eq!(code(&sim_host(&["compare", &a, &b])), 0);
    let other = sim_host(&["compare", &a, &c, "--format", "json"]);
    let json: Value = serde_json::from_str(&stdout(&other)).expect("JSON");
    assert!(code(&other) == 4 && json["pass"] == false, "{json}");
    let page = format!("{}/page", folder.text());
    let wide = sim_host(&["compare", &a, &c, "--tolerance", "30%", "--metric", "friction_ratio,velocity_ratio", "-o", &page]);
    assert_eq!(code(&wide), 0, "{}", stdout(&wide));
    let html = folder.read("page/report.html");
    assert!(html.contains("B dashed") && html.contains("friction_ratio"));
}

#[test]
fn a_measurement_is_a_side_and_invalid_sides_are_named() {
    let folder = Folder::new("measured");
    let a = run(&folder, "a", &[]);
    let near = folder.write("near.csv", "metric,value,sd\nfriction_ratio,0.68,0.02\n");
    let far = folder.write("far.csv", "metric,value,sd\nfriction_ratio,0.9,0.02\n");
    let unknown = folder.write("unknown.csv", "metric,value\nfrictoin_ratio,0.9\n");
    assert_eq!([&near, &far, &unknown].map(|file| code(&sim_host(&["compare", &a, file]))), [0, 4, 3]);
    for (kind, arguments, why) in [
        (3, vec!["compare", &a, &unknown], "line 2: there is no metric `frictoin_ratio`; did you mean"),
        (3, vec!["compare", &a, folder.text()], "contains no run"),
        (2, vec!["compare", &a, &near, "--tolerance", "much"], "is not a tolerance"),
        (3, vec!["compare", &a, &near, "--metric", "q"], "has no metric `q`"),
    ] {
        let output = sim_host(&arguments);
        assert!(code(&output) == kind && stderr(&output).contains(why), "{why}: {}", stderr(&output));
    }
}
