//! Tests of thumb images, under QEMU and on the model of the microcontroller.
//!
//!     cargo test -p image-scenarios
//!
//! Skipped, with a message, if QEMU or the thumb target is not installed.

mod board_image;
mod debugger;
#[cfg(target_os = "linux")]
mod emulated;
mod flashed_image;
#[path = "../link/held.rs"]
mod held;
mod on_target;
mod processor_in_the_loop;
mod update;
