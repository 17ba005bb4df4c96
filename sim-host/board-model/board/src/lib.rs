//! The unmodified image of the driver board on a model of its microcontroller, with the plant of a
//! scene at its pins.
//!
//! ```text
//! ELF ------------> cortex-m4 <--> stm32g474 <--> Bench: amplifier, plant, emergency stop, serial line
//! scene -> configure -> flash          |
//!                                   Board: calls of the controller, by the image's variables -> Replay -> a run on the host
//! ```
//!
//! [`Board`] runs the image. [`configure`] stores a scene's configuration in its flash.
//! [`variables`] reads variables of the image by the debug information of its ELF. [`recording`]
//! replays the calls of its controller on the host. [`debugger`] connects GDB, and [`linked`] a
//! client. [`interpreter`] runs the image of the emulator on the same processor.
//!
//! # Example
//!
//! Settings of a scene that the image can store, and one that it cannot:
//!
//! ```
//! use sonoglide_board::configure::{load, overrides};
//!
//! let image = nucleo_g474re::config::config();
//! let loaded = load("dummy-load", &["controller.limits.current_a=1.5".into()])?;
//! let asked = scene::settings::config(&loaded.scene.driven().expect("the firmware drives it"));
//! assert!(overrides(&asked, &image)?.overrides.iter().any(|(_, value)| *value == 1.5));
//!
//! let loaded = load("lock", &["controller.block_samples=50".into()])?;
//! let asked = scene::settings::config(&loaded.scene.driven().expect("the firmware drives it"));
//! assert!(overrides(&asked, &image).unwrap_err().to_string().contains("block_samples"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

mod board;
pub mod configure;
pub mod debugger;
pub mod interpreter;
pub mod linked;
pub mod recording;
mod reset;
mod semihosting;
mod sensors;
pub mod variables;
mod wires;

pub use board::{Board, BoardError, Options};
pub use reset::Reset;
pub use wires::{Bench, Edge};
