//! Link arguments of the image. They are set here because the environment's `RUSTFLAGS` would
//! replace `rustflags`.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=ccmram.x");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    // The linker runs in the workspace root and finds `memory.x` there. The core-coupled RAM is
    // specific to this board.
    println!("cargo::rerun-if-changed=../../../memory.x");
    println!("cargo::rustc-link-arg-bins=--nmagic");
    let package = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    // Only the image has code in core-coupled RAM, not the first stage. In a slot the image begins
    // after the first stage (`memory.x`).
    println!("cargo::rustc-link-arg-bin=nucleo-g474re=-T{package}/ccmram.x");
    if std::env::var_os("CARGO_FEATURE_SLOT").is_some() {
        println!("cargo::rerun-if-changed=slot.x");
        println!("cargo::rerun-if-changed=first_stage.x");
        println!("cargo::rustc-link-arg-bin=nucleo-g474re=--defsym=__slot=1");
        println!("cargo::rustc-link-arg-bin=nucleo-g474re=-T{package}/slot.x");
        println!("cargo::rustc-link-arg-bin=first-stage=-T{package}/first_stage.x");
    }
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    println!("cargo::rustc-link-arg-bins=-Tdefmt.x");
}
