//! Conversion of the codes of one block to phasors of voltage and current, motional current,
//! source, and motion of the belt.
//!
//! This layer depends on [`seam`](crate::seam), and on [`generate`](crate::generate) for the
//! oscillator and the sine that the lock-in uses.

pub mod belt;
pub mod convert;
pub mod demod;
pub mod motional;
pub(crate) mod resonator;
pub(crate) mod source;
