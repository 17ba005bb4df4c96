//! Folder of a run: it contains one complete run and no file of another.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use super::{Folder, code, sim_host, stderr};

/// A driven scene that runs in an instant. It shares the names of some files with `CONTACT`, but no
/// figure.
const DRIVEN: [&str; 2] = ["run", "lock"];
/// A contact study that runs in an instant.
const CONTACT: [&str; 4] = ["run", "contact", "--set", "integrator.window_periods=[10,20]"];

/// Runs a scene into a folder.
fn run(scene: &[&str], folder: &Path) {
    let output = sim_host(&[scene, &["-q", "-o", folder.to_str().expect("a path in UTF-8")]].concat());
    assert!([0, 4].contains(&code(&output)), "{}", stderr(&output));
}

/// Returns the names of all files in a folder, including hidden ones.
pub(super) fn names(folder: &Path) -> BTreeSet<String> {
    std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().into_string().expect("text"))
        .collect()
}

pub(super) fn manifest(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("manifest.json")).expect("a manifest");
    serde_json::from_str(&text).expect("JSON")
}

/// Returns the files that a manifest lists, and the manifest itself.
pub(super) fn listed(folder: &Path) -> BTreeSet<String> {
    let manifest = manifest(folder);
    let files = manifest["files"].as_array().expect("a list").iter().map(|file| file.as_str().expect("a name").to_owned());
    files.chain(["manifest.json".to_owned()]).collect()
}

