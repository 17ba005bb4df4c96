//! Building the image, and checking the requirements for it.

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use super::PilError;
use super::machine::PROGRAM;

/// Environment variable that names a ready image, which is then used instead of building one.
pub const IMAGE_VARIABLE: &str = "SONOGLIDE_PIL_IMAGE";

const TARGET: &str = "thumbv7em-none-eabihf";
/// Target of the image for a Cortex-M33.
const CORTEX_M33_TARGET: &str = "thumbv8m.main-none-eabihf";
/// Package of the emulated images.
const QEMU_PACKAGE: &str = "sonoglide-qemu-m4";
const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Environment variables that the caller sets for host code; they must affect neither the image nor
/// its directory.
const NOT_INHERITED: [&str; 4] = ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_RUSTFLAGS", "CARGO_BUILD_TARGET"];

/// Returns the reason why the processor in the loop is not available here, and the packages to
/// install. `None`: nothing is missing.
pub fn missing() -> Option<String> {
    if !cfg!(target_os = "linux") {
        return Some("the processor in the loop needs Linux, as QEMU uses inherited pipes".into());
    }
    let path = env::var_os("PATH").unwrap_or_default();
    if !env::split_paths(&path).any(|folder| folder.join(PROGRAM).is_file()) {
        return Some(
            "there is no `qemu-system-arm` on the PATH; install QEMU for Arm systems (Debian: `apt install qemu-system-arm`)"
                .into(),
        );
    }
    if env::var_os(IMAGE_VARIABLE).is_some() {
        return None;
    }
    missing_to_build()
}

/// Returns the reason why no image can be built here, and the packages to install. `None`: nothing
/// is missing.
pub fn missing_to_build() -> Option<String> {
    if !Path::new(WORKSPACE).join("firmware/boards/qemu-m4").is_dir() {
        return Some(format!(
            "the source of the image is not here; run in a checkout of Sonoglide (`cargo run --release --`), or name a built image \
             (--board=ELF, {IMAGE_VARIABLE})"
        ));
    }
    missing_target(TARGET)
}

/// Returns the reason why nothing can be built for a target here; `None`: its core library is
/// installed.
fn missing_target(target: &str) -> Option<String> {
    let missing = || format!("the core library for {target} is not installed; install it with `rustup target add {target}`");
    (!has_core_library(target)).then(missing)
}

/// Returns the image to run: the one named by [`IMAGE_VARIABLE`], otherwise one built from the
/// present source.
///
/// It is built in a separate target directory, so that it waits for no other build. If the source
/// has changed since this program was built, the two differ.
pub fn image() -> Result<PathBuf, PilError> {
    if let Some(reason) = missing() {
        return Err(PilError::Missing(reason));
    }
    if let Some(ready) = env::var_os(IMAGE_VARIABLE) {
        let ready = PathBuf::from(ready);
        return match ready.is_file() {
            true => Ok(ready),
            false => Err(PilError::Missing(format!("{IMAGE_VARIABLE} names {}, which does not exist", ready.display()))),
        };
    }
    build(QEMU_PACKAGE, "qemu-m4")
}

/// Returns the reason why no image for a Cortex-M33 can be built or run here. `None`: nothing is
/// missing.
pub fn missing_to_build_cortex_m33() -> Option<String> {
    missing().or_else(|| missing_target(CORTEX_M33_TARGET))
}

/// Builds the image for a Cortex-M33, with the same source as [`image`].
pub fn cortex_m33_image() -> Result<PathBuf, PilError> {
    if let Some(reason) = missing_to_build_cortex_m33() {
        return Err(PilError::Missing(reason));
    }
    let (folder, _) = cargo("pil", CORTEX_M33_TARGET, &["-p", QEMU_PACKAGE, "--bin", "qemu-m4"])?;
    Ok(folder.join(CORTEX_M33_TARGET).join("pil/qemu-m4"))
}

/// Builds the image that counts the instructions of kernels from the present source.
pub fn counting_image() -> Result<PathBuf, PilError> {
    match missing() {
        Some(reason) => Err(PilError::Missing(reason)),
        None => build("sonoglide-counts", "counts"),
    }
}

