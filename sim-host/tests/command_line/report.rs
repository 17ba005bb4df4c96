//! Origin and inputs in a report, and options of its figures.

use serde_json::Value;

use super::{Folder, code, sim_host, stderr, stdout};

/// Scene on the base `contact` with another friction coefficient.
const MINE: &str = "base = \"contact\"\n[contact.dahl]\nmu = 0.15\n[integrator]\nwindow_periods = [10, 20]\n";

#[test]
fn a_changed_base_gives_no_notes_or_verdicts() {
    let folder = Folder::new("inherited");
    let scene = folder.write("mine.toml", MINE);
    let page = folder.0.join("page");
    let output = sim_host(&["run", &scene, "-o", page.to_str().expect("a path")]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let text = stdout(&output);
    for part in ["(with changed inputs)", "does not hold", "Expectations of the base scene `contact`"] {
        assert!(text.contains(part), "`{part}` is missing in\n{text}");
    }
    let html = folder.read("page/report.html");
    assert!(!html.contains("The vibration counts in the slip"), "the report contains notes of the base");
    for part in [
        "Inputs changed from `contact`",
        "<td>contact.dahl.mu</td>",
        "All inputs",
        "<td>rig.sdof.mass_kg</td>",
        "Source of the base scene",
    ] {
        assert!(html.contains(part), "`{part}` is missing");
    }
    let summary: Value = serde_json::from_str(&folder.read("page/summary.json")).expect("JSON");
    assert_eq!((&summary["expect"][0]["pass"], &summary["expect"][0]["counts"]), (&Value::Bool(false), &Value::Bool(false)));

    // A repeated expectation counts.
    let again = folder.write("again.toml", &format!("{MINE}[[expect]]\nmetric = \"friction_ratio\"\nmax = 0.1\n"));
    let output = sim_host(&["run", &again, "--no-report"]);
    assert_eq!(code(&output), 4);
    assert!(stdout(&output).contains("MISS"));
    // An expectation of the user's own scene counts with any setting.
    let own = folder.write("own.toml", &stdout(&sim_host(&["show", "contact"])));
    let output =
        sim_host(&["run", &own, "--no-report", "--set", "contact.dahl.mu=0.15", "--set", "integrator.window_periods=[10,20]"]);
    assert_eq!(code(&output), 4);
}

#[test]
fn a_report_states_its_origin() {
    let folder = Folder::new("origin");
    let output = sim_host(&["run", "contact", "--set", "integrator.window_periods=[10,20]", "-q", "-o", folder.text()]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let html = folder.read("report.html");
    for part in [
        "<dt>command</dt><dd>sim-host run contact --set &#39;integrator.window_periods=[10,20]&#39; -q</dd>",
        "<dt>sim-host</dt>",
    ] {
        assert!(html.contains(part), "`{part}` is missing");
    }
    assert!(!html.contains("<dt>date</dt>"), "a report is the same on any day");
    let version = stdout(&sim_host(&["--version"]));
    assert!(version.starts_with(&format!("sim-host {}", env!("CARGO_PKG_VERSION"))), "{version}");
    // The version and the report contain the same commit in a checkout.
    if let Some(commit) = version.split_once(" (").and_then(|(_, rest)| rest.trim_end().strip_suffix(')')) {
        assert!(html.contains(&format!("<dt>commit</dt><dd>{commit}</dd>")), "{commit}");
    }
}

#[test]
fn metrics_are_shown_with_their_digits() {
    let output = sim_host(&["run", "lock", "--no-report", "-v"]);
    let text = stdout(&output);
    let line = text.lines().find(|line| line.contains(" series_resonance_hz")).unwrap_or_default().to_owned();
    let value =
        line.split('│').find_map(|cell| cell.split_whitespace().find(|word| word.contains('.') && word.parse::<f64>().is_ok()));
    assert!(value.is_some_and(|value| value.len() >= 8) && line.contains("Hz"), "{line}");
}

#[test]
fn figures_have_the_size_and_formats_asked_for() {
    let folder = Folder::new("drawn");
    let scene = ["run", "contact", "--set", "integrator.window_periods=[10,20]", "-q", "-o", folder.text()];
    let formats = if cfg!(feature = "pdf") { "pdf,svg" } else { "svg" };
    let output = sim_host(&[&scene[..], &["--figure-size", "88x60mm", "--figure-format", formats]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    if cfg!(feature = "pdf") {
        let bytes = std::fs::read(folder.0.join("friction.pdf")).expect("a PDF");
        assert!(bytes.starts_with(b"%PDF-") && folder.read("report.html").contains("href=\"friction.pdf\""));
    }
    let svg = folder.read("friction.svg");
    assert!(svg.starts_with("<svg width=\"87.98mm\" height=\"59.96mm\"") && svg.contains("<text "), "{}", &svg[..100]);
    assert!(!folder.0.join("friction.png").exists() && folder.0.join("friction.csv").exists());
    // The next run replaces all of them.
    assert_eq!(code(&sim_host(&scene)), 0);
    assert!(!folder.0.join("friction.pdf").exists() && folder.0.join("friction.png").exists());
    for (option, value, says) in [
        ("--figure-size", "1600x900", "printed size, not pixels"),
        ("--figure-size", "wide", "must be a width in print"),
        ("--figure-format", "eps", "must be svg, png or pdf"),
    ] {
        let output = sim_host(&["run", "contact", option, value]);
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).contains(says), "{}", stderr(&output));
    }
}
