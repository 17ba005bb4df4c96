//! Compilation of the simulator to WebAssembly with its JavaScript glue, and the drive hashes of
//! this machine.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs};

use anyhow::{Context, Result, ensure};
use wasm_bindgen_cli_support::Bindgen;

/// Compiled parts.
pub struct Core {
    /// Script that defines `wasm_bindgen`.
    pub glue: String,
    /// WebAssembly module.
    pub wasm: Vec<u8>,
    /// Drive hashes of the built-in scenes, as JSON.
    pub hosts: String,
    /// Bytes of the flash of a Nucleo; empty if the target of the image is not installed.
    pub firmware: Vec<u8>,
}

const TARGET: &str = "wasm32-unknown-unknown";
const BOARD_TARGET: &str = "thumbv7em-none-eabihf";
/// Name of the image in the folder of the parts.
const FIRMWARE: &str = "nucleo.bin";

fn cargo(arguments: &[&str], target: &Path) -> Command {
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../..")).args(arguments).arg("--target-dir").arg(target);
    cargo
}

/// Returns the folder of the compiled parts.
fn folder(target: &Path) -> PathBuf {
    target.join("web-parts")
}

/// Compiles the package `sonoglide-web`, generates its glue, runs the built-in scenes, and builds
/// the image of the board.
pub fn compile(target: &Path) -> Result<()> {
    let build = ["build", "--package", "sonoglide-web", "--lib", "--profile", "web", "--target", TARGET];
    let status = cargo(&build, target).status().context("cargo cannot be started")?;
    ensure!(
        status.success(),
        "cargo could not build `sonoglide-web` for {TARGET}; `rustup target add {TARGET}` installs the target"
    );
    let module = target.join(TARGET).join("web").join("sonoglide_web.wasm");
    let mut bindgen = Bindgen::new();
    bindgen.input_path(module).out_name("core").no_modules(true)?.typescript(false);
    bindgen.remove_name_section(true).remove_producers_section(true).omit_default_module_path(true);
    bindgen.generate(folder(target))?;
    // Without `--package`, so that the result of `cargo run --release` is used.
    let run = cargo(&["run", "--release", "--bin", "sonoglide-web-hashes"], target).stderr(Stdio::inherit()).output()?;
    ensure!(run.status.success(), "the built-in scenes could not be run on this machine");
    let path = folder(target).join("hosts.json");
    fs::write(&path, run.stdout).with_context(|| format!("cannot write {}", path.display()))?;
    build_firmware(target)
}

/// Builds the image of the board as the bytes of its flash; an empty file if its target is not
/// installed.
fn build_firmware(target: &Path) -> Result<()> {
    let path = folder(target).join(FIRMWARE);
    let library = Command::new("rustc").args(["--print", "target-libdir", "--target", BOARD_TARGET]).output()?.stdout;
    if !Path::new(String::from_utf8(library)?.trim()).is_dir() {
        println!("SKIPPED: the page has no firmware, as the target {BOARD_TARGET} is not installed");
        return Ok(fs::write(path, [])?);
    }
    let build = ["build", "-p", "sonoglide-nucleo-g474re", "--profile", "board", "--target", BOARD_TARGET];
    let elf = target.join(BOARD_TARGET).join("board").join("nucleo-g474re");
    let out = format!("file:{}", path.display());
    let _ = fs::remove_file(&path);
    let mut convert = cargo(&["run", "--release", "--bin", "sim-host"], target);
    convert.args(["--", "link", &out, "update"]).arg(elf).stdout(Stdio::null());
    for mut step in [cargo(&build, target), convert] {
        ensure!(step.status().context("cargo cannot be started")?.success(), "the image of the board could not be built");
    }
    Ok(())
}

/// Reads the parts of the last compilation.
pub fn compiled(target: &Path) -> Result<Core> {
    let read = |name: &str| {
        let path = folder(target).join(name);
        fs::read(&path).with_context(|| format!("cannot read {}: nothing was compiled yet", path.display()))
    };
    let text = |name: &str| Ok::<_, anyhow::Error>(String::from_utf8(read(name)?)?);
    Ok(Core { glue: text("core.js")?, wasm: read("core_bg.wasm")?, hosts: text("hosts.json")?, firmware: read(FIRMWARE)? })
}
