//! The evidence: the thesis recomputed, work against precision, and campaigns over many cases, each held against its targets.
#![forbid(unsafe_code)]

pub mod crash;
pub mod friction;
pub mod guard;
pub mod instructions;
pub mod precision;
pub mod thesis;
pub mod tracking;
