//! Tests that run on the processor itself: in QEMU (`cargo test -p image-scenarios on_target`) or
//! on a Nucleo-G474RE (`cargo hil`).
//!
//! The processor is reset before each test. Built for the host, this is a stub that prints how to
//! run it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "on_target/image.rs"]
mod image;

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "on-target runs on a Cortex-M4F: `cargo test -p image-scenarios on_target` starts it in QEMU, `cargo hil` on a board"
    );
}
