//! The evidence: the thesis recomputed, work against precision, and campaigns over many cases, each held against its targets.
//!
//! # Example
//!
//! ```
//! let table = sonoglide_proof::thesis::table::table_4_1();
//! assert_eq!(table.header, ["parameter", "value", "source"]);
//! ```
#![forbid(unsafe_code)]

pub mod crash;
#[cfg(test)]
mod docs;
pub mod friction;
pub mod guard;
pub mod instructions;
pub mod precision;
pub mod thesis;
pub mod tracking;
