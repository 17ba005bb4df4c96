//! Runs of a scene: the firmware's controller against the plant, what is measured, and what is told of it.
//!
//! ```text
//! scene [controller] --> settings --> processor (the firmware's controller, here or in an emulator)
//!   |                                     ^ |
//!   |                               codes | | codes
//!   |                                     | v
//!   +------------------------------> plant (stack, contact, rig) --> record ---+
//!                                                                              v
//! scene [excitation] --> problem --> contact (solved by itself) --> film --> metrics --> study --> findings, figures --> report
//! ```
#![forbid(unsafe_code)]

pub mod advice;
pub mod bounds;
pub mod cramer_rao;
pub mod edge_meter;
pub mod figures;
pub mod findings;
pub mod metrics;
pub mod output;
pub mod processor;
pub mod record;
pub mod run;
pub mod schedule;
pub mod study;
pub mod swing;
pub mod trace;
