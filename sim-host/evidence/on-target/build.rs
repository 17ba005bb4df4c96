//! Computes on the host the codes that the target must play, and passes the linker its scripts.

#[path = "src/stream.rs"]
mod stream;

use std::path::PathBuf;
use std::{env, fs};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/stream.rs");
    println!("cargo::rustc-check-cfg=cfg(rust_analyzer)");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return Ok(());
    }
    let played = stream::play(|_, process| process()).map_err(|error| error.to_string())?;
    let text = format!("/// A power-up.\npub const OF_THE_HOST: Played = {played:?};\n");
    fs::write(PathBuf::from(env::var("OUT_DIR")?).join("of_the_host.rs"), text)?;
    // The linker runs in the workspace root and finds `memory.x` there.
    println!("cargo::rerun-if-changed=../../../memory.x");
    println!("cargo::rustc-link-arg-tests=--nmagic");
    println!("cargo::rustc-link-arg-tests=-Tlink.x");
    println!("cargo::rustc-link-arg-tests=-Tembedded-test.x");
    Ok(())
}
