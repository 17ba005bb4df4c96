//! The first stage: decides after each reset which image is started, installs an update that was marked, and brings the former image back.
//!
//! It runs from the internal oscillator as reset leaves it, touches no pin (the amplifier's enable is low by its resistor) and is not changed by updates.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod stage;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!("first-stage is an image for a board: build it with `cargo first-stage`; docs/update.md says how it is flashed");
    std::process::ExitCode::from(2)
}
