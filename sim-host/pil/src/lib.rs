//! Processor in the loop: the controller as thumb code under QEMU, with the same interface
//! [`Processor`](sim::processor::Processor) as the controller in this process.
//!
//! The image (package `qemu-m4`) reads the samples of the converters from one inherited pipe and
//! writes the codes to another, by semihosting, one [record](firmware::board::lockstep) a block.
//! Host and emulator take turns, so both are pinned to one core: a switch there is faster than
//! waking another core. While the guest waits it executes nothing, so a run is the same,
//! instruction for instruction, at any load of the machine.
//!
//! It tests arithmetic and code generation: the thumb code must return the codes of the host, bit
//! for bit. It also counts the instructions for them, to within a tick of the emulated timer (about
//! 6). It does not measure time.
//!
//! # Example
//!
//! ```
//! # if sonoglide_pil::missing().is_some() { return Ok(()) } // no emulator or no thumb target here
//! use scene::load::load;
//! use sim::run::{Watch, run, run_on};
//! use sonoglide_pil::{Qemu, image};
//!
//! let loaded = load("lock", &[])?;
//! let scene = loaded.scene.driven().expect("the firmware drives it");
//! let mut processor = Qemu::start(&image()?, &scene::settings::config(&scene))?;
//! let emulated = run_on(&mut processor, &scene, Watch::default())?;
//! assert_eq!(emulated.drive_hash, run(&scene, Watch::default())?.drive_hash); // bit for bit
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

#[cfg(target_os = "linux")]
pub mod cpu_affinity;
#[cfg(target_os = "linux")]
pub mod emulator;
mod image;
pub mod machine;
#[cfg(target_os = "linux")]
pub mod pipes;
#[cfg(target_os = "linux")]
mod qemu;
#[cfg(not(target_os = "linux"))]
#[path = "unsupported.rs"]
mod qemu;
pub mod size;

pub use image::{
    IMAGE_VARIABLE, board_image, cortex_m33_image, counting_image, field_images, image, link_image, missing, missing_to_build,
    missing_to_build_cortex_m33, test_image,
};
pub use qemu::Qemu;

/// Reason for which there is no processor in the loop.
#[derive(Debug, thiserror::Error)]
pub enum PilError {
    /// A requirement is not installed.
    #[error("no processor in the loop: {0}")]
    Missing(String),
    /// The image could not be built.
    #[error("the processor-in-the-loop image could not be built:\n{0}")]
    Build(String),
    /// QEMU could not be started.
    #[error("QEMU could not be started: {0}")]
    Start(#[from] std::io::Error),
    /// The firmware in the image refuses its configuration.
    #[error("the firmware refuses these settings: {0}")]
    Config(String),
    /// QEMU was lost before the controller was built.
    #[error(transparent)]
    Lost(#[from] sim::processor::Lost),
}

impl From<PilError> for sim::run::RunError {
    fn from(error: PilError) -> Self {
        sim::run::RunError::NoProcessor(error.into())
    }
}
