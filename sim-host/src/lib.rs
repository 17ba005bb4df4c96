//! Sonoglide's host side: the plant behind the converters, contact studies, scenes, metrics and reports.
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
//!
//! The controller is the `firmware` crate, unchanged; this crate is what it is connected to.
#![forbid(unsafe_code)]

pub mod advice;
pub mod cli;
pub mod contact;
pub mod cramer_rao;
pub mod crash;
pub mod edge_meter;
pub mod figures;
pub mod findings;
pub mod friction;
pub mod guard;
pub mod instructions;
pub mod link;
pub mod metric_names;
pub mod metrics;
pub mod output;
pub mod pil;
pub mod plant;
pub mod precision;
pub mod processor;
pub mod record;
pub mod report;
pub mod run;
pub mod scene;
pub mod schedule;
pub mod spectrum;
pub mod study;
pub mod swing;
pub mod thesis;
pub mod time_frequency;
pub mod trace;
pub mod tracking;

pub use scene::settings;
