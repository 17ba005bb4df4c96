//! Runs every command that README, docs and help print, and checks every scene in them.
//!
//! Scenes of many runs are shortened to two runs, so they may miss expectations (exit code 4).
//! Single runs may not, unless the page changes values. Measured files that the pages name are
//! synthesised from a circuit and a contact. `cargo test` commands are not run; their packages,
//! modules and tests must exist.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use import::admittance::circuit::{Branch, Equivalent};
use rayon::prelude::*;

#[path = "documented/help.rs"]
mod help;
#[path = "documented/marks.rs"]
mod marks;

/// Beginnings of commands that cannot run in a test, with the reason.
const NOT_RUN: [(&str, &str); 20] = [
    ("run \"$scene\"", "a line of a script; tests/command_line/ci.rs runs it"),
    ("link PORT", "a placeholder"),
    ("link file:", "needs the image of `cargo field`; tests/flash.rs makes the file"),
    ("link /dev/", "a board at a serial port"),
    ("link tcp:", "a board at the other end"),
    ("link sim:lock serve", "waits for a client; tests/command_line/link.rs has one"),
    ("link board:dummy-load --board-speed 8 --gdb 127.0.0.1:3333 serve", "waits for a debugger; tests/images/debugger has one"),
    ("link sim:lock script rig.txt", "the reader's own script"),
    ("compare ", "compares results of other commands of the page; tests/command_line/compare.rs has both"),
    ("export fmu", "needs the library of a unit; sim-host/embed/check builds it, and FMPy simulates the units"),
    ("merge mu-1 mu-2", "joins results of other commands of the page; tests/command_line/sweep.rs joins shards"),
    (
        "sweep lock-cold --set runs=100 --over controller.drive.amplitude_v=2:4:80",
        "half a minute each; tests/command_line/sweep.rs has shards",
    ),
    ("show NAME", "a placeholder"),
    ("run SCENE", "a placeholder"),
    ("run NAME", "a placeholder"),
    ("explain KEY", "a placeholder"),
    ("COMMAND --help", "a placeholder"),
    ("run my-scene.toml", "the reader's own scene; the scenes of the page are checked"),
    ("check my-scene.toml", "the reader's own scene"),
    ("validate ", "the reader's own suite; tests/command_line.rs has one"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Pages at the root of the repository.
const AT_THE_TOP: [&str; 2] = ["CONTRIBUTING.md", "README.md"];

/// Returns name and text of the pages at the root and in docs; the name is the path from `docs`.
fn pages() -> Vec<(String, String)> {
    let entries = ["docs", "docs/dev", "docs/evidence"].map(|folder| fs::read_dir(root().join(folder)).expect("docs"));
    let docs = entries.into_iter().flatten().map(|entry| entry.expect("a page").path());
    // A list of past changes keeps their commands and names.
    let is_page =
        |path: &PathBuf| path.extension().is_some_and(|end| end == "md") && !path.to_string_lossy().contains("/changelog-");
    let mut paths: Vec<_> = docs.filter(is_page).collect();
    paths.extend(AT_THE_TOP.map(|name| root().join(name)));
    paths.sort();
    let name = |path: &Path| {
        let page = path.strip_prefix(root().join("docs")).ok().or(path.file_name().map(Path::new)).unwrap_or(path);
        page.to_string_lossy().into_owned()
    };
    paths.iter().map(|path| (name(path), fs::read_to_string(path).expect("text"))).collect()
}

/// Returns the example lines in the help of each command, named `COMMAND --help`.
fn helps() -> Vec<(String, String)> {
    let help = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_sim-host")).args(arguments).output().expect("sim-host starts");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let examples = |name: &str| {
        let text = help(&[name, "--help"]);
        let lines: Vec<&str> = text.lines().filter(|line| line.starts_with("  sim-host ")).collect();
        assert!(!lines.is_empty(), "the help of `{name}` has no examples");
        (format!("{name} --help"), lines.join("\n"))
    };
    let text = help(&["--help"]);
    let lines = text.lines().take_while(|line| *line != "Options:").filter_map(|line| line.strip_prefix("  "));
    let found: Vec<_> =
        lines.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").map(examples).collect();
    assert!(found.len() > 10, "the commands of the help: {text}");
    found
}

/// Returns the code on a page: spans in backticks, indented or fenced lines, and comments that name
/// a command.
fn code(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in text.lines() {
        let bare = line.trim().trim_start_matches("$ ").trim_start_matches("<!-- ").trim_end_matches(" -->");
        if bare.starts_with("sim-host ") || bare.starts_with("cargo ") {
            // Two spaces separate a command from a comment or from the next column of a table.
            found.extend(bare.split("  ").next().filter(|command| command.contains(' ')).map(str::to_owned));
        } else {
            found.extend(line.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    found
}

/// Returns the arguments of all `sim-host` commands, each once, with its first page. They are in
/// the order of the pages.
fn commands() -> Vec<(String, String)> {
    let mut commands = Vec::new();
    let mut known = BTreeSet::new();
    for (page, text) in pages().into_iter().chain(helps()) {
        for line in code(&text) {
            let rest = line.strip_prefix("sim-host ").or_else(|| line.strip_prefix("cargo run --release -- "));
            let clean = |rest: &str| rest.split(" # ").next().unwrap_or(rest).trim().to_owned();
            commands
                .extend(rest.map(clean).filter(|command| known.insert(command.clone())).map(|command| (command, page.clone())));
        }
    }
    commands
}

/// Folder with the files that documented commands name; removed after the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("sim-host-{name}-{}", std::process::id()));
        fs::create_dir_all(path.join("tests/link")).expect("a folder");
        fs::copy(root().join("tests/link/dialogue.txt"), path.join("tests/link/dialogue.txt")).expect("the script");
        Folder(path)
    }

    /// Writes the measured files into the folder.
    fn measured(&self) {
        for (name, text) in measured_files() {
            fs::write(self.0.join(name), text).expect("a measured file");
        }
    }

    /// Writes the twins that the pages commission: scenes and marks of pages build on them.
    fn twins(&self) {
        let builds = |command: &str| command.starts_with("link sim:") && command.contains(" commission ");
        for (command, page) in commands().iter().filter(|(command, _)| builds(command)) {
            let (code, errors) = self.run(&shlex::split(command).unwrap_or_default());
            assert_eq!(code, 0, "{page}: {command}\n{errors}");
        }
    }

    /// Runs a command in this folder and returns its exit code and standard error.
    fn run(&self, arguments: &[String]) -> (i32, String) {
        let (code, _, errors) = self.output(arguments);
        (code, errors)
    }

    /// Runs a command in this folder and returns its exit code, standard output and standard error.
    fn output(&self, arguments: &[String]) -> (i32, String, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sim-host"));
        let command = command.args(arguments).current_dir(&self.0).stdin(Stdio::null());
        let output = command.output().expect("sim-host starts");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code().unwrap_or(-1), text(&output.stdout), text(&output.stderr))
    }

    /// Writes the scenes of the pages into the folder: one titled "my belt" as my-belt.toml.
    fn scenes(&self) {
        for (_, text) in scenes() {
            let title = text.lines().find_map(|line| line.strip_prefix("title = \"my "));
            if let Some(name) = title.and_then(|rest| rest.split('"').next()) {
                fs::write(self.0.join(format!("my-{}.toml", name.replace(' ', "-"))), text).expect("a scene");
            }
        }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Returns name and text of the measured files that the pages name.
fn measured_files() -> Vec<(&'static str, String)> {
    let branch = Branch { hz: 40e3, q: 120.0, siemens: 0.02 };
    let circuit = Equivalent { c0_f: 4e-9, loss_tangent: 0.005, branches: vec![branch] };
    // A little noise, identical in every run.
    let noise = |n: usize, k: f64| 1e-3 * (n as f64 * k).sin();
    let lines = |of: &dyn Fn(usize, f64) -> (f64, f64)| -> String {
        let line = |n: usize| {
            let hz = 39e3 + 10.0 * n as f64;
            let (a, b) = of(n, hz);
            format!("{hz},{:.9e},{:.9e}\n", a * (1.0 + noise(n, 12.9)), b + b.abs().max(1e-3) * noise(n, 78.2))
        };
        (0..201).map(line).collect()
    };
    let z = |hz: f64| circuit.admittance(hz).inv();
    let polar = |_: usize, hz: f64| (z(hz).norm_sqr().sqrt(), z(hz).im.atan2(z(hz).re).to_degrees());
    let reflection = |_: usize, hz: f64| {
        let y = 50.0 * circuit.admittance(hz);
        let s = (1.0 - y) / (1.0 + y);
        (s.re, s.im)
    };
    let in_khz = |text: String| -> String {
        let line =
            |line: &str| line.split_once(',').map(|(hz, rest)| format!("{},{rest}\n", hz.parse::<f64>().unwrap_or(0.0) / 1e3));
        text.lines().filter_map(line).collect()
    };
    let parts = "f [Hz],R [ohm],X [ohm]\n";
    let slide = |n: usize| {
        let friction = if (200..400).contains(&n) { 0.5 } else { 1.5 };
        format!("{},{:e},{}\n", n as f64 * 0.01, n as f64 * 1e-4, friction * (1.0 + 10.0 * noise(n, 12.9)))
    };
    vec![
        ("transducer.s1p", format!("# Hz S RI R 50\n{}", lines(&reflection).replace(',', " "))),
        ("table.csv", in_khz(lines(&polar))),
        ("unitless.csv", format!("Frequency,Z,phase\n{}", lines(&polar))),
        ("jig.csv", format!("{parts}{}", lines(&|_, hz| (z(hz).re + 10.02, z(hz).im)))),
        ("jig-open.csv", format!("{parts}{}", lines(&|_, hz| (1.0, -1.0 / (std::f64::consts::TAU * hz * 1e-12))))),
        ("jig-short.csv", format!("{parts}{}", lines(&|_, _| (0.02, 1e-3)))),
        (
            "speed.csv",
            format!(
                "t [ms];v [mm/s];remark\n{}",
                (0..50).map(|n| format!("{};{},5;1\n", 10 * n, 38 - n % 12)).collect::<String>()
            ),
        ),
        (
            "load-cell.csv",
            format!("t [s],F [N]\n{}", (0..32).map(|n| format!("{},1.4\n", 0.01 * f64::from(n))).collect::<String>()),
        ),
        (
            "vibration.csv",
            format!(
                "t [us],v [m/s]\n{}",
                (0..20_000).map(|n| format!("{n},{}\n", 0.05 * (f64::from(n) * 0.25).sin())).collect::<String>()
            ),
        ),
        ("pulse.csv", "time [ms],deceleration [g]\n0,0\n20,14\n60,25\n90,9\n110,0\n".to_owned()),
        ("traces.txt", {
            let trace = |name: &str, of: &dyn Fn(f64) -> f64| {
                let rows: String = (0..201)
                    .map(|n| 39e3 + 10.0 * f64::from(n))
                    .map(|hz| format!("{hz:E}\t{:E}\t0.0E+00\n", of(hz) * (1.0 + noise(hz as usize, 12.9))))
                    .collect();
                format!("\"TRACE: {name}\"\n\"Frequency\"\t\"Data Trace Real\"\t\"Data Trace Imag\"\n{rows}\n")
            };
            let angle = |hz: f64| z(hz).im.atan2(z(hz).re).to_degrees();
            format!("\"4294A\"\n{}{}", trace("A", &|hz| z(hz).norm_sqr().sqrt()), trace("B", &angle))
        }),
        (
            "trace.csv",
            format!(
                "time_s,friction_true_n\n{}",
                (0..600).map(|n| format!("{:e},{}\n", f64::from(n) * 1e-6, (f64::from(n) * 0.25).sin())).collect::<String>()
            ),
        ),
        ("log.csv", format!("t [s],x [m],F [N]\n{}", (0..600).map(slide).collect::<String>())),
        // Before the vibration.
        ("sliding.csv", format!("t [s],x [m],F [N]\n{}", (0..200).map(slide).collect::<String>())),
        ("conditions.csv", {
            // A rigid contact with a tip velocity of 0.25 m/s, and three repeats.
            let row = |n: usize| {
                let (speed, on) = ([0.02, 0.05, 0.1, 0.15, 0.2][n / 2 % 5], n % 2 == 1);
                let ratio = if on { std::f64::consts::FRAC_2_PI * (speed / 0.25_f64).asin() } else { 1.0 };
                format!("{speed},{},10,{:.4}\n", if on { "ON" } else { "OFF" }, 3.0 * ratio * (1.0 + 20.0 * noise(n, 12.9)))
            };
            format!("speed [m/s],state,normal [N],force [N]\n{}", (0..30).map(row).collect::<String>())
        }),
    ]
}

/// Runs the pages in parallel, each in its own folder.
#[test]
fn every_documented_command_works() {
    let mut pages: Vec<(String, Vec<String>)> = Vec::new();
    for (command, page) in commands() {
        if NOT_RUN.iter().any(|(start, _)| command.starts_with(start)) {
            continue;
        }
        match pages.last_mut().filter(|(last, _)| *last == page) {
            Some((_, commands)) => commands.push(command),
            None => pages.push((page, vec![command])),
        }
    }
    let wrong: Vec<String> = pages.par_iter().enumerate().flat_map_iter(|(at, page)| failing_commands(at, page)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Runs the commands of a page in their order and returns those that end wrongly.
fn failing_commands(at: usize, (page, commands): &(String, Vec<String>)) -> Vec<String> {
    let folder = Folder::new(&format!("documented-{at}"));
    folder.scenes();
    folder.measured();
    let mut wrong = Vec::new();
    for command in commands {
        let mut words = shlex::split(command).unwrap_or_else(|| panic!("{page}: {command}"));
        // A command alone, in a sentence, is only its name.
        let named = words.len() == 1 && !["list", "schema", "man"].contains(&words[0].as_str())
            || words.len() == 2 && words[0] == "import";
        if named {
            words.push("--help".into());
        }
        let shortened = shorten(&folder, &mut words);
        let (code, errors) = folder.run(&words);
        let changed = words.iter().any(|word| word == "--set");
        let missing_tool =
            code == 5 && words.iter().any(|word| word == "--pil") || errors.contains(" is not installed; install it with ");
        if missing_tool {
            let _ = writeln!(std::io::stderr(), "SKIPPED `sim-host {command}`: {errors}");
        } else if lacks(&words) {
            if code != 2 || !errors.contains("--features full") {
                wrong.push(format!("{page}: `sim-host {command}` does not name the build that supports it\n{errors}"));
            }
        } else if !(code == 0 || code == 4 && (shortened || changed)) {
            wrong.push(format!("{page}: `sim-host {command}` has the exit code {code}\n{errors}"));
        }
    }
    wrong
}

/// Returns `true` if this build lacks a part that the command needs.
fn lacks(words: &[String]) -> bool {
    let needs = |part: &str| words.iter().any(|word| word.starts_with(part) || word.split(',').any(|format| format == part));
    !cfg!(feature = "board-model") && (needs("--board") || needs("board:")) || !cfg!(feature = "pdf") && needs("pdf")
}

/// Reduces a scene of many runs to two runs and a verified advice to two draws, and suppresses
/// reports. Returns `true` if anything was reduced.
fn shorten(folder: &Folder, words: &mut Vec<String>) -> bool {
    if let Some(at) = words.iter().position(|word| word == "--verify") {
        words[at + 1] = "2".into();
        return true;
    }
    if words[0] != "run" || words.iter().any(|word| word == "--help") {
        return false;
    }
    if !words.iter().any(|word| word == "-o") {
        words.push("--no-report".into());
    }
    let shown = |key: &str| {
        let sets = words.iter().zip(&words[1..]).filter(|(flag, _)| *flag == "--set").flat_map(|(flag, set)| [flag, set]);
        let arguments = ["show".to_owned(), words[1].clone()].into_iter().chain(sets.cloned()).collect::<Vec<_>>();
        let output = Command::new(env!("CARGO_BIN_EXE_sim-host")).args(&arguments).current_dir(&folder.0).output();
        let text = String::from_utf8_lossy(&output.expect("sim-host starts").stdout).into_owned();
        text.lines().any(|line| line.starts_with(key))
    };
    let many = shown("runs = ") && !words.iter().any(|word| word == "--run");
    if many {
        words.extend(["--set".into(), "runs=2".into()]);
    }
    many
}

/// Returns the scenes printed on the pages: those with a base, and designs.
fn scenes() -> Vec<(String, String)> {
    let mut scenes = Vec::new();
    for (page, text) in pages() {
        // A block in a list is indented.
        let lines: Vec<_> = text.lines().collect();
        for begins in (0..lines.len()).filter(|&at| lines[at].trim() == "```toml") {
            let inside = lines[begins + 1..].iter().take_while(|line| line.trim() != "```");
            let block: String = inside.map(|line| format!("{}\n", line.trim_start())).collect();
            if block.lines().any(|line| line.starts_with("base = ") || line == "[design]") {
                scenes.push((page.clone(), block));
            }
        }
    }
    scenes
}

/// The commands of the first power of a board work on the simulated dummy load, or with a jumper
/// instead of it.
#[test]
fn first_power_can_be_rehearsed() {
    let folder = Folder::new("first-power");
    let rehearsed = |page: &str, port: &str| {
        let text = fs::read_to_string(root().join("docs").join(page)).expect("the page");
        let lines = code(&text).into_iter().filter_map(|line| line.strip_prefix("sim-host link /dev/ttyACM0").map(str::to_owned));
        let lines: BTreeSet<String> = lines.collect();
        assert!(!lines.is_empty(), "{page} has no command to a board");
        for line in lines {
            let words = shlex::split(&format!("link {port}{line}")).expect("words");
            let (code, errors) = folder.run(&words);
            assert_eq!(code, 0, "{page}: {words:?}\n{errors}");
        }
    };
    rehearsed("first-power.md", "sim:dummy-load");
    rehearsed("bare-nucleo.md", "sim:dummy-load --jumper");
}

#[test]
fn every_documented_scene_is_valid() {
    let folder = Folder::new("scenes");
    folder.measured();
    folder.twins();
    assert!(scenes().len() >= 2, "README prints no scenes");
    for (at, (page, text)) in scenes().into_iter().enumerate() {
        let file = format!("{at}.toml");
        fs::write(folder.0.join(&file), &text).expect("a scene");
        let (code, errors) = folder.run(&["check".into(), file]);
        assert_eq!(code, 0, "{page}:\n{text}\n{errors}");
    }
}

/// Checks programs of the workspace that are run by `-p`: the package and the bench exist.
#[test]
fn every_documented_program_exists() {
    let benches = include_str!("../evidence/src/bench.rs").split_whitespace().collect::<String>();
    let mut checked = 0;
    for (page, text) in pages() {
        for line in code(&text).iter().filter_map(|line| line.strip_prefix("cargo run --release -p sonoglide-evidence -- ")) {
            let mut words = line.split_whitespace().filter(|word| *word != "show");
            let name = words.next().filter(|name| !name.starts_with("--"));
            let is_there = |name: &str| name == "NAME" || benches.contains(&format!("bench(\"{name}\","));
            assert!(name.is_none_or(is_there), "{page}: there is no bench {name:?}");
            checked += 1;
        }
    }
    assert!(checked > 20, "{checked} commands");
}

#[test]
fn every_excluded_command_is_documented() {
    for (start, why) in NOT_RUN {
        assert!(commands().iter().any(|(command, _)| command.starts_with(start)), "no page has `sim-host {start}` ({why})");
    }
}

/// Appends the text of all Rust sources in a folder.
fn sources(folder: &Path, into: &mut String) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && !path.ends_with("target") {
            sources(&path, into);
        } else if path.extension().is_some_and(|end| end == "rs") {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            into.push_str(&format!("mod {stem}\n{}", fs::read_to_string(&path).expect("text")));
        }
    }
}

#[test]
fn every_documented_test_exists() {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).expect("a manifest");
    let members = manifest.lines().find(|line| line.starts_with("members = ")).expect("the members");
    let folders: Vec<String> = members.split('"').skip(1).step_by(2).map(str::to_owned).collect();
    let named = |folder: &&String, package: &str| {
        let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).expect("a manifest");
        manifest.contains(&format!("name = \"{package}\""))
    };
    let mut checked = 0;
    for (page, text) in pages() {
        for line in code(&text).iter().filter(|line| line.starts_with("cargo test -p ")) {
            let words = shlex::split(line).unwrap_or_else(|| panic!("{page}: {line}"));
            let package = &words[3];
            let folder = folders.iter().find(|folder| named(folder, package));
            let folder = folder.unwrap_or_else(|| panic!("{page}: there is no package `{package}`"));
            let mut text = String::new();
            sources(&root().join(folder), &mut text);
            let mut filters = words[4..].iter().take_while(|word| *word != "--").filter(|word| !word.starts_with("--"));
            let Some(filter) = filters.next().filter(|_| !line.contains("--target")) else { continue };
            for part in filter.split("::").filter(|part| !part.is_empty()) {
                let there = text.lines().any(|line| {
                    let line = line.trim_start().trim_start_matches("pub ");
                    let item = line.strip_prefix("mod ").or_else(|| line.strip_prefix("fn "));
                    item.is_some_and(|name| name.contains(part))
                });
                assert!(there, "{page}: `{line}` finds nothing: no module or test contains `{part}` in its name");
            }
            checked += 1;
        }
    }
    assert!(checked > 10, "{checked} commands");
}

/// Checks that the files on a page exist. Paths are relative to the root or to the page's folder.
#[test]
fn every_documented_file_exists() {
    for (page, text) in pages() {
        let docs = if AT_THE_TOP.contains(&page.as_str()) { root() } else { root().join("docs") };
        let path = docs.join(&page);
        let folder = path.parent().expect("a folder");
        let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        for link in links.filter(|link| !link.is_empty() && !link.contains(':') && !link.contains(' ')) {
            assert!(folder.join(link).exists(), "{page}: there is no {link}");
        }
        let paths = text.lines().flat_map(|line| line.split('`').skip(1).step_by(2));
        let rooted = ["firmware/", "hal-mock/", "sim-host/", "tests/"];
        for path in paths.filter(|path| rooted.iter().any(|root| path.starts_with(root)) && !path.contains([' ', '{', '*', '<']))
        {
            assert!(root().join(path).exists(), "{page}: there is no {path}");
        }
    }
}
