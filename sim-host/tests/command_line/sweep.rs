//! Sweeps: identical bytes for any number of threads, shards and interruptions, no partial files,
//! and clear errors.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::{Folder, code, sim_host, stderr, stdout};

/// Files that contain the result.
const RESULTS: [&str; 4] = ["sweep.parquet", "sweep.csv", "failures.csv", "plan.json"];
/// Sweep of a contact with a closed-form solution, over two keys.
const CONTACT: [&str; 8] = [
    "sweep",
    "contact-kinematic",
    "--over",
    "excitation.velocity_ratio=0.05:1.4:20",
    "--over",
    "contact.dahl.stiffness_n_per_m=1e5:1e7:9:log",
    "--metric",
    "friction_ratio,power_ratio",
];

fn sweep(arguments: &[&str], folder: &str) {
    let output = sim_host(&[arguments, &["-q", "-o", folder]].concat());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}

fn bytes(folder: &str, file: &str) -> Vec<u8> {
    std::fs::read(Path::new(folder).join(file)).unwrap_or_else(|error| panic!("{folder}/{file}: {error}"))
}

fn same(first: &str, second: &str) {
    for file in RESULTS {
        assert!(bytes(first, file) == bytes(second, file), "{file} of {first} and {second}");
    }
}

fn names(folder: &str) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().into_string().ok()).collect()
}

fn within(folder: &Folder, name: &str) -> String {
    format!("{}/{name}", folder.text())
}

/// Checks that a command fails with this exit code and these parts of a message.
fn refused(kind: i32, arguments: &[&str], says: &[&str]) {
    let output = sim_host(arguments);
    let text = stderr(&output);
    assert_eq!(code(&output), kind, "{arguments:?}: {text}");
    assert!(says.iter().all(|part| text.contains(part)), "{arguments:?}: {text}");
}

#[test]
fn threads_and_shards_write_the_same_bytes() {
    let folder = Folder::new("sweep");
    let [one, three, first, second, joined] = ["one", "three", "first", "second", "joined"].map(|name| within(&folder, name));
    sweep(&[&CONTACT[..], &["--jobs", "1"]].concat(), &one);
    sweep(&[&CONTACT[..], &["--jobs", "3"]].concat(), &three);
    same(&one, &three);
    assert!(bytes(&one, "report.html") == bytes(&three, "report.html"));
    sweep(&[&CONTACT[..], &["--shard", "1/2"]].concat(), &first);
    sweep(&[&CONTACT[..], &["--shard", "2/2"]].concat(), &second);
    assert!(!names(&first).contains("sweep.csv"), "a shard is not the whole sweep");
    let output = sim_host(&["merge", &first]);
    assert_eq!(code(&output), 3);
    assert!(stderr(&output).contains("92 of 180 points are missing: 11 to 21, 33 to 44,"), "{}", stderr(&output));
    let output = sim_host(&["merge", &second, &first, "-o", &joined, "--format", "json"]);
    let said: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert_eq!((said["points"].as_u64(), said["failures"].as_u64()), (Some(180), Some(0)), "{said}");
    same(&one, &joined);
    // Both shards in one folder: the last that ends joins them.
    let common = within(&folder, "common");
    sweep(&[&CONTACT[..], &["--shard", "2/2"]].concat(), &common);
    sweep(&[&CONTACT[..], &["--shard", "1/2"]].concat(), &common);
    same(&one, &common);
    assert!(bytes(&one, "report.html") == bytes(&common, "report.html"));
    let text = String::from_utf8(bytes(&one, "sweep.csv")).expect("text");
    let head = "point,excitation.velocity_ratio,contact.dahl.stiffness_n_per_m,friction_ratio,power_ratio,drive_hash,fault_code";
    assert_eq!((text.lines().next(), text.lines().count()), (Some(head), 181));
    assert!(names(&one).is_superset(&["report.html", "map-friction_ratio.png", "map-power_ratio.svg"].map(String::from).into()));
    assert!(!names(&one).iter().any(|name| name.ends_with(".tmp") || name.starts_with(".shard")));
}