/// Starts a run that takes longer than any test.
fn endless(folder: &Path) -> Child {
    Command::new(env!("CARGO_BIN_EXE_sim-host"))
        .args(["run", "lock", "-q", "--set", "duration_s=900", "--set", "controller.burst.off_s=[0.22,900]", "-o"])
        .arg(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("sim-host starts")
}

/// Waits until a run has wait_for_run.
fn wait_for_run(folder: &Path) {
    while !folder.is_dir() || !names(folder).iter().any(|name| name.starts_with(".unfinished-")) {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
}

/// Checks that two runs of a scene differ only in `machine.json`, its checksum, and the checksum of
/// the manifest.
#[test]
fn two_runs_differ_only_in_machine() {
    let folder = Folder::new("bytes");
    let several: [&str; 4] = ["run", "lock-cold", "--set", "runs=2"];
    for (name, scene) in [("driven", &DRIVEN[..]), ("contact", &CONTACT), ("several", &several)] {
        let [one, other] = ["1", "2"].map(|n| folder.0.join(format!("{name}-{n}")));
        run(scene, &one);
        run(scene, &other);
        assert_eq!(names(&one), names(&other));
        for file in names(&one).iter().filter(|file| *file != "machine.json") {
            assert!(lasting(&one.join(file)) == lasting(&other.join(file)), "{name}: {file}");
        }
        let machine = std::fs::read_to_string(one.join("machine.json")).expect("text");
        let machine: Value = serde_json::from_str(&machine).expect("JSON");
        assert!(machine["date"].as_str().is_some_and(|date| date.len() == 20 && date.ends_with('Z')), "{machine}");
        let timed = if name == "contact" { "ns_per_period" } else { "simulated_s_per_wall_s" };
        assert!(machine[timed].as_f64().is_some_and(|figure| figure > 0.0) && listed(&one).contains("machine.json"), "{machine}");
    }
}

/// Reads a file without the checksums that differ.
fn lasting(path: &Path) -> Vec<u8> {
    let bytes = std::fs::read(path).expect("a file");
    if path.file_name().is_none_or(|name| name != "manifest.json") {
        return bytes;
    }
    let mut manifest: Value = serde_json::from_slice(&bytes).expect("JSON");
    for file in ["machine.json", "manifest.json"] {
        let sum = manifest["checksums"][file].take();
        assert!(sum.as_str().is_some_and(|sum| sum.len() == 16), "{file}: {sum}");
    }
    manifest.to_string().into_bytes()
}

#[test]
fn a_run_replaces_another_and_keeps_foreign_files() {
    let folder = Folder::new("places");
    let (both, alone) = (folder.0.join("both"), folder.0.join("alone"));
    run(&CONTACT, &alone);
    run(&DRIVEN, &both);
    assert_eq!((names(&both), manifest(&both)["complete"].as_bool()), (listed(&both), Some(true)));
    assert!(both.join("frequency.svg").is_file() && !names(&alone).contains("frequency.svg"));
    std::fs::write(both.join("notes.txt"), "mine").expect("a file");
    std::fs::create_dir(both.join("own")).expect("a folder");
    run(&CONTACT, &both);
    assert_eq!(names(&both), &names(&alone) | &["notes.txt", "own"].map(String::from).into());
    assert_eq!(listed(&both), listed(&alone));
    assert_eq!(manifest(&both)["scene"], "contact");
}

#[test]
fn foreign_files_are_not_overwritten() {
    let folder = Folder::new("strange");
    let path = folder.0.as_path();
    let mine = |name: &str, text: &str| std::fs::write(path.join(name), text).expect("a file");
    // Detected before the run: it is refused at once.
    for (name, text) in
        [("trace.csv", "mine"), ("manifest.json", "{ \"files\": []"), ("manifest.json", "{\"program\": \"another\"}")]
    {
        mine(name, text);
        let output = sim_host(&["run", "lock", "-o", folder.text()]);
        assert_eq!(code(&output), 2, "{}", stderr(&output));
        assert!(
            stderr(&output).contains(name) && stderr(&output).contains("choose another folder with -o"),
            "{}",
            stderr(&output)
        );
        assert_eq!((names(path), folder.read(name)), (BTreeSet::from([name.to_owned()]), text.to_owned()));
        std::fs::remove_file(path.join(name)).expect("a file");
    }
    // Detected after the run: nothing is lost.
    mine("frequency.csv", "mine");
    let output = sim_host(&["run", "lock", "-q", "-o", folder.text()]);
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    assert!(stderr(&output).contains("frequency.csv") && stderr(&output).contains("run-1"), "{}", stderr(&output));
    assert_eq!(
        (names(path), folder.read("frequency.csv").as_str()),
        (["frequency.csv", "run-1"].map(String::from).into(), "mine")
    );
    let whole = path.join("run-1");
    assert_eq!((names(&whole), manifest(&whole)["complete"].as_bool()), (listed(&whole), Some(true)));
}

#[test]
fn a_folder_with_an_invalid_manifest_is_not_changed() {
    let folder = Folder::new("untrusted");
    let inner = folder.0.join("run");
    run(&DRIVEN, &inner);
    std::fs::write(folder.0.join("outside.csv"), "mine").expect("a file");
    let (before, was) = (names(&inner), manifest(&inner));
    let changed = |key: &str, value: Value| {
        let mut manifest = was.clone();
        manifest[key] = value;
        manifest
    };
    // Of version 0.1.0, of another command, with a path out of the folder, and with a file of the
    // user.
    for (manifest, why) in [
        (changed("checksums", Value::Null), "was written by an older version"),
        (changed("command", "import friction".into()), "belongs to the command `import friction`"),
        (changed("files", serde_json::json!(["../outside.csv"])), "was changed"),
        (changed("files", serde_json::json!(["notes.txt"])), "was changed"),
    ] {
        std::fs::write(inner.join("manifest.json"), format!("{manifest:#}\n")).expect("a file");
        let output = sim_host(&["run", "contact", "-o", inner.to_str().expect("a path in UTF-8")]);
        assert!(code(&output) == 2 && stderr(&output).contains(why), "{}", stderr(&output));
        assert_eq!((names(&inner), folder.read("outside.csv").as_str()), (before.clone(), "mine"));
    }
}

#[test]
fn a_run_that_fails_leaves_no_folder() {
    let folder = Folder::new("fails");
    let inner = folder.0.join("run");
    let path = inner.to_str().expect("a path in UTF-8");
    let output = sim_host(&["run", "contact", "--pil", "-o", path]);
    assert!(code(&output) == 3 && !inner.exists(), "{}", stderr(&output));
    // An impossible folder is reported before the run.
    std::fs::write(&inner, "a file").expect("a file");
    let output = sim_host(&["run", "lock", "-o", path, "--set", "duration_s=900"]);
    assert!(code(&output) == 1 && stderr(&output).contains("cannot write"), "{}", stderr(&output));
}

/// Checks a folder that even root cannot write to, and a file instead of a folder.
#[cfg(target_os = "linux")]
#[test]
fn an_unwritable_folder_is_named() {
    for place in ["/proc/sonoglide", "/dev/null/sonoglide"] {
        let output = sim_host(&["run", "lock", "-q", "-o", place]);
        let said = stderr(&output);
        assert!(code(&output) == 1 && said.contains(&format!("cannot write `{place}`")), "{place}: {said}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_replaces_files_and_a_killed_one_does_not() {
    let folder = Folder::new("cut");
    let inner = folder.0.join("run");
    run(&CONTACT, &inner);
    let (before, was) = (names(&inner), manifest(&inner));
    let mut killed = endless(&inner);
    wait_for_run(&inner);
    killed.kill().expect("it can be killed");
    killed.wait().expect("an end");
    // The earlier run is complete, and the files of the killed one are hidden.
    let left = names(&inner);
    assert!(left.is_superset(&before) && left.len() == before.len() + 1, "{left:?}");
    assert_eq!(manifest(&inner), was);
    for signal in ["INT", "TERM"] {
        let mut cut = endless(&inner);
        // In addition to that of the killed one.
        while names(&inner).iter().filter(|name| name.starts_with(".unfinished-")).count() < 1 + usize::from(signal == "INT") {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        std::thread::sleep(std::time::Duration::from_millis(700));
        let pid = cut.id().to_string();
        assert!(Command::new("kill").args([&format!("-{signal}"), &pid]).status().expect("`kill` starts").success());
        assert_eq!(cut.wait().expect("an end").code(), Some(130), "{signal}");
        assert_eq!(names(&inner), listed(&inner), "{signal}");
        let cut = manifest(&inner);
        assert_eq!((&cut["scene"], &cut["interrupted"], &cut["complete"]), (&"lock".into(), &true.into(), &false.into()));
    }
}

#[cfg(unix)]
#[test]
fn a_second_run_into_the_same_folder_is_refused() {
    let folder = Folder::new("two");
    let inner = folder.0.join("run");
    let path = inner.to_str().expect("a path in UTF-8");
    let mut first = endless(&inner);
    wait_for_run(&inner);
    let second = sim_host(&["run", "lock", "-o", path]);
    assert_eq!(code(&second), 2, "{}", stderr(&second));
    let process = format!("by process {}", first.id());
    assert!(stderr(&second).contains(&process) && stderr(&second).contains("another folder with -o"), "{}", stderr(&second));
    assert_eq!(names(&inner).len(), 1);
    first.kill().expect("it can be killed");
    first.wait().expect("an end");
    // Several at once: a run that is not refused is complete.
    let ended = std::thread::scope(|threads| {
        let runs = [&DRIVEN[..], &CONTACT[..], &DRIVEN[..], &CONTACT[..]]
            .map(|scene| threads.spawn(move || code(&sim_host(&[scene, &["-q", "-o", path]].concat()))));
        runs.map(|run| run.join().expect("an end"))
    });
    assert!(ended.iter().all(|code| [0, 2, 4].contains(code)) && ended.iter().any(|code| *code != 2), "{ended:?}");
    assert_eq!((names(&inner), manifest(&inner)["complete"].as_bool()), (listed(&inner), Some(true)));
}

/// Checks the contents of a folder after a run into it has ended early.
///
/// It contains the complete earlier run, the complete new run, or a manifest that is marked as
/// incomplete and lists all files. Returns `true` if it is complete.
fn check_contents(inner: &Path, before: &BTreeSet<String>, was: &Value, context: &str) -> bool {
    let there: BTreeSet<String> = names(inner).into_iter().filter(|name| !name.starts_with(".unfinished-")).collect();
    let now = manifest(inner);
    match now["complete"].as_bool() {
        Some(true) if now == *was => assert_eq!(&there, before, "{context}"),
        Some(true) => assert_eq!(there, listed(inner), "{context}"),
        _ => assert!(there.is_subset(&listed(inner)), "{context}: {there:?} {now}"),
    }
    now["complete"] == true
}

/// Runs a scene with files limited to a number of blocks of 512 bytes, as on a full disk. The write
/// fails if `ignores_signal`, or else the signal kills the run.
#[cfg(target_os = "linux")]
fn within_blocks(blocks: u32, ignores_signal: bool, inner: &Path) -> std::process::Output {
    let program = env!("CARGO_BIN_EXE_sim-host");
    let trap = if ignores_signal { "trap '' XFSZ; " } else { "" };
    let line = format!("{trap}ulimit -c 0; ulimit -f {blocks}; exec \"{program}\" run lock -q -o \"{}\"", inner.display());
    Command::new("sh").args(["-c", &line]).output().expect("`sh` starts")
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_the_earlier_run_and_is_reported() {
    let folder = Folder::new("full");
    let inner = folder.0.join("run");
    run(&CONTACT, &inner);
    let (before, mut was) = (names(&inner), manifest(&inner));
    // From the first byte, and from each longer file.
    let (mut ended, mut killed) = (0, 0);
    for blocks in [0, 1, 4, 16, 64, 256] {
        let output = within_blocks(blocks, true, &inner);
        if output.status.code() == Some(0) {
            break;
        }
        ended += 1;
        assert_eq!(code(&output), 1, "{blocks}: {}", stderr(&output));
        assert!(
            stderr(&output).contains("cannot write") && stderr(&output).contains("too large"),
            "{blocks}: {}",
            stderr(&output)
        );
        assert_eq!((names(&inner), manifest(&inner)), (before.clone(), was.clone()), "{blocks}");
        // Killed by the signal during a write: nothing cleans up, and the earlier run stays
        // complete.
        let output = within_blocks(blocks, false, &inner);
        assert_eq!(output.status.code(), None, "{blocks}: {}", stderr(&output));
        killed += 1;
        assert!(check_contents(&inner, &before, &was, "killed") && manifest(&inner) == was, "{blocks}");
        // The remains do not disturb the next run.
        let lasting_before = lasting(&inner.join("manifest.json"));
        run(&CONTACT, &inner);
        assert_eq!((names(&inner), lasting(&inner.join("manifest.json"))), (before.clone(), lasting_before), "{blocks}");
        was = manifest(&inner);
    }
    assert!(ended >= 4 && killed >= 4, "{ended} {killed}");
    // A place that accepts no files.
    let output = sim_host(&["run", "lock", "-q", "-o", "/proc/none"]);
    assert!(code(&output) == 1 && stderr(&output).contains("cannot write `/proc/none`"), "{}", stderr(&output));
}

#[cfg(unix)]
#[test]
fn a_killed_run_leaves_a_complete_or_marked_folder() {
    let folder = Folder::new("killed");
    let inner = folder.0.join("run");
    let began = std::time::Instant::now();
    run(&DRIVEN, &inner);
    let takes = began.elapsed();
    run(&CONTACT, &inner);
    let (mut before, mut was) = (names(&inner), manifest(&inner));
    let (mut whole, mut cut) = (0, 0);
    for n in 0..24_u32 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_sim-host"))
            .args(["run", if n % 2 == 0 { "lock" } else { "dummy-load" }, "-q", "-o"])
            .arg(&inner)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("sim-host starts");
        let until = std::time::Instant::now() + 2 * takes;
        if n % 4 == 0 {
            // At some moment of the run.
            std::thread::sleep(takes * n / 24);
        } else {
            // While it moves its files: as soon as the manifest changes, and a little later.
            let text = || std::fs::read(inner.join("manifest.json")).unwrap_or_default();
            let old = text();
            while text() == old && std::time::Instant::now() < until {
                std::hint::spin_loop();
            }
            let later = std::time::Instant::now() + std::time::Duration::from_micros(20) * (n % 4 - 1) * n;
            while std::time::Instant::now() < later {
                std::hint::spin_loop();
            }
        }
        let _ = child.kill();
        child.wait().expect("an end");
        if check_contents(&inner, &before, &was, &n.to_string()) {
            whole += 1;
        } else {
            cut += 1;
            // The next run cleans up.
            run(&CONTACT, &inner);
            assert_eq!(names(&inner), listed(&inner));
        }
        (before, was) = (names(&inner).into_iter().filter(|name| !name.starts_with(".unfinished-")).collect(), manifest(&inner));
    }
    println!("{whole} complete, {cut} marked as incomplete");
    assert!(whole > 0 && cut > 0, "both cases must occur: {whole} {cut}");
}
