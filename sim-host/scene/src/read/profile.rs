//! Measured profiles: their files, headings, columns and units.

pub(crate) mod column;
pub(crate) mod resolve;
