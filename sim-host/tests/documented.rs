//! Every command that README, docs and help print is run, and every scene in them is checked: what a reader copies works.
//!
//! Scenes of many runs are shortened to two, so their expectations may be missed (exit code 4); of single runs they may not, unless the page
//! changes values. Measured files that the pages name are made of a circuit and of a contact. Commands of `cargo test` are not run again: their packages, modules and tests have to be there.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use import::admittance::circuit::{Branch, Equivalent};
use rayon::prelude::*;

/// Commands that need what a test has not, by how they begin, and why they are not run.
const NOT_RUN: [(&str, &str); 20] = [
    ("run \"$scene\"", "a line of a script; tests/command_line/ci.rs runs it"),
    ("link PORT", "a placeholder"),
    ("link file:", "needs the image of `cargo field`; tests/flash.rs makes the file"),
    ("link /dev/", "a board at a serial port"),
    ("link tcp:", "a board at the other end"),
    ("link sim:lock serve", "waits for a client; tests/command_line/link.rs has one"),
    ("link board:dummy-load --board-speed 8 --gdb 127.0.0.1:3333 serve", "waits for a debugger; tests/images/debugger has one"),
    ("link sim:lock script rig.txt", "the reader's own script"),
    ("compare ", "compares what other commands of the page have left; tests/command_line/compare.rs has both"),
    ("merge mu-1 mu-2", "joins what other commands of the page have left; tests/command_line/sweep.rs joins shards"),
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
    ("advise --frequency-hz F", "placeholders"),
    ("validate ", "the reader's own suite; tests/command_line.rs has one"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Pages that readers find at the top of the repository.
const AT_THE_TOP: [&str; 2] = ["CONTRIBUTING.md", "README.md"];

/// Returns name and text of the pages at the top and of docs; the name is the path from `docs`.
fn pages() -> Vec<(String, String)> {
    let entries = ["docs", "docs/evidence"].map(|folder| fs::read_dir(root().join(folder)).expect("docs"));
    let docs = entries.into_iter().flatten().map(|entry| entry.expect("a page").path());
    let mut paths: Vec<_> = docs.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    paths.extend(AT_THE_TOP.map(|name| root().join(name)));
    paths.sort();
    let name = |path: &Path| {
        let page = path.strip_prefix(root().join("docs")).ok().or(path.file_name().map(Path::new)).unwrap_or(path);
        page.to_string_lossy().into_owned()
    };
    paths.iter().map(|path| (name(path), fs::read_to_string(path).expect("text"))).collect()
}

/// The examples in the help of each command: `--help` of it, and these lines.
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

/// What stands as code on a page: spans between backticks within a line, indented or fenced lines, and comments that name a command.
fn code(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in text.lines() {
        let bare = line.trim().trim_start_matches("$ ").trim_start_matches("<!-- ").trim_end_matches(" -->");
        if bare.starts_with("sim-host ") || bare.starts_with("cargo ") {
            // What stands behind two spaces or more is a comment, or the next column of a table.
            found.extend(bare.split("  ").next().filter(|command| command.contains(' ')).map(str::to_owned));
        } else {
            found.extend(line.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    found
}

/// The arguments of all `sim-host` commands, each once, with the page that it stands on first; in the order of the pages, as a reader types them.
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

/// A folder that goes with the test, with the files that documented commands name.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("sim-host-{name}-{}", std::process::id()));
        fs::create_dir_all(path.join("tests/link")).expect("a folder");
        fs::copy(root().join("tests/link/dialogue.txt"), path.join("tests/link/dialogue.txt")).expect("the script");
        Folder(path)
    }

    /// Puts the measured files into the folder.
    fn measured(&self) {
        for (name, text) in measured_files() {
            fs::write(self.0.join(name), text).expect("a measured file");
        }
    }

    /// Exit code and standard error of a command in this folder.
    fn run(&self, arguments: &[String]) -> (i32, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sim-host"));
        let command = command.args(arguments).current_dir(&self.0).stdin(Stdio::null());
        let output = command.output().expect("sim-host starts");
        (output.status.code().unwrap_or(-1), String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The measured files that the pages name, as a reader would have them: name and text.
fn measured_files() -> Vec<(&'static str, String)> {
    let branch = Branch { hz: 40e3, q: 120.0, siemens: 0.02 };
    let circuit = Equivalent { c0_f: 4e-9, loss_tangent: 0.005, branches: vec![branch] };
    // A little noise, the same in every run.
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
                "time_s,friction_n\n{}",
                (0..600).map(|n| format!("{:e},{}\n", f64::from(n) * 1e-6, (f64::from(n) * 0.25).sin())).collect::<String>()
            ),
        ),
        ("log.csv", format!("t [s],x [m],F [N]\n{}", (0..600).map(slide).collect::<String>())),
    ]
}

/// Page by page, each in a folder of its own.
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
    let wrong: Vec<String> = pages.par_iter().enumerate().flat_map_iter(|(at, page)| wrong_of(at, page)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The commands of a page that do not end as they should, run in their order.
fn wrong_of(at: usize, (page, commands): &(String, Vec<String>)) -> Vec<String> {
    let folder = Folder::new(&format!("documented-{at}"));
    // A scene that a page calls "my belt" is run as my-belt.toml.
    for (_, text) in scenes() {
        let title = text.lines().find_map(|line| line.strip_prefix("title = \"my "));
        if let Some(name) = title.and_then(|rest| rest.split('"').next()) {
            fs::write(folder.0.join(format!("my-{}.toml", name.replace(' ', "-"))), text).expect("a scene");
        }
    }
    folder.measured();
    let mut wrong = Vec::new();
    for command in commands {
        let mut words = shlex::split(command).unwrap_or_else(|| panic!("{page}: {command}"));
        // A verb alone, in a sentence, is its name.
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
                wrong.push(format!("{page}: `sim-host {command}` does not name the build that has it\n{errors}"));
            }
        } else if !(code == 0 || code == 4 && (shortened || changed)) {
            wrong.push(format!("{page}: `sim-host {command}` ends with {code}\n{errors}"));
        }
    }
    wrong
}

/// Returns `true` if this build lacks a part that the command needs.
fn lacks(words: &[String]) -> bool {
    let needs = |part: &str| words.iter().any(|word| word.starts_with(part) || word.split(',').any(|format| format == part));
    !cfg!(feature = "board-model") && (needs("--board") || needs("board:")) || !cfg!(feature = "pdf") && needs("pdf")
}

/// Makes a scene of many runs one of two, a verified advice one of two draws, and keeps pictures out; whether anything was shortened.
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

/// The scenes printed on the pages: those with a base or a controller of their own.
fn scenes() -> Vec<(String, String)> {
    let mut scenes = Vec::new();
    for (page, text) in pages() {
        // A block in a list is indented.
        let lines: Vec<_> = text.lines().collect();
        for begins in (0..lines.len()).filter(|&at| lines[at].trim() == "```toml") {
            let inside = lines[begins + 1..].iter().take_while(|line| line.trim() != "```");
            let block: String = inside.map(|line| format!("{}\n", line.trim_start())).collect();
            if block.lines().any(|line| line.starts_with("base = ")) {
                scenes.push((page.clone(), block));
            }
        }
    }
    scenes
}

#[test]
fn every_documented_scene_is_valid() {
    let folder = Folder::new("scenes");
    folder.measured();
    // A scene of a page may lie over the twin that a command before it has left.
    for (command, page) in
        commands().iter().filter(|(command, _)| command.starts_with("link sim:") && command.contains(" commission "))
    {
        let (code, errors) = folder.run(&shlex::split(command).unwrap_or_default());
        assert_eq!(code, 0, "{page}: {command}\n{errors}");
    }
    assert!(scenes().len() >= 2, "README prints scenes");
    for (at, (page, text)) in scenes().into_iter().enumerate() {
        let file = format!("{at}.toml");
        fs::write(folder.0.join(&file), &text).expect("a scene");
        let (code, errors) = folder.run(&["check".into(), file]);
        assert_eq!(code, 0, "{page}:\n{text}\n{errors}");
    }
}

/// Programs of the workspace that are run by `-p`: the package is a member, and the bench is one of its own.
#[test]
fn every_documented_program_is_there() {
    let benches = include_str!("../evidence/src/bench.rs");
    let mut checked = 0;
    for (page, text) in pages() {
        for line in code(&text).iter().filter_map(|line| line.strip_prefix("cargo run --release -p sonoglide-evidence -- ")) {
            let mut words = line.split_whitespace().filter(|word| *word != "show");
            let name = words.next().filter(|name| !name.starts_with("--"));
            let is_there = |name: &str| name == "NAME" || benches.contains(&format!("name: \"{name}\""));
            assert!(name.is_none_or(is_there), "{page}: there is no bench {name:?}");
            checked += 1;
        }
    }
    assert!(checked > 20, "{checked} commands");
}

#[test]
fn nothing_is_left_out_that_is_not_documented() {
    for (start, why) in NOT_RUN {
        assert!(commands().iter().any(|(command, _)| command.starts_with(start)), "no page has `sim-host {start}` ({why})");
    }
}

/// The text of all Rust sources under a folder.
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
fn every_documented_test_is_there() {
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
                assert!(there, "{page}: `{line}` finds nothing: no module or test has `{part}` in its name");
            }
            checked += 1;
        }
    }
    assert!(checked > 10, "{checked} commands");
}