/// Builds the image of a whole board, with its link, from the present source.
pub fn link_image() -> Result<PathBuf, PilError> {
    match missing() {
        Some(reason) => Err(PilError::Missing(reason)),
        None => build(QEMU_PACKAGE, "link"),
    }
}

/// Builds the image of the tests that run on the target from the present source.
pub fn test_image() -> Result<PathBuf, PilError> {
    if let Some(reason) = missing() {
        return Err(PilError::Missing(reason));
    }
    // Only cargo knows the name of a test's file.
    let (_, messages) =
        cargo("pil", TARGET, &["-p", "on-target", "--test", "on_target", "--message-format", "json-render-diagnostics"])?;
    let artifact = |line: &str| {
        let message: Value = serde_json::from_str(line).ok()?;
        (message["target"]["name"] == "on_target").then(|| message["executable"].as_str().map(PathBuf::from))?
    };
    messages.lines().find_map(artifact).ok_or_else(|| PilError::Build("cargo reports no file for the tests".into()))
}

/// Builds the image that is flashed, as by `cargo fw`, from the present source.
pub fn board_image() -> Result<PathBuf, PilError> {
    if let Some(reason) = missing_to_build() {
        return Err(PilError::Missing(reason));
    }
    let (folder, _) = cargo("board", TARGET, &["-p", "sonoglide-nucleo-g474re"])?;
    Ok(folder.join(TARGET).join("board/nucleo-g474re"))
}

/// Builds the first stage and the image for the slot after it, as by `cargo first-stage` and
/// `cargo field`, from the present source.
pub fn field_images() -> Result<[PathBuf; 2], PilError> {
    if let Some(reason) = missing_to_build() {
        return Err(PilError::Missing(reason));
    }
    // The first stage has a separate profile: it must be small, and the image fast.
    let build = |image: &str, profile: &str| -> Result<PathBuf, PilError> {
        let (folder, _) = cargo(profile, TARGET, &["-p", "sonoglide-nucleo-g474re", "--features", "slot", "--bin", image])?;
        Ok(folder.join(TARGET).join(profile).join(image))
    };
    Ok([build("first-stage", "first-stage")?, build("nucleo-g474re", "field")?])
}

/// Builds one image of a package.
fn build(package: &str, image: &str) -> Result<PathBuf, PilError> {
    let (folder, _) = cargo("pil", TARGET, &["-p", package, "--bin", image])?;
    Ok(folder.join(TARGET).join("pil").join(image))
}

/// Builds something for a target in a profile. Returns the target directory, and the output of
/// cargo.
fn cargo(profile: &str, target: &str, what: &[&str]) -> Result<(PathBuf, String), PilError> {
    let folder = env::var_os("CARGO_TARGET_DIR").map_or_else(|| Path::new(WORKSPACE).join("target"), PathBuf::from).join("pil");
    let built = run("CARGO", "cargo", |cargo| {
        cargo.args(["build", "--quiet", "--profile", profile, "--target", target, "--target-dir"]).arg(&folder).args(what)
    });
    match built {
        Ok(output) if output.status.success() => Ok((folder, String::from_utf8_lossy(&output.stdout).into_owned())),
        Ok(output) => Err(PilError::Build(String::from_utf8_lossy(&output.stderr).into_owned())),
        Err(error) => Err(PilError::Build(format!("cargo could not be started: {error}"))),
    }
}

/// Returns `true` if the compiler of this workspace can build for a target.
fn has_core_library(target: &str) -> bool {
    let asked = run("RUSTC", "rustc", |rustc| rustc.args(["--print", "target-libdir", "--target", target]));
    let Some(folder) = asked.ok().filter(|output| output.status.success()) else { return false };
    let folder = String::from_utf8_lossy(&folder.stdout).trim().to_owned();
    let names = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.file_name());
    names.into_iter().any(|name| name.to_string_lossy().starts_with("libcore-"))
}

/// Runs a tool of the toolchain in the workspace, so that `rust-toolchain.toml` selects the
/// version.
fn run(variable: &str, name: &str, arguments: impl Fn(&mut Command) -> &mut Command) -> std::io::Result<Output> {
    let mut command = Command::new(env::var_os(variable).unwrap_or_else(|| name.into()));
    for inherited in NOT_INHERITED {
        command.env_remove(inherited);
    }
    arguments(command.current_dir(WORKSPACE)).output()
}