/// Returns a sweep with points of a tenth of a second, so that a signal arrives during the sweep.
fn slow(folder: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sim-host"));
    command.args(["sweep", "lock", "--over", "stack.bvd.q=50:80:120", "--metric", "lock_time_20hz_ms,frequency_bias_hz"]);
    command.args(["--jobs", "1", "-o", folder]).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

/// Waits until a folder contains a part.
fn wait_for_part(folder: &str) {
    let began = Instant::now();
    while !names(folder).iter().any(|name| name.starts_with("part-") && name.ends_with(".parquet")) {
        assert!(began.elapsed() < Duration::from_secs(120), "no part appears");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[cfg(unix)]
#[test]
fn a_stopped_sweep_continues_from_its_last_point() {
    let folder = Folder::new("sweep-stopped");
    let [whole, killed, asked] = ["whole", "killed", "asked"].map(|name| within(&folder, name));
    assert!(slow(&whole).output().expect("sim-host starts").status.success());
    let mut child = slow(&killed).spawn().expect("sim-host starts");
    wait_for_part(&killed);
    child.kill().expect("it can be killed");
    child.wait().expect("an end");
    let child = slow(&asked).spawn().expect("sim-host starts");
    wait_for_part(&asked);
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.expect("`kill` starts").success());
    let output = child.wait_with_output().expect("an end");
    assert_eq!(
        (code(&output), stderr(&output).contains("the same command continues from there")),
        (130, true),
        "{}",
        stderr(&output)
    );
    for stopped in [&killed, &asked] {
        assert!(!names(stopped).contains("sweep.csv"), "it was stopped during the sweep");
        let again = slow(stopped).output().expect("sim-host starts");
        assert!(again.status.success(), "{}", stderr(&again));
        assert!(stderr(&again).contains("of 120 points are already done"), "{}", stderr(&again));
        same(&whole, stopped);
    }
    let text = String::from_utf8(bytes(&whole, "sweep.csv")).expect("text");
    assert!(
        text.lines().skip(1).all(|row| row.split(',').nth(4).is_some_and(|hash| hash.len() == 16) && row.ends_with(",0")),
        "{text}"
    );
}

#[test]
fn folders_of_other_sweeps_are_refused() {
    let folder = Folder::new("sweep-others");
    let [one, other] = ["one", "other"].map(|name| within(&folder, name));
    let short = ["sweep", "contact-kinematic", "--over", "contact.dahl.mu=0.1,0.2", "--metric", "friction_ratio"];
    sweep(&short, &one);
    sweep(&[&short[..], &["--set", "excitation.velocity_ratio=0.7"]].concat(), &other);
    refused(3, &["merge", &one, &other], &["different sweeps", "different values of the scene", "one", "other"]);
    let more = ["sweep", "contact-kinematic", "--over", "contact.dahl.mu=0.1,0.3", "--metric", "friction_ratio", "-o", &one];
    refused(2, &more, &["contains another sweep (different points)", "one"]);
    refused(2, &[&short[..5], &["power_ratio", "-o", &one]].concat(), &["different metrics"]);
    refused(3, &["merge", folder.text()], &["no sweep in", "plan.json"]);
    let stray = within(&folder, "stray");
    std::fs::create_dir(&stray).expect("a folder");
    std::fs::write(format!("{stray}/sweep.csv"), "mine").expect("a file");
    refused(2, &[&short[..], &["-o", &stray]].concat(), &["sweep.csv", "already exists"]);
    assert_eq!(names(&stray), ["sweep.csv".to_owned()].into());
}

#[test]
fn a_damaged_part_is_refused_and_computed_again() {
    let folder = Folder::new("sweep-damaged");
    let [whole, damaged] = ["whole", "damaged"].map(|name| within(&folder, name));
    let short = ["sweep", "contact-kinematic", "--over", "contact.dahl.mu=0.1,0.2", "--metric", "friction_ratio"];
    sweep(&short, &whole);
    sweep(&short, &damaged);
    let part = names(&damaged).into_iter().find(|name| name.starts_with("part-")).expect("a part");
    std::fs::write(format!("{damaged}/{part}"), "not a part").expect("a file");
    let target = within(&folder, "target");
    refused(1, &["merge", &damaged, "-o", &target], &[&part, "is damaged", "the `sweep` command that wrote it"]);
    assert_eq!(names(&target), [].into());
    let output = sim_host(&[&short[..], &["-o", &damaged]].concat());
    let said = stderr(&output);
    assert!(code(&output) == 0 && said.contains("note: `") && said.contains(&part) && said.contains("computed again"), "{said}");
    same(&whole, &damaged);
    assert_eq!(names(&whole), names(&damaged));
    // A plan with another number of points.
    let plan = String::from_utf8(bytes(&whole, "plan.json")).expect("text").replace("\"points\": 2", "\"points\": 1");
    std::fs::write(format!("{whole}/plan.json"), plan).expect("a file");
    refused(3, &["merge", &whole], &["plan.json", "was changed after it was written"]);
}

/// Kills a sweep at random times, damages a part after half of the kills, and continues it. The
/// result has the same bytes as that of an undisturbed sweep.
#[test]
#[ignore = "two minutes"]
fn a_sweep_survives_170_kills_and_damaged_parts() {
    let folder = Folder::new("sweep-attack");
    let [whole, attacked] = ["whole", "attacked"].map(|name| within(&folder, name));
    assert!(slow(&whole).output().expect("sim-host starts").status.success());
    let mut state = std::time::UNIX_EPOCH.elapsed().expect("a time").as_nanos() as u64;
    println!("seed {state}");
    let mut below = |bound: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % bound.max(1)
    };
    for _ in 0..170 {
        let mut child = slow(&attacked).stderr(Stdio::null()).spawn().expect("sim-host starts");
        std::thread::sleep(Duration::from_millis(below(1500) as u64));
        child.kill().expect("it can be killed");
        child.wait().expect("an end");
        let parts: Vec<String> = names(&attacked).into_iter().filter(|name| name.ends_with(".parquet")).collect();
        if let Some(part) = parts.get(below(2 * parts.len())) {
            let path = Path::new(&attacked).join(part);
            let mut bytes = std::fs::read(&path).expect("a part");
            match below(3) {
                0 => bytes.truncate(below(bytes.len())),
                1 => bytes.fill(0),
                _ => {
                    let at = below(bytes.len());
                    bytes[at] ^= 1 << below(8);
                }
            }
            std::fs::write(&path, bytes).expect("a part");
        }
        if names(&attacked).contains("sweep.csv") || below(10) == 0 {
            let end = slow(&attacked).output().expect("sim-host starts");
            assert!(end.status.success(), "{}", stderr(&end));
            same(&whole, &attacked);
            std::fs::remove_dir_all(&attacked).expect("it is deleted");
        }
    }
}

/// Checks a point with an invalid scene: a row without metrics, and a row of the failures with the
/// reason.
#[test]
fn a_bad_point_does_not_end_the_sweep() {
    let folder = Folder::new("sweep-bad");
    let points = folder.write("points.csv", "contact.dahl.mu,duration_s\n0.1,0.01\n0.2,0.0005\n0.3,0.01\n");
    let target = within(&folder, "out");
    let output = sim_host(&["sweep", "contact-kinematic", "--points", &points, "--metric", "friction_ratio", "-o", &target]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("1 of 3 points have no result"), "{}", stderr(&output));
    let text = String::from_utf8(bytes(&target, "sweep.csv")).expect("text");
    let rows: Vec<&str> = text.lines().collect();
    assert!(rows[2] == "1,0.2,0.0005,,," && rows[1].starts_with("0,0.1,0.01,0."), "{text}");
    let failures = String::from_utf8(bytes(&target, "failures.csv")).expect("text");
    assert!(failures.contains("1,0.2,0.0005,") && failures.contains("window_periods"), "{failures}");
}

/// Checks the columns for all runs of each point, and for all metrics that any point has.
#[test]
fn each_point_has_statistics_of_its_runs() {
    let folder = Folder::new("sweep-runs");
    let target = within(&folder, "out");
    sweep(&["sweep", "lock-cold", "--set", "runs=3", "--over", "controller.drive.amplitude_v=3,4"], &target);
    let text = String::from_utf8(bytes(&target, "sweep.csv")).expect("text");
    let head: Vec<&str> = text.lines().next().expect("a head").split(',').collect();
    assert!(["lock_time_20hz_ms", "lock_time_20hz_ms_p95", "runs_locked"].iter().all(|name| head.contains(name)), "{head:?}");
    assert!(!head.contains(&"rotor_speed_rad_per_s"), "no point has this metric");
}

#[test]
fn a_sample_has_indices() {
    let folder = Folder::new("sweep-sample");
    let target = within(&folder, "out");
    let over = [
        "--over",
        "excitation.velocity_ratio=0.2:0.9",
        "--over",
        "contact.dahl.mu=0.1:0.3",
        "--over",
        "contact.dahl.normal_n=1:2",
    ];
    let metric = ["--metric", "friction_ratio"];
    sweep(&[&["sweep", "contact-kinematic", "--sample", "sobol:64"][..], &over, &metric].concat(), &target);
    let text = String::from_utf8(bytes(&target, "indices.csv")).expect("text");
    let first = |key: &str| -> f64 {
        let row = text.lines().find(|row| row.starts_with(&format!("friction_ratio,{key},"))).unwrap_or_else(|| panic!("{text}"));
        row.split(',').nth(2).and_then(|cell| cell.parse().ok()).expect("a number")
    };
    // For a nearly rigid contact the velocity ratio explains nearly all variance.
    assert!(first("excitation.velocity_ratio") > 0.9 && first("contact.dahl.mu") < 0.1, "{text}");
    assert_eq!(String::from_utf8(bytes(&target, "sweep.csv")).expect("text").lines().count(), 64 * 5 + 1);
    assert!(names(&target).contains("parallel-friction_ratio.png"));
}

/// Simulates a full disk by a limit on the size of files.
#[cfg(unix)]
#[test]
fn write_errors_name_the_file_and_leave_no_part_of_it() {
    let folder = Folder::new("sweep-full");
    let target = within(&folder, "out");
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec '{}' sweep contact-kinematic --over contact.dahl.mu=0.01:0.5:20000 --metric friction_ratio -q -o '{target}'",
        env!("CARGO_BIN_EXE_sim-host")
    );
    let output = Command::new("sh").args(["-c", &script]).output().expect("a shell");
    let text = stderr(&output);
    assert_eq!((code(&output), text.contains("cannot write `") && text.contains(&target)), (1, true), "{text}");
    let left: Vec<String> = names(&target).into_iter().filter(|name| name != "plan.json" && !name.starts_with("part-")).collect();
    assert!(left.is_empty(), "{left:?}");
    // The existing parts are complete: with enough space the sweep continues to its end.
    sweep(&["sweep", "contact-kinematic", "--over", "contact.dahl.mu=0.01:0.5:20000", "--metric", "friction_ratio"], &target);
}

