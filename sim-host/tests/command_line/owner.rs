//! A command replaces only files that the same command wrote, unless they were edited or are its
//! inputs.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use super::folder::{listed, manifest, names};
use super::{Folder, code, stderr};

/// Every command that writes a folder, without `-o`; each is fast.
const WRITERS: [&str; 11] = [
    "run contact-kinematic",
    "sweep contact-kinematic --over contact.dahl.mu=0.1,0.3 --metric friction_ratio",
    "merge part",
    "import admittance mine.csv",
    "import friction log.csv --normal-n 5 --on 2:4 --frequency-hz 40e3",
    "compare a b",
    "spectrum log.csv --column 3",
    "validate suite.toml",
    "link sim:lock scan",
    "link sim:lock capture --trigger now",
    "link sim:lock commission --band 30k:45k --max-volts 3",
];
const SUITE: &str = "title = \"one case\"\nscene = \"contact-kinematic\"\n\n[[case]]\nname = \"a\"\n\n[[target]]\nmetric = \"friction_ratio\"\nmax = 1\nsource = \"-\"\n";

/// Runs a command in a folder.
fn at(folder: &Folder, line: &str) -> Output {
    let words = line.split(' ');
    Command::new(env!("CARGO_BIN_EXE_sim-host")).args(words).current_dir(&folder.0).output().expect("sim-host starts")
}

/// Runs a command in a folder and returns its standard error.
fn done(folder: &Folder, line: &str) -> String {
    let output = at(folder, line);
    assert!([0, 4].contains(&code(&output)), "{line}: {}", stderr(&output));
    stderr(&output)
}

/// Makes a folder with measured files, a suite, runs and a part of a sweep.
fn prepared(name: &str) -> Folder {
    let folder = Folder::new(name);
    let admittance = |n: usize| {
        let hz = 39e3 + 10.0 * n as f64;
        let (w, noise) = (std::f64::consts::TAU * hz, 1.0 + 1e-3 * ((n * n) as f64).sin());
        let (r, x) = (50.0, w * 0.02 - (std::f64::consts::TAU * 40e3).powi(2) * 0.02 / w);
        let size = r * r + x * x;
        format!("{hz},{},{}\n", noise * r / size, w * 4e-9 - noise * x / size)
    };
    let slide = |n: usize| {
        let friction = if (200..400).contains(&n) { 0.5 } else { 1.5 };
        format!("{},{:e},{}\n", n as f64 * 0.01, n as f64 * 1e-4, friction * (1.0 + 0.01 * (12.9 * n as f64).sin()))
    };
    folder.write("mine.csv", &format!("f [Hz],G [S],B [S]\n{}", (0..201).map(admittance).collect::<String>()));
    folder.write("log.csv", &format!("t [s],x [m],F [N]\n{}", (0..600).map(slide).collect::<String>()));
    folder.write("suite.toml", SUITE);
    for line in ["run contact-kinematic -q -o a", "run contact-kinematic -q -o b", &format!("{} -q -o part", WRITERS[1])] {
        done(&folder, line);
    }
    folder
}

fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    names(folder).into_iter().map(|name| (name.clone(), std::fs::read(folder.join(name)).unwrap_or_default())).collect()
}

/// Runs every command into the result of every command, unchanged and with one edited file.
#[test]
fn no_command_removes_a_file_that_it_did_not_write() {
    let folder = prepared("pairs");
    let (target, mut cases) = (folder.0.join("target"), 0);
    for (first, line) in WRITERS.iter().enumerate() {
        done(&folder, &format!("{line} -o {first}"));
    }
    for (first, writer) in WRITERS.iter().enumerate() {
        let left = folder.0.join(first.to_string());
        let (files, command) = (listed(&left), manifest(&left)["command"].clone());
        for (second, line) in WRITERS.iter().enumerate() {
            for edited in [None, files.iter().cycle().nth(cases)] {
                let _ = std::fs::remove_dir_all(&target);
                std::fs::create_dir(&target).expect("a folder");
                let name = |name: &String| std::fs::copy(left.join(name), target.join(name)).map(drop);
                names(&left).iter().try_for_each(name).expect("a copy");
                folder.write("target/notes.txt", "mine");
                if let Some(file) = edited {
                    let bytes = [std::fs::read(target.join(file)).expect("a file"), b"\n".to_vec()].concat();
                    std::fs::write(target.join(file), bytes).expect("a file");
                }
                let (before, output) = (contents(&target), at(&folder, &format!("{line} -o target")));
                let (after, context) = (contents(&target), format!("{writer} | {line} | {edited:?}: {}", stderr(&output)));
                if edited.is_none() && manifest(&folder.0.join(second.to_string()))["command"] == command {
                    assert!([0, 4].contains(&code(&output)), "{context}");
                    assert!(after.keys().eq(before.keys()) || line.starts_with("sweep"), "{context}");
                    assert_eq!(after["notes.txt"], b"mine", "{context}");
                } else {
                    assert!(code(&output) == 2 && after == before, "{context}");
                    assert!(stderr(&output).contains("choose another folder with -o"), "{context}");
                }
                cases += 1;
            }
        }
    }
    assert_eq!(cases, 2 * WRITERS.len() * WRITERS.len());
}

