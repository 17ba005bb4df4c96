//! A contact study: friction under a given excitation, without a controller.

pub mod figures;
pub mod metrics;
pub mod table;
