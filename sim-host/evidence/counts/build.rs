//! Sets the linker arguments of the image. They are here and not in `rustflags`, because the
//! environment's `RUSTFLAGS` would replace those.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    // The linker runs in the workspace root and finds `memory.x` there.
    println!("cargo::rerun-if-changed=../../../memory.x");
    println!("cargo::rustc-link-arg-bins=--nmagic");
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
}
