//! Lists the built-in scenes, one for every `scenes/NAME.toml`, in alphabetical order.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let folder = Path::new(&env::var("CARGO_MANIFEST_DIR").map_err(io::Error::other)?).join("scenes");
    println!("cargo:rerun-if-changed={}", folder.display());
    let mut files = fs::read_dir(&folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
    // Sorted by stem: with its extension, `lock.toml` would come after `lock-any.toml`.
    files.sort_by(|one, other| one.file_stem().cmp(&other.file_stem()));
    let mut list = "&[\n".to_owned();
    for file in &files {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let _ = writeln!(list, "    ({name:?}, include_str!({:?})),", file.to_string_lossy());
    }
    fs::write(Path::new(&env::var("OUT_DIR").map_err(io::Error::other)?).join("scenes.rs"), list + "]\n")
}
