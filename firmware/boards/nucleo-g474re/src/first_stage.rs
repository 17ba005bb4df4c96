//! The first stage: runs after each reset, selects the image to start, installs a marked update,
//! and restores the former image.
//!
//! It runs from the internal oscillator in its reset state and does not change any pin: the
//! amplifier's enable is held low by its resistor. Updates do not change the first stage.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod stage;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!("first-stage is an image for a board: build it with `cargo first-stage` and flash it as described in docs/link.md");
    std::process::ExitCode::from(2)
}
