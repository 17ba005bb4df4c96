//! Sonoglide's host side: the plant behind the converters, scenes, metrics and reports.
//!
//! The controller is the `firmware` crate, unchanged; this crate is what it is connected to.
#![forbid(unsafe_code)]

pub mod plant;
pub mod processor;
pub mod record;
pub mod run;
pub mod scene;
pub mod settings;
