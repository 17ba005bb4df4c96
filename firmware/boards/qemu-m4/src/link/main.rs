//! A whole board under QEMU: block task, background task, settings and watchdog, with the link over an emulated UART.
//!
//! The host plays the converters and the pins, a block at a time (`firmware::board::lockstep`, `Beat`); the program at the other end of the UART talks
//! to the background task as to a board. Nothing here knows time: a byte that the host has sent is received in the next block.
//!
//! Built for the host, it is a stub that says so.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;
#[cfg(target_os = "none")]
mod pins;
#[cfg(target_os = "none")]
mod retained;
#[cfg(target_os = "none")]
mod usart;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!("link is an image for an emulated Cortex-M4F: sim-host builds and starts it where a test talks to it");
    std::process::ExitCode::from(2)
}