#[test]
fn a_scene_survives_its_own_run() {
    let folder = prepared("survives");
    for (import, scene) in [(WRITERS[3], "out/mine/mine.toml"), (WRITERS[4], "out/log/log.toml")] {
        let said = done(&folder, import);
        assert!(said.contains(&format!("run it with `sim-host run {scene}`")), "{said}");
        let (dir, edited) = (folder.0.join(scene), format!("{}# my edit\n", folder.read(scene)));
        let dir = dir.parent().expect("a folder");
        for text in [folder.read(scene), edited.clone()] {
            folder.write(scene, &text);
            let before = contents(dir);
            // The second run replaces the first.
            for _ in 0..2 {
                let said = done(&folder, &format!("run {scene}"));
                let run_folder = format!("{}-run", dir.file_name().expect("a name").display());
                assert!(said.contains("note: ") && said.contains(&format!("`out/{run_folder}`")), "{said}");
                assert_eq!(contents(dir), before);
                let run = folder.0.join("out").join(run_folder);
                assert_eq!(names(&run), listed(&run));
            }
        }
        // A repeated import does not replace the edited scene either.
        let said = done(&folder, import);
        assert!(said.contains("was changed after it was written") && folder.read(scene) == edited, "{said}");
    }
    assert_eq!(names(&folder.0.join("out")).len(), 6);
}

#[test]
fn a_run_does_not_replace_what_it_reads() {
    let folder = prepared("reads");
    folder.write("base.toml", "base = \"contact-kinematic\"\n");
    done(&folder, "run base.toml -q");
    let own = folder.0.join("out/base");
    let figure = names(&own).into_iter().find(|name| name.starts_with("friction") && name.ends_with(".csv")).expect("a figure");
    folder.write(
        "base.toml",
        &format!("base = \"contact-kinematic\"\n[[overlay]]\nquantity = \"friction_n\"\nfile = \"out/base/{figure}\"\nx_column = \"time_periods_of_the_excitation\"\nx_unit = \"s\"\n"),
    );
    folder.write("over.toml", "base = \"base.toml\"\n");
    let before = contents(&own);
    for source in ["base.toml", "over.toml", "out/base/manifest.json"] {
        let output = at(&folder, &format!("run {source} -o out/base"));
        assert!(code(&output) == 2 && stderr(&output).contains("is an input of this command"), "{source}: {}", stderr(&output));
        assert!(contents(&own) == before, "{source}");
    }
}

/// Checks scene names that would lead out of `out`.
#[test]
fn no_scene_name_escapes_the_default_folder() {
    let folder = Folder::new("names");
    folder.write("...toml", "base = \"contact-kinematic\"\n");
    done(&folder, "run ...toml");
    assert_eq!(names(&folder.0.join("out")), ["unnamed".to_owned()].into());
    let moved = folder.read("out/unnamed/manifest.json").replace("\"scene\": \"..\"", "\"scene\": \"../../elsewhere\"");
    folder.write("moved.json", &moved);
    let refused = at(&folder, "run moved.json");
    assert!(code(&refused) == 3 && stderr(&refused).contains("delete `checksums` in it"), "{}", stderr(&refused));
    let moved = moved.replace("\"checksums\"", "\"former_checksums\"");
    folder.write("moved.json", &moved);
    done(&folder, "run moved.json");
    assert_eq!(names(&folder.0), ["...toml", "moved.json", "out"].map(String::from).into());
}
