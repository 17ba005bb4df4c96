//! Packs the simulator and its page into one file, `sonoglide.html`, which opens from a disk or
//! from a server and loads nothing else.
//!
//! ```text
//! sonoglide-web --cargo--> wasm --wasm-bindgen--> glue + wasm --LZMA, base64--+
//! image of the board --LZMA, base64-------------------------------------------+
//! built-in scenes --run here--> drive hashes of the host ---------------------+--> page/index.html with everything in it
//! page/*.css, page/*.js, the scripts of a report -----------------------------+
//! ```
//!
//! `cargo run --release -p sonoglide-web-pack -- FOLDER`; the default folder is `target/web`. With
//! `--page-only` the result of the last compilation is packed again with the present page.

mod assemble;
mod compile;

use std::path::{Path, PathBuf};
use std::{env, fs};

use anyhow::{Context, Result};

use crate::assemble::Parts;

fn main() -> Result<()> {
    let web = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../web"));
    let target = env::current_exe()?.ancestors().nth(2).context("the program is not in a target folder")?.to_owned();
    let (options, folders): (Vec<_>, Vec<_>) = env::args_os().skip(1).partition(|argument| argument == "--page-only");
    let folder = folders.first().map_or_else(|| target.join("web"), PathBuf::from);
    if options.is_empty() {
        compile::compile(&target)?;
    }
    let core = compile::compiled(&target)?;
    let page = assemble::page(&Parts { web, core: &core })?;
    fs::create_dir_all(&folder)?;
    let path = folder.join("sonoglide.html");
    fs::write(&path, &page).with_context(|| format!("cannot write {}", path.display()))?;
    let packed = assemble::gzip(page.as_bytes())?.len();
    let kib = |bytes: usize| bytes.div_ceil(1024);
    println!("{}: {} KiB, {} KiB gzipped; wasm {} KiB", path.display(), kib(page.len()), kib(packed), kib(core.wasm.len()));
    Ok(())
}
