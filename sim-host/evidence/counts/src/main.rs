//! Counts the instructions of kernels on the target in QEMU; one line of CSV per kernel on standard
//! output.
//!
//! `evidence instructions` builds it, starts it and reads the output.
//!
//! Built for the host, it is a stub that prints how to run it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod csv;
#[cfg(target_os = "none")]
mod generators;
#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
mod power_up;
#[cfg(target_os = "none")]
mod recorder;
#[cfg(target_os = "none")]
mod repeat;
#[cfg(target_os = "none")]
mod stages;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!("counts is an image for an emulated Cortex-M4F: `evidence instructions` builds and runs it");
    std::process::ExitCode::from(2)
}
