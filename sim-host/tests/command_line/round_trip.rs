//! Files that a command writes, read by the commands that take such data.

use super::{Folder, code, sim_host, stderr, stdout};
use serde_json::Value;

/// Runs a command, and returns its JSON.
fn run(arguments: &[&str]) -> Value {
    let output = sim_host(&[arguments, &["--format", "json"]].concat());
    assert_eq!(code(&output), 0, "{arguments:?}: {}", stderr(&output));
    serde_json::from_str(&stdout(&output)).unwrap_or(Value::Null)
}

#[test]
fn admittances_of_scan_commission_and_run_are_imported() {
    let folder = Folder::new("round-trip");
    let dir = |name: &str| format!("{}/{name}", folder.text());
    run(&["link", "sim:lock", "scan", "--points", "31", "-o", &dir("scan")]);
    run(&["link", "sim:transducer-skymen-60w", "commission", "--band", "35k:45k", "--max-volts", "3", "-o", &dir("commission")]);
    run(&["run", "lock", "-q", "-o", &dir("run")]);
    for (file, truth, tolerance_rel) in [
        ("scan/admittance.csv", 3.04, 0.01),
        ("scan/admittance_over_frequency.csv", 3.04, 0.01),
        ("commission/admittance_over_frequency.csv", 7.115, 0.01),
        ("run/admittance.csv", 3.04, 0.01),
        ("run/admittance-bode.csv", 3.04, 1e-3),
    ] {
        let found = run(&["import", "admittance", &dir(file), "--no-report", "-q"]);
        let rm = found["circuit"]["rm_ohm"]["value"].as_f64().unwrap_or_else(|| panic!("{found}"));
        assert!((rm / truth - 1.0).abs() < tolerance_rel, "{file}: {rm} ohm instead of {truth}");
    }
}

/// The scene of an import runs with the draws that are written next to it.
#[test]
fn an_imported_transducer_is_as_uncertain_as_its_fit() {
    let folder = Folder::new("drawn-import");
    let dir = |name: &str| format!("{}/{name}", folder.text());
    run(&["run", "lock", "-q", "-o", &dir("run")]);
    run(&["import", "admittance", &dir("run/admittance.csv"), "-q", "-o", &dir("import")]);
    let samples = dir("import/samples.csv");
    let sets = ["c0_f", "cm_f", "lm_h", "rm_ohm"]
        .map(|key| format!("stack.bvd.{key}={{ samples = \"{samples}\", column = \"{key}\" }}"));
    let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
    let scene = dir("import/admittance.toml");
    let found = run(&[&["run", &scene, "--samples", "4", "--no-report", "-q"], &sets[..]].concat());
    assert!(found["runs"] == 4 && found["metrics"]["frequency_bias_hz"].is_number(), "{found}");
}

#[test]
fn the_result_of_a_sweep_is_a_file_of_points() {
    let folder = Folder::new("points-again");
    let dir = |name: &str| format!("{}/{name}", folder.text());
    let sweep = |points: &[&str], to: &str| {
        let metric = ["--metric", "friction_ratio", "-q", "-o", to];
        let output = sim_host(&[&["sweep", "contact-kinematic"], points, &metric].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    };
    sweep(&["--over", "excitation.velocity_ratio=0.1:0.9:5"], &dir("a"));
    for (form, to) in [("csv", "b"), ("parquet", "c")] {
        sweep(&["--points", &dir(&format!("a/sweep.{form}"))], &dir(to));
        assert_eq!(folder.read(&format!("{to}/sweep.csv")), folder.read("a/sweep.csv"));
    }
}