/// A path in a page is of the repository, from its root or from the page's folder; the name of a file alone is one of its sources.
#[test]
fn every_documented_file_is_there() {
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

/// Returns the generated blocks of a page, or all of its text if it has none.
fn generated(text: &str) -> String {
    let blocks = text.split("<!-- begin: ").skip(1).map(|rest| rest.split("<!-- end -->").next().unwrap_or(rest));
    let blocks = blocks.collect::<Vec<_>>().join("\n");
    if blocks.is_empty() { text.to_owned() } else { blocks }
}

/// Reads the numbers of a text without signs, each with half a unit of its last digit. Joins thousands; skips names such as `C0`.
fn numbers(text: &str) -> Vec<(f64, f64)> {
    let text: Vec<char> = text.chars().collect();
    let is_digit = |at: usize| text.get(at).is_some_and(char::is_ascii_digit);
    let is_joint = |at: usize| {
        text[at].is_whitespace() && at > 0 && is_digit(at - 1) && (1..=3).all(|n| is_digit(at + n)) && !is_digit(at + 4)
    };
    let joined: String = (0..text.len()).filter(|&at| !is_joint(at)).map(|at| text[at]).collect();
    let number = |word: &str| {
        let word = word.trim_matches(['.', '-']);
        let (mantissa, exponent) = word.split_once('e').unwrap_or((word, "0"));
        let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let half = 0.5 * 10f64.powi(exponent.parse::<i32>().ok()? - decimals as i32);
        let value = word.parse::<f64>().ok()?;
        word.starts_with(|first: char| first.is_ascii_digit()).then_some((value, half))
    };
    joined.split(|c: char| !(c.is_alphanumeric() || "_.-".contains(c))).filter_map(number).collect()
}

#[test]
fn numbers_are_read_with_their_rounding() {
    let read = numbers("27 of 61 200, C0 2.5 at Q 65.");
    assert_eq!(read, [(27.0, 0.5), (61_200.0, 0.5), (2.5, 0.05), (65.0, 0.5)]);
}

/// Checks numbers in prose between `<!-- from: PAGE: TEXT -->` and `<!-- /from -->`: each occurs, rounded, in a line of the page's generated
/// blocks that contains TEXT when the bars between its cells are left out.
#[test]
fn marked_numbers_are_those_of_their_page() {
    let pages = pages();
    let mut checked = 0;
    for (page, text) in &pages {
        for marked in text.split("<!-- from: ").skip(1) {
            let parts = marked.split_once(" -->").and_then(|(from, rest)| {
                let (source, row) = from.split_once(": ")?;
                Some((source, row, rest.split_once("<!-- /from -->")?.0))
            });
            let (source, row, claim) = parts.unwrap_or_else(|| panic!("{page}: incomplete mark `{marked:.60}`"));
            let table = pages.iter().find(|(name, _)| name == source).map(|(_, text)| generated(text));
            let table = table.unwrap_or_else(|| panic!("{page}: there is no page {source}"));
            let cells = |line: &str| line.replace('|', " ").split_whitespace().collect::<Vec<_>>().join(" ");
            let found: Vec<_> = table.lines().filter(|line| cells(line).contains(row)).flat_map(numbers).collect();
            let claimed = numbers(claim);
            assert!(!claimed.is_empty(), "{page}: `{claim}` has no number");
            for (value, half) in claimed {
                let there = found.iter().any(|(found, _)| (found - value).abs() <= half * (1.0 + 1e-9));
                assert!(there, "{page}: `{claim}` differs from {source}: no line with `{row}` contains {value}");
                checked += 1;
            }
        }
    }
    assert!(checked > 50, "{checked} numbers");
}
