//! `export`: a scene for other simulators.

use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use sim::fmu::{self, Kind, MODEL_IDENTIFIER, SCENE_FILE};
use zip::write::{SimpleFileOptions, ZipWriter};

use super::exit::{Exit, mistake};
use super::{SceneArgs, print};

/// Function that the library of a unit has.
const ENTRY: &str = "fmi3InstantiateCoSimulation";
/// Command that builds the library of a unit.
const BUILD: &str = "cargo build --release -p sonoglide-embed";

/// Formats of `export`.
#[derive(Subcommand)]
pub(super) enum Export {
    /// Write a scene as a functional mock-up unit (FMI 3.0, co-simulation).
    ///
    /// The unit has the controller, the stack, the contact and the converters of the scene, and
    /// advances in steps of 1 ms; with --controller, the controller alone, in steps of one block.
    Fmu(FmuArgs),
}

/// Arguments of `export fmu`.
#[derive(Args)]
pub(super) struct FmuArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// File to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Only the controller, with arrays of codes, in steps of one block.
    #[arg(long)]
    controller: bool,
    /// Library of the unit; by default, the one in the folder of this program.
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
}

/// Writes a unit.
pub(super) fn run(export: &Export) -> anyhow::Result<Exit> {
    let Export::Fmu(args) = export;
    let loaded = args.scene.load()?;
    let kind = if args.controller { Kind::Controller } else { Kind::Board };
    let description = fmu::description(&loaded, kind).ok_or_else(|| {
        mistake(Exit::Input, format!("`{}` has no [controller]: only a scene that the firmware drives is a unit", loaded.name))
    })?;
    let path = args.library.clone().map_or_else(default_library, Ok)?;
    let library = fs::read(&path).map_err(|error| {
        mistake(Exit::Input, format!("cannot read the library of the unit, {}: {error}; `{BUILD}` makes it", path.display()))
    })?;
    if !library.windows(ENTRY.len()).any(|bytes| bytes == ENTRY.as_bytes()) {
        return Err(mistake(Exit::Input, format!("{} is not the library of a unit; `{BUILD}` makes it", path.display())));
    }
    let folder = platform().ok_or_else(|| {
        mistake(Exit::Failed, format!("FMI 3.0 has no name for the platform {ARCH} with {OS}; none is exported"))
    })?;
    let text = fmu::scene_text(&loaded);
    let parts: [(&str, &[u8]); 3] = [
        ("modelDescription.xml", description.as_bytes()),
        (&format!("binaries/{folder}/{MODEL_IDENTIFIER}{DLL_SUFFIX}"), &library),
        (&format!("resources/{SCENE_FILE}"), text.as_bytes()),
    ];
    write(&args.output, &parts)
        .map_err(|error| mistake(Exit::Failed, format!("cannot write {}: {error}", args.output.display())))?;
    print(&format!("{}: unit of {} for {folder}\n", args.output.display(), loaded.name))
}

/// Returns the library in the folder of this program.
fn default_library() -> anyhow::Result<PathBuf> {
    let program = std::env::current_exe()?;
    let folder = program.parent().unwrap_or(Path::new("."));
    Ok(folder.join(format!("{DLL_PREFIX}{MODEL_IDENTIFIER}{DLL_SUFFIX}")))
}

/// Returns the folder of binaries for this platform in a unit.
fn platform() -> Option<String> {
    let system = match OS {
        "linux" => "linux",
        "macos" => "darwin",
        "windows" => "windows",
        _ => return None,
    };
    matches!(ARCH, "x86_64" | "aarch64").then(|| format!("{ARCH}-{system}"))
}

/// Writes an archive to a file, complete or not at all.
fn write(path: &Path, parts: &[(&str, &[u8])]) -> io::Result<()> {
    // The file that a link names is replaced, not the link.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if path.exists() && !path.is_file() {
        return Err(io::Error::other("it is not a regular file"));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let unfinished = path.with_file_name(format!(".{name}.{}.unfinished", std::process::id()));
    let written = archive(&unfinished, parts).and_then(|()| fs::rename(&unfinished, &path));
    if written.is_err() {
        let _ = fs::remove_file(&unfinished);
    }
    written
}

fn archive(path: &Path, parts: &[(&str, &[u8])]) -> io::Result<()> {
    let mut archive = ZipWriter::new(File::create(path)?);
    for (name, bytes) in parts {
        archive.start_file(*name, SimpleFileOptions::default())?;
        archive.write_all(bytes)?;
    }
    archive.finish()?.sync_all()
}
