//! Link arguments of the image. They are set here because the environment's `RUSTFLAGS` would
//! replace `rustflags`.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    // The linker runs in the workspace root and finds `memory.x` there.
    println!("cargo::rerun-if-changed=../../../memory.x");
    if std::env::var("TARGET").is_ok_and(|target| target.starts_with("thumbv8m.main")) {
        println!("cargo::rustc-link-arg-bins=--defsym=__mps2_an505=1");
    }
    println!("cargo::rustc-link-arg-bins=--nmagic");
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
}
