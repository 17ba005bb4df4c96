//! The image for a Nucleo-G474RE: the controller with its converters.
//!
//! Built for the host, it is a stub that prints the commands to build and flash the image.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    eprintln!(
        "nucleo-g474re is an image for a board: build it with `cargo fw`, flash it with `cargo flash`; \
         docs/board.md lists the requirements"
    );
    std::process::ExitCode::from(2)
}
