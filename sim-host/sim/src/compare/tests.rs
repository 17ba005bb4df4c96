use std::fs;
use std::path::PathBuf;

use super::*;
use crate::output;
use crate::study::{self, Options};
use scene::load::load;

/// Temporary folder of a test, removed when dropped.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("compare-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).expect("a folder");
        Scratch(path)
    }

    fn run(&self, name: &str, scene: &str, sets: &[&str]) -> Side {
        let loaded =
            load(scene, &sets.iter().map(|&set| set.to_owned()).collect::<Vec<_>>()).unwrap_or_else(|error| panic!("{error}"));
        let study = study::run(&loaded, Options::default()).expect("a study");
        let dir = self.0.join(name);
        output::write(&loaded, &study, &dir).expect("written");
        Side::read(&dir).expect("a result")
    }

    fn file(&self, name: &str, text: &str) -> Result<Side, CompareError> {
        let path = self.0.join(name);
        fs::write(&path, text).expect("written");
        Side::read(&path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn tolerances(texts: &[&str]) -> Tolerances {
    Tolerances::parse(&texts.iter().map(|&text| text.to_owned()).collect::<Vec<_>>()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn equal_scenes_compare_equal_and_others_do_not() {
    let scratch = Scratch::new("twice");
    let sides = || (scratch.run("a", "lock", &[]), scratch.run("b", "lock", &[]), scratch.run("c", "lock", &["seed=7"]));
    let (a, b, c) = sides();
    let same = Comparison::new(a.clone(), b, &Tolerances::default(), &[]).expect("a comparison");
    assert!(same.holds() && same.same_drive() == Some(true) && same.rows.len() > 10, "{:?}", same.table());
    let other = Comparison::new(a.clone(), c.clone(), &Tolerances::default(), &[]).expect("a comparison");
    assert!(!other.holds() && other.same_drive() == Some(false));
    // Another noise seed does not move the resonance.
    let names = ["series_resonance_hz".to_owned(), "q".to_owned()];
    let near = Comparison::new(a, c, &tolerances(&["1%"]), &names).expect("a comparison");
    assert!(near.holds() && near.rows.len() == 2, "{:?}", near.table());
    let report = other.report();
    assert!(
        report.figures.iter().any(|figure| figure.id == "frequency" && figure.series.len() == 6),
        "{:?}",
        report.figures.len()
    );
}

#[test]
fn a_measurement_is_compared_within_its_deviation() {
    let scratch = Scratch::new("measured");
    let run = scratch.run("run", "contact-kinematic", &[]);
    let ratio = run.metric("friction_ratio").expect("a ratio").value;
    let file = |off: f64| format!("metric,value,sd\n# by hand\nfriction_ratio,{},0.01\nfriction_on_n,1,\n", ratio + off);
    for (off, holds) in [(0.019, true), (0.021, false)] {
        let measured = scratch.file("measured.csv", &file(off)).expect("a measurement");
        let compared = Comparison::new(run.clone(), measured, &tolerances(&["friction_on_n=10"]), &[]).expect("a comparison");
        assert_eq!(compared.holds(), holds, "{:?}", compared.table());
        assert!(compared.rows.iter().any(|row| row.holds().is_none()), "metrics without a measurement are listed");
    }
}

#[test]
fn a_changed_run_is_refused() {
    let scratch = Scratch::new("changed");
    scratch.run("run", "lock", &[]);
    let read = || Side::read(&scratch.0.join("run"));
    for name in ["summary.json", "frequency.csv"] {
        let path = scratch.0.join("run").join(name);
        let text = fs::read_to_string(&path).expect("a file");
        fs::write(&path, text.replacen('1', "2", 1)).expect("written");
        let error = read().expect_err(name).to_string();
        assert!(error.contains(&format!("{name} does not match its checksum")), "{error}");
        fs::write(&path, text).expect("written");
    }
    assert!(read().is_ok());
}

#[test]
fn tolerances_apply_to_all_metrics_or_to_one() {
    let tolerances = tolerances(&["2%", "friction_ratio=0.5", "power_ratio=10%"]);
    for (metric, size, sd, allowed) in
        [("q", 50.0, 0.0, 1.0), ("q", 50.0, 3.0, 6.0), ("friction_ratio", 9.0, 3.0, 0.5), ("power_ratio", 2.0, 0.0, 0.2)]
    {
        assert!((tolerances.allowed(metric, size, sd) - allowed).abs() < 1e-12, "{metric}");
    }
    for (text, why) in [
        ("x", "`x` is not a non-negative number"),
        ("-1", "`-1` is not a non-negative number"),
        ("q=", "`` is not a non-negative number"),
        ("frictoin_ratio=1", "did you mean"),
    ] {
        let error = Tolerances::parse(&[text.to_owned()]).expect_err(text).to_string();
        assert!(error.contains(why), "{error}");
    }
}

#[test]
fn invalid_results_are_reported_with_the_reason() {
    let scratch = Scratch::new("none");
    let error = |text: &str| scratch.file("m.csv", text).expect_err(text).to_string();
    assert!(Side::read(&scratch.0).expect_err("empty").to_string().contains("contains no run: manifest.json"));
    assert!(Side::read(&scratch.0.join("nowhere")).expect_err("absent").to_string().contains("cannot be read"));
    assert!(error("time_s,force_n\n1,2\n").contains("has the columns metric, value and optionally sd; it has `time_s`"));
    assert!(error("metric,value\nfrictoin_ratio,1\n").contains("line 2: there is no metric `frictoin_ratio`; did you mean"));
    assert!(error("metric,value\nq,1\nq,2\n").contains("line 3: `q` occurs twice"));
    assert!(error("metric,value\nq,1\nrm_ohm,many\n").contains("line 3: `rm_ohm,many` interrupts the table"));
    assert!(error("metric,value,sd\nq,1,-2\n").contains("the standard deviation -2 is negative"));
    let (one, other) = (scratch.file("a.csv", "metric,value\nq,1\n"), scratch.file("b.csv", "metric,value\nrm_ohm,1\n"));
    let (one, other) = (one.expect("a side"), other.expect("a side"));
    let nothing = Comparison::new(one.clone(), other.clone(), &Tolerances::default(), &[]).expect_err("nothing in common");
    assert!(nothing.to_string().contains("no metric in common"));
    let missing = Comparison::new(one, other, &Tolerances::default(), &["q".to_owned()]).expect_err("missing").to_string();
    assert!(missing.contains("b.csv has no metric `q`"), "{missing}");
}