#[test]
fn a_plan_is_printed_and_nothing_is_written() {
    let folder = Folder::new("sweep-plan");
    let target = within(&folder, "out");
    let plan = ["sweep", "plan"].into_iter().chain(CONTACT[1..].iter().copied()).chain(["--format", "json", "-o", &target]);
    let output = sim_host(&plan.collect::<Vec<_>>());
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let plan: Value = serde_json::from_str(&stdout(&output)).expect("JSON");
    assert_eq!(plan["points"], 180);
    assert!(
        plan["cpu_s"].as_f64().is_some_and(|s| s > 0.0 && s < 60.0) && plan["bytes"].as_f64().is_some_and(|b| b > 1e4),
        "{plan}"
    );
    assert!(!Path::new(&target).exists());
}

#[test]
fn a_run_is_repeated_from_its_manifest_alone() {
    let folder = Folder::new("manifest");
    let [first, second] = ["first", "second"].map(|name| within(&folder, name));
    let output = sim_host(&["run", "lock", "--seed", "7", "--set", "stack.bvd.q=70", "-q", "-o", &first]);
    assert!([0, 4].contains(&code(&output)), "{}", stderr(&output));
    let output = sim_host(&["run", &format!("{first}/manifest.json"), "-q", "-o", &second]);
    assert!([0, 4].contains(&code(&output)), "{}", stderr(&output));
    assert!(bytes(&first, "summary.json") == bytes(&second, "summary.json"));
    let hash = |folder: &str| {
        let manifest: Value = serde_json::from_slice(&bytes(folder, "manifest.json")).expect("JSON");
        manifest["drive_hash"].clone()
    };
    assert!(hash(&first).is_string() && hash(&first) == hash(&second));
    let output = sim_host(&["check", &format!("{first}/summary.json")]);
    assert_eq!((code(&output), stderr(&output).contains("not the manifest of a run")), (3, true), "{}", stderr(&output));
}

