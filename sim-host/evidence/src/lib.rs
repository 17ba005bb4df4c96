//! Evidence for the project's claims: the thesis recomputed, work against precision, and suites of
//! many cases, each compared with its targets.
//!
//! ```text
//! suites/*.toml --> sim::study::suite --+
//! code (guard, thesis, precision, ...) --+--> Evidence: tables, figures, missed targets --> terminal, page, docs
//! ```
//!
//! # Example
//!
//! ```
//! let table = sonoglide_evidence::thesis::table::table_4_1();
//! assert_eq!(table.header, ["parameter", "value", "source"]);
//! ```
#![forbid(unsafe_code)]

pub mod bench;
pub mod board_faults;
mod board_scenes;
pub mod campaign;
pub mod campaign_error;
mod commission;
mod contacts;
mod crash;
#[cfg(test)]
mod docs;
pub mod evidence;
mod faults;
mod features;
pub mod field_update;
mod friction;
mod fuzz;
pub mod guard;
mod imports;
pub mod instructions;
mod measurements;
pub mod precision;
mod random;
pub mod thesis;
mod transducers;
