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
}

const TARGET: &str = "wasm32-unknown-unknown";

fn cargo(arguments: &[&str], target: &Path) -> Command {
    let mut cargo = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../..")).args(arguments).arg("--target-dir").arg(target);
    cargo
}

/// Returns the folder of the compiled parts.
fn folder(target: &Path) -> PathBuf {
    target.join("web-parts")
}

/// Compiles the package `sonoglide-web`, generates its glue, and runs the built-in scenes.
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
    fs::write(&path, run.stdout).with_context(|| format!("cannot write {}", path.display()))
}

/// Reads the parts of the last compilation.
pub fn compiled(target: &Path) -> Result<Core> {
    let read = |name: &str| {
        let path = folder(target).join(name);
        fs::read(&path).with_context(|| format!("cannot read {}: nothing was compiled yet", path.display()))
    };
    let text = |name: &str| Ok::<_, anyhow::Error>(String::from_utf8(read(name)?)?);
    Ok(Core { glue: text("core.js")?, wasm: read("core_bg.wasm")?, hosts: text("hosts.json")? })
}
