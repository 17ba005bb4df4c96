//! The program as a user meets it: results, files, signals. `commands.rs` compares its output with
//! snapshots; `documented.rs` runs the commands of README and docs.

#[path = "command_line/ci.rs"]
mod ci;
#[path = "command_line/compare.rs"]
mod compare;
#[path = "command_line/exits.rs"]
mod exits;
#[path = "command_line/folder.rs"]
mod folder;
#[path = "command_line/help.rs"]
mod help;
#[path = "command_line/link.rs"]
mod link;
#[path = "command_line/measured.rs"]
mod measured;
#[path = "command_line/owner.rs"]
mod owner;
#[cfg(unix)]
#[path = "command_line/prompt.rs"]
mod prompt;
#[path = "command_line/report.rs"]
mod report;
#[path = "command_line/round_trip.rs"]
mod round_trip;
#[cfg(unix)]
#[path = "command_line/signals.rs"]
mod signals;
#[path = "command_line/spectrum.rs"]
mod spectrum;
#[path = "command_line/sweep.rs"]
mod sweep;

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

fn sim_host(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_sim-host")).args(arguments).output().expect("sim-host starts")
}

fn code(output: &Output) -> i32 {
    output.status.code().expect("an exit code")
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("text")
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("text")
}

/// Folder that is removed after the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("sim-host-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Folder(path)
    }

    fn text(&self) -> &str {
        self.0.to_str().expect("a path in UTF-8")
    }

    fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.0.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"))
    }

    fn write(&self, file: &str, text: &str) -> String {
        let path = self.0.join(file);
        std::fs::write(&path, text).expect("a file");
        path.to_str().expect("a path in UTF-8").to_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_run_writes_all_files_and_a_self_contained_page() {
    let folder = Folder::new("run");
    let output = sim_host(&["run", "lock", "-o", folder.text()]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stdout(&output).contains("simulated seconds per wall second"));
    for file in
        ["manifest.json", "summary.json", "trace.csv", "frequency.csv", "frequency.svg", "frequency.png", "admittance.png"]
    {
        assert!(Path::new(folder.text()).join(file).metadata().is_ok_and(|file| file.len() > 100), "{file}");
    }
    let page = folder.read("report.html");
    let outside = |text: &str| text.matches("src=\"http").count() + text.matches("href=\"http").count();
    assert_eq!(outside(&page), 0);
    let manifest: Value = serde_json::from_str(&folder.read("manifest.json")).expect("JSON");
    assert_eq!(manifest["resolved_scene"]["stack"]["bvd"]["q"], 64.6);
    assert_eq!(manifest["drive_hash"].as_str().map(str::len), Some(16));
}

#[test]
fn only_json_goes_to_standard_output() {
    let output = sim_host(&["run", "lock", "--no-report", "--format", "json", "--seed", "5"]);
    let summary: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert_eq!((summary["scene"].as_str(), summary["seed"].as_u64()), (Some("lock"), Some(5)));
    assert!(summary["metrics"]["q"].as_f64().is_some_and(|q| (q - 64.6).abs() < 0.5));
}

#[test]
fn a_contact_study_has_no_values_of_a_controller() {
    let folder = Folder::new("contact");
    let output = sim_host(&["run", "contact", "--format", "json", "-o", folder.text()]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let summary: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    for metric in ["friction_ratio", "power_ratio", "velocity_ratio", "kappa", "error_estimate", "plant_states"] {
        assert!(summary["metrics"][metric].is_number(), "{metric} in {summary}");
    }
    assert!(summary["machine"]["ns_per_period"].is_number() && summary["metrics"].get("ns_per_period").is_none(), "{summary}");
    assert!(summary["solution"]["method"].is_string() && summary.get("drive_hash").is_none(), "{summary}");
    for file in ["report.html", "friction.png", "hysteresis.svg", "power.csv", "trace.csv"] {
        assert!(Path::new(folder.text()).join(file).metadata().is_ok_and(|file| file.len() > 100), "{file}");
    }
    let manifest: Value = serde_json::from_str(&folder.read("manifest.json")).expect("JSON");
    assert!(manifest["resolved_scene"].get("sensors").is_none() && manifest["resolved_scene"]["excitation"].is_object());
}

#[test]
fn a_contact_study_reports_its_method() {
    let sets = ["excitation.sliding_m_per_s=0.02", "excitation.frequency_hz=12978.69", "duration_s=2e-3"];
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<&str> = ["run", "contact", "--no-report", "--set", "integrator.window_periods=[10,20]"].into();
    let output = sim_host(&arguments.into_iter().chain(sets).collect::<Vec<_>>());
    let text = stdout(&output);
    for part in
        ["grows without bound", "Means over periods 10 to 20", "method ", "error estimate of the friction ratio", "does not hold"]
    {
        assert!(text.contains(part), "`{part}` is missing in\n{text}");
    }
    assert_eq!(code(&output), 0, "expectations of a base with other inputs must not count");
}

#[test]
fn a_missed_expectation_is_exit_code_4() {
    let output = sim_host(&["run", "lock", "--no-report", "--set", "expect.0.value=50"]);
    assert_eq!(code(&output), 4);
    assert!(stdout(&output).contains("MISS"));
}

#[test]
fn many_runs_write_a_table_and_each_can_be_repeated() {
    let folder = Folder::new("runs");
    let many = ["run", "lock-cold", "--set", "runs=3"];
    let output = sim_host(&[&many[..], &["--format", "json", "-o", folder.text()]].concat());
    let summary: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert_eq!((&summary["metrics"]["runs_completed"], &summary["runs"]), (&Value::from(3.0), &Value::from(3)));
    let report = folder.read("report.html");
    assert!(report.contains("--run ") && report.contains("Published figures"), "the report lacks the worst run or its command");
    let table = folder.read("runs.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|head| *head == name).unwrap_or_else(|| panic!("no {name} in {table}"));
    assert_eq!((rows.len(), rows[2][column("run")]), (4, "2"));
    let alone = sim_host(&[&many[..], &["--format", "json", "--no-report", "--run", "2"]].concat());
    let alone: Value = serde_json::from_str(&stdout(&alone)).expect("JSON");
    assert_eq!(alone["seed"].to_string(), rows[2][column("seed")]);
    // Reading a number from JSON may change its last bit.
    let (bias, row) = (alone["metrics"]["frequency_bias_hz"].as_f64().expect("a number"), rows[2][column("frequency_bias_hz")]);
    assert!((bias - row.parse::<f64>().expect("a number")).abs() <= f64::EPSILON * bias.abs(), "{bias} {row}");
    assert_eq!(code(&sim_host(&[&many[..], &["--no-report", "--run", "0"]].concat())), 3);
}

#[test]
fn a_moved_bench_is_reported_with_its_new_command() {
    let benches = include_str!("../evidence/src/bench.rs");
    let names: Vec<&str> =
        benches.split("bench(").filter_map(|rest| rest.trim_start().strip_prefix('"')?.split('"').next()).collect();
    assert!(names.len() >= 20, "{names:?}");
    for name in names {
        let moved = sim_host(&["validate", name, "--quick"]);
        let command = format!("`cargo run --release -p sonoglide-evidence -- {name}`");
        assert!(code(&moved) == 2 && stderr(&moved).contains(&command), "{}", stderr(&moved));
    }
    let shown = sim_host(&["validate", "show", "crash"]);
    assert!(code(&shown) == 2 && stderr(&shown).contains("-- show crash`"), "{}", stderr(&shown));
}

#[test]
fn a_missing_feature_is_reported_with_its_build_command() {
    let (board, pdf) = (cfg!(feature = "board-model"), cfg!(feature = "pdf"));
    for (command, has) in [
        (&["run", "dummy-load", "--board", "--no-report"][..], board),
        (&["link", "board:dummy-load", "status"], board),
        (&["run", "contact-kinematic", "--figure-format", "pdf", "--no-report"], pdf),
    ] {
        if !has {
            let refused = sim_host(command);
            let named = stderr(&refused).contains("cargo run --release --features full --");
            assert!(code(&refused) == 2 && named, "{}", stderr(&refused));
        }
    }
}

/// Runs the example of docs/ci.md, with fewer runs.
#[test]
fn a_users_suite_runs_and_is_checked() {
    let page = include_str!("../../docs/ci.md");
    let mut blocks = page.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
    let text = blocks.find(|block| block.contains("scene = \"lock-cold\"")).expect("the example");
    let folder = Folder::new("suite");
    let file = folder.write("lock.toml", text);
    let run = |more: &[&str]| sim_host(&[&["validate", &file, "--quick", "-q"], more].concat());
    let output = run(&["-o", folder.text()]);
    let shown = stdout(&output);
    assert_eq!(code(&output), 0, "{shown}{}", stderr(&output));
    assert!(
        shown.contains("cold, unloaded") && shown.contains("PASS") && folder.read("report.html").contains("noisy"),
        "{shown}"
    );
    assert!(stdout(&run(&["--list"])).contains("noisy: sim-host run lock-cold --set stack.bvd.q=65"));
    let strict = folder.write("strict.toml", &text.replace("max = 0.5", "max = 0.01"));
    let output = sim_host(&["validate", &strict, "--quick", "--no-report", "--format", "json"]);
    let summary: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert_eq!((code(&output), &summary["targets"][0]["missed"][2]), (4, &Value::from("noisy")), "{summary}");
    let wrong = folder.write("wrong.toml", &text.replace("noise_lsb", "noise_lbs"));
    let output = sim_host(&["validate", &wrong]);
    assert!(code(&output) == 3 && stderr(&output).contains("did you mean `noise_lsb`?"), "{}", stderr(&output));
}

#[test]
fn a_closed_standard_error_does_not_panic() {
    let folder = Folder::new("closed-stderr");
    let file = folder.write("bad.toml", "[x]\n");
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let status = Command::new(env!("CARGO_BIN_EXE_sim-host")).args(["check", &file]).stderr(writer).status();
    assert_eq!(status.expect("sim-host starts").code(), Some(3));
}

/// Checks the JSON keys of an advice, which are a stable interface.
#[test]
fn advice_has_its_keys() {
    let numbers = ["--frequency-hz", "40e3", "--q", "65", "--c0-f", "300e-9", "--lm-h", "0.7916e-3"];
    let output = sim_host(&[&["advise"], &numbers[..], &["--format", "json"]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let advice: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    let keys = |value: &Value| value.as_object().map(|table| table.keys().cloned().collect::<Vec<_>>().join(" "));
    assert_eq!(keys(&advice).as_deref(), Some("prediction settings transducer warnings"));
    assert_eq!(
        keys(&advice["transducer"]).as_deref(),
        Some(
            "c0_f cm_f coupling figure_of_merit lm_h parallel_resonance_hz q rm_ohm series_resonance_hz time_constant_ms \
             zero_phase_bias_hz"
        )
    );
    assert_eq!(keys(&advice["settings"]).as_deref(), Some("bandwidth_hz block_samples blocks drive snippet span"));
    assert_eq!(
        keys(&advice["prediction"]).as_deref(),
        Some(
            "bandwidth_hz bias_hz_per_ns_skew bias_hz_per_percent_c0 draws jitter_bound_hz jitter_hz jitter_stated_hz lock \
             loss_noticed_ms ramps"
        )
    );
    let lock = &advice["prediction"]["lock"][2];
    assert_eq!(keys(lock).as_deref(), Some("bound_median_ms bound_p95_ms median_ms p95_ms within_hz"));
    assert!(lock["p95_ms"].as_f64().is_some_and(|ms| ms < 1.0), "{lock}");
}

#[test]
fn the_output_of_show_is_a_scene() {
    let shown = sim_host(&["show", "experiment-1", "--set", "rig.slider.load_n=2"]);
    let folder = Folder::new("show");
    let scene = folder.write("shown.toml", &stdout(&shown));
    assert_eq!(code(&sim_host(&["check", &scene])), 0);
    assert!(stdout(&shown).contains("load_n = 2.0"));
}

#[test]
fn list_and_schema_contain_scenes_and_keys() {
    let list = stdout(&sim_host(&["list"]));
    assert!(["experiment-1 ", "lock-step", "transducer-skymen-60w"].iter().all(|name| list.contains(name)), "{list}");
    let schema: Value = serde_json::from_str(&stdout(&sim_host(&["schema"]))).expect("JSON");
    assert!(schema["properties"]["controller"].is_object());
}

#[test]
fn a_trace_holds_the_signals_asked_for() {
    let folder = Folder::new("trace");
    let output = sim_host(&[
        "run",
        "lock",
        "-q",
        "-o",
        folder.text(),
        "--set",
        "trace.signals=[\"drive_code_0\",\"tip_velocity_m_per_s\"]",
        "--set",
        "trace.from_s=0.16",
        "--set",
        "trace.to_s=0.161",
        "--set",
        "trace.every=10",
    ]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let trace = folder.read("trace.csv");
    let lines: Vec<&str> = trace.lines().collect();
    assert_eq!(lines[0], "time_s,drive_code_0,tip_velocity_m_per_s");
    assert_eq!(lines.len(), 101);
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_and_marks_its_results() {
    interrupted("lock", &["duration_s=900", "controller.burst.off_s=[0.22,900]"]);
    interrupted("contact", &["duration_s=900", "integrator.method=rk4", "integrator.window=run"]);
}

#[cfg(unix)]
fn interrupted(scene: &str, sets: &[&str]) {
    let folder = Folder::new(&format!("interrupted-{scene}"));
    let child = Command::new(env!("CARGO_BIN_EXE_sim-host"))
        .args(["run", scene, "-o", folder.text()])
        .args(sets.iter().flat_map(|set| ["--set", set]))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("sim-host starts");
    std::thread::sleep(std::time::Duration::from_millis(700));
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill").success());
    let asked = std::time::Instant::now();
    let output = child.wait_with_output().expect("it ends");
    // The limit allows for a busy machine; completing the run would take twenty seconds.
    assert!(asked.elapsed().as_secs() < 10, "{scene}: {:?}", asked.elapsed());
    assert_eq!(code(&output), 130, "{}", stderr(&output));
    assert!(stdout(&output).contains("INTERRUPTED"));
    let summary: Value = serde_json::from_str(&folder.read("summary.json")).expect("JSON");
    assert_eq!(summary["interrupted"], true);
    assert!(folder.read("report.html").to_lowercase().contains("interrupted"));
}
