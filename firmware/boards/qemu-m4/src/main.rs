//! The controller as thumb code under QEMU: processor in the loop.
//!
//! The image runs the same controller as the board, on an emulated Cortex-M4F. The host plays the converters: it sends one
//! record (`firmware::board::lockstep`) a block through a pipe and waits for the codes. Nothing here knows time, so what this shows is
//! arithmetic and code generation, not timing; each answer says how many instructions it took.
//!
//! Built for the host, it is a stub that says how to build the image.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!("qemu-m4 is an image for an emulated Cortex-M4F: build it with `cargo pil`, run it through sim-host");
    std::process::ExitCode::from(2)
}