#[test]
fn a_trace_has_the_selected_format() {
    let folder = Folder::new("traces");
    let trace = |format: &str| {
        let target = within(&folder, format);
        let sets = ["trace.signals=[\"drive_code_0\", \"tip_velocity_m_per_s\"]", "trace.to_s=0.002", "trace.every=2"];
        let format = format!("trace.format=\"{format}\"");
        let sets = sets.iter().copied().chain([format.as_str()]).flat_map(|set| ["--set", set]);
        let output = sim_host(&["run", "lock", "-q", "-o", &target].into_iter().chain(sets).collect::<Vec<_>>());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        target
    };
    let text = String::from_utf8(bytes(&trace("csv"), "trace.csv")).expect("text");
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect();
    let npy = trace("npy");
    let bytes_of = bytes(&npy, "trace.npy");
    let begin = 10 + usize::from(u16::from_le_bytes([bytes_of[8], bytes_of[9]]));
    let values: Vec<f64> =
        bytes_of[begin..].chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().expect("eight"))).collect();
    assert_eq!(values, rows.concat());
    assert!(!names(&npy).contains("trace.csv"));
    let parquet = bytes(&trace("parquet"), "trace.parquet");
    assert!(parquet.starts_with(b"PAR1") && parquet.ends_with(b"PAR1") && parquet.len() < text.len());
}
