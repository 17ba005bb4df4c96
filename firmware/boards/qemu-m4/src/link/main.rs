//! Complete board under QEMU: block task, background task, settings and watchdog, with the link
//! over an emulated UART.
//!
//! The host simulates the converters and the pins, one block at a time
//! (`firmware::board::lockstep`, `Beat`). The program at the other end of the UART communicates
//! with the background task as with a real board. The image has no clock: a byte sent by the host
//! is received in the next block.
//!
//! Built for the host, it is a stub that prints a message.
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
    eprintln!("link is an image for an emulated Cortex-M4F: sim-host builds and starts it for the tests that use it");
    std::process::ExitCode::from(2)
}
