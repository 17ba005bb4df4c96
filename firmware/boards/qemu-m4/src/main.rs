//! The controller as Thumb code under QEMU: processor in the loop.
//!
//! The image runs the same controller as the board, on an emulated Cortex-M4F. The host simulates
//! the converters: it sends one record (`firmware::board::lockstep`) per block through a pipe and
//! waits for the codes. The image has no clock, so it tests arithmetic and code generation, not
//! timing. Each answer contains the number of instructions it took.
//!
//! Built for the host, it is a stub that prints how to build the image.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!("qemu-m4 is an image for an emulated Cortex-M4F: build it with `cargo pil`, run it through sim-host");
    std::process::ExitCode::from(2)
}
