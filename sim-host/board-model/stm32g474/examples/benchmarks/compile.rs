//! Builds a benchmark with GCC: the sources are the reader's, startup and port are those next to this file.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Error;

/// Startup, linker script and ports.
const PORT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/benchmarks/port");
const COMPILER: &str = "arm-none-eabi-gcc";

/// The flags of every program; newlib as Debian has it.
const FLAGS: [&str; 8] = [
    "-mcpu=cortex-m4",
    "-mthumb",
    "-mfloat-abi=soft",
    "-std=gnu99",
    "-w",
    "-nostartfiles",
    "-specs=nosys.specs",
    "-Wl,--gc-sections",
];

/// A program and what it is made of.
pub struct Program {
    pub name: String,
    pub sources: Vec<PathBuf>,
    /// The folder of its headers.
    pub headers: PathBuf,
    /// The port's source.
    pub port: &'static str,
    pub defines: &'static [&'static str],
}

/// The first line of what the compiler says of itself.
pub fn compiler() -> Result<String, Error> {
    let output = Command::new(COMPILER).arg("--version").output();
    let output = output.map_err(|error| {
        format!("{COMPILER} does not start ({error}); Debian has it in gcc-arm-none-eabi and libnewlib-arm-none-eabi")
    })?;
    Ok(String::from_utf8_lossy(&output.stdout).lines().next().unwrap_or_default().to_owned())
}

/// Compiles and links a program; its ELF.
pub fn build(program: &Program, flags: &str) -> Result<Vec<u8>, Error> {
    let elf = std::env::temp_dir().join(format!("sonoglide-{}-{}.elf", program.name, std::process::id()));
    let port = Path::new(PORT);
    let mut command = Command::new(COMPILER);
    command.args(FLAGS).args(flags.split(' ')).args(program.defines);
    command.arg(format!("-DCOMPILER_FLAGS=\"{flags}\""));
    command.arg("-I").arg(port).arg("-I").arg(&program.headers).arg("-T").arg(port.join("memory.ld"));
    command.args(["start.c", program.port].map(|name| port.join(name))).args(&program.sources);
    let output = command.arg("-lm").arg("-o").arg(&elf).output()?;
    if !output.status.success() {
        return Err(format!("{} with {flags}:\n{}", program.name, String::from_utf8_lossy(&output.stderr)).into());
    }
    let bytes = std::fs::read(&elf)?;
    std::fs::remove_file(&elf)?;
    Ok(bytes)
}
