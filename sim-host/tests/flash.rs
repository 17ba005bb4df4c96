//! Aliases of `.cargo/config.toml` with a `probe-rs` that only records its arguments, and commands
//! of the pages on flashing and updating.
#![cfg(unix)]

use std::fs;
use std::io::Write as _;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");
/// Pages whose `cargo` commands must be aliases.
const PAGES: [&str; 2] = ["first-power.md", "dev/update.md"];

/// Returns the target folder of the Thumb images, which other tests fill too.
fn target() -> PathBuf {
    let folder = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| Path::new(ROOT).join("target"), PathBuf::from);
    folder.join("pil")
}

/// Makes a temporary folder with a `probe-rs` that appends its arguments to the file `flashed`, and
/// succeeds.
fn folder_with_probe(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("sonoglide-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    let probe = folder.join("probe-rs");
    fs::write(&probe, format!("#!/bin/sh\necho \"$@\" >> '{}'\n", folder.join("flashed").display())).expect("a script");
    fs::set_permissions(&probe, fs::Permissions::from_mode(0o755)).expect("it can be run");
    folder
}

fn cargo(folder: &Path, arguments: &[&str]) -> Output {
    let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap_or_default());
    let mut command = Command::new(env!("CARGO"));
    command.args(arguments).current_dir(ROOT).env("PATH", path).env("CARGO_TARGET_DIR", target());
    command.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS").output().expect("cargo starts")
}

fn aliases() -> Vec<String> {
    let text = fs::read_to_string(Path::new(ROOT).join(".cargo/config.toml")).expect("the configuration");
    let (_, section) = text.split_once("[alias]").expect("aliases");
    let lines = section.lines().take_while(|line| !line.starts_with('['));
    lines.filter_map(|line| line.split_once(" = [").map(|(name, _)| name.to_owned())).collect()
}

#[test]
fn every_alias_works_and_documented_ones_exist() {
    if let Some(missing) = pil::missing_to_build() {
        let _ = writeln!(std::io::stderr(), "SKIPPED: {missing}");
        return;
    }
    let folder = folder_with_probe("aliases");
    let aliases = aliases();
    for alias in &aliases {
        let output = cargo(&folder, &[alias]);
        assert!(output.status.success(), "cargo {alias}: {}", String::from_utf8_lossy(&output.stderr));
    }
    let flashed = fs::read_to_string(folder.join("flashed")).expect("something was flashed");
    for (chip, image) in [("STM32G474RETx", "/nucleo-g474re"), ("STM32G474RETx", "/on_target-")] {
        assert!(flashed.lines().any(|line| line.contains(chip) && line.contains(image)), "{image}: {flashed}");
    }
    for page in PAGES {
        let text = fs::read_to_string(Path::new(ROOT).join("docs").join(page)).expect("a page");
        for rest in text.split("cargo ").skip(1) {
            let verb = rest.split(|c: char| !c.is_ascii_lowercase() && c != '-').next().unwrap_or_default();
            let known = ["install", "run", "test"].contains(&verb) || aliases.iter().any(|alias| alias == verb);
            assert!(known, "docs/{page}: there is no `cargo {verb}`");
        }
    }
    // The page's command makes the update file from the image that `cargo field` has just built.
    std::os::unix::fs::symlink(target(), folder.join("target")).expect("a link");
    let page = fs::read_to_string(Path::new(ROOT).join("docs/dev/update.md")).expect("the page");
    let command = page.lines().find_map(|line| line.strip_prefix("    sim-host link file:")).expect("the command");
    fs::write(folder.join("my.key"), "01".repeat(32)).expect("a key");
    let words = shlex::split(&format!("link file:{command}")).expect("words");
    let made = Command::new(env!("CARGO_BIN_EXE_sim-host")).args(words).current_dir(&folder).output().expect("sim-host starts");
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    assert!(fs::metadata(folder.join("my-firmware.update")).expect("a file").len() > 100_000);
    fs::remove_dir_all(&folder).expect("the folder is removed");
}
