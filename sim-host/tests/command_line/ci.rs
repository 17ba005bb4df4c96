//! Scenes in CI: the script of docs/ci.md, and the JUnit files that it writes.
#![cfg(unix)]

use std::path::Path;
use std::process::Command;

use super::Folder;

const PAGE: &str = include_str!("../../../docs/ci.md");

/// Runs the script of the page in a folder with these scenes and returns its exit code.
fn run(folder: &Folder, scenes: &[(&str, &str)]) -> i32 {
    std::fs::create_dir_all(Path::new(folder.text()).join("scenes")).expect("a folder");
    for (name, text) in scenes {
        folder.write(&format!("scenes/{name}.toml"), text);
    }
    let script = PAGE.split("```sh\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a script");
    let program = Path::new(env!("CARGO_BIN_EXE_sim-host")).parent().expect("a folder").display();
    let path = format!("{program}:{}", std::env::var("PATH").unwrap_or_default());
    let mut command = Command::new("sh");
    let output = command.args(["-c", script]).env("PATH", path).current_dir(folder.text()).output().expect("sh");
    output.status.code().expect("an exit code")
}

#[test]
fn scenes_that_miss_an_expectation_fail_and_name_it() {
    let folder = Folder::new("ci");
    let expect = |most: f64| {
        format!("base = \"contact-kinematic\"\ntitle = \"a < b\"\n[[expect]]\nmetric = \"friction_ratio\"\nmax = {most}\n")
    };
    assert_eq!(run(&folder, &[("good", &expect(0.9))]), 0);
    assert_eq!(run(&folder, &[("bad", &expect(0.1).replace("max", "source = \"a paper\"\nmax"))]), 1);
    let (good, bad) = (folder.read("junit/good.xml"), folder.read("junit/bad.xml"));
    assert!(good.contains("failures=\"0\"") && good.contains("name=\"friction_ratio: at most 0.9\""), "{good}");
    assert!(bad.contains("failures=\"1\"") && bad.contains(", expected at most 0.1 (a paper)"), "{bad}");
    assert!(Path::new(folder.text()).join("out/bad/report.html").exists());
}
