//! Link arguments of the image. They stand here and not in `rustflags`, which the environment's `RUSTFLAGS` would replace.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=ccmram.x");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    // The linker runs in the workspace root and finds `memory.x` there; the core-coupled RAM is this board's own.
    println!("cargo::rerun-if-changed=../../../memory.x");
    println!("cargo::rustc-link-arg-bins=--nmagic");
    let package = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    println!("cargo::rustc-link-arg-bins=-T{package}/ccmram.x");
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
}
