//! Compiler of the benchmarks: GCC with the user's sources, and the startup and port of this
//! folder.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Error;

/// Folder of startup, linker script and ports.
const PORT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/benchmarks/port");
const COMPILER: &str = "arm-none-eabi-gcc";

/// Flags of every program, for Debian's newlib.
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

/// Program and its sources.
pub struct Program {
    pub name: String,
    pub sources: Vec<PathBuf>,
    /// Folder of the headers.
    pub headers: PathBuf,
    /// Source of the port.
    pub port: &'static str,
    pub defines: &'static [&'static str],
}

/// Returns the first line of the compiler's version.
pub fn compiler() -> Result<String, Error> {
    let output = Command::new(COMPILER).arg("--version").output();
    let output = output.map_err(|error| {
        format!("{COMPILER} does not start ({error}); on Debian install gcc-arm-none-eabi and libnewlib-arm-none-eabi")
    })?;
    Ok(String::from_utf8_lossy(&output.stdout).lines().next().unwrap_or_default().to_owned())
}

/// Compiles and links a program, and returns its ELF.
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
