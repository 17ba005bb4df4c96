//! Runs of a scene: the firmware's controller against the plant, measurements, and presentation of
//! the results.
//!
//! ```text
//! scene [controller] --> settings --> processor (the firmware's controller, here or in an emulator)
//!   |                                     ^ |
//!   |                               codes | | codes
//!   |                                     | v
//!   +------------------------------> plant (stack, contact, rig) --> record ---+
//!                                                                              v
//! scene [excitation] --> problem --> contact (solved alone) --> playback --> instruments (metrics, tables, figures) --> report
//! ```
//!
//! # Example
//!
//! The controller follows a resonance that jumps (`scene` is the package `sonoglide-scene`). No
//! clock, thread or terminal is needed; a caller that has them passes them in [`study::Options`].
//!
//! ```
//! use scene::load::load;
//! use sonoglide_sim::study::{self, Options};
//!
//! let loaded = load("lock-step", &[])?;
//! let study = study::run(&loaded, Options::default())?;
//! let relocked_ms = study.metrics.get("relock_time_20hz_ms").expect("it locks again");
//! println!("within 20 Hz of the resonance {relocked_ms:.3} ms after the jump");
//! assert!(study.passes() && relocked_ms < 0.5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]

pub mod advice;
pub mod bounds;
pub mod columns;
#[cfg(feature = "files")]
pub mod compare;
pub mod cramer_rao;
pub mod data;
pub mod edge_meter;
pub mod evidence;
pub mod explain;
pub mod figures;
pub mod fmu;
pub mod instruments;
pub mod metrics;
pub mod numbers;
#[cfg(feature = "files")]
pub mod output;
pub mod overlay;
pub mod processor;
pub mod provenance;
pub mod record;
pub mod run;
pub mod schedule;
pub mod stepping;
pub mod study;
pub mod summary;
pub mod swing;
pub mod tables;
pub mod trace;
pub mod trace_table;

/// Version of this program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
