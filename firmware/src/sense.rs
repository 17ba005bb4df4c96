//! From the converter codes of one block to the phasors of voltage and current, the motional current, the source and the belt's motion.
//!
//! This layer depends on [`seam`](crate::seam), and on [`generate`](crate::generate) for the oscillator and the sine that the lock-in compares with.

pub mod belt;
pub mod convert;
pub mod demod;
pub mod motional;
pub(crate) mod resonator;
pub(crate) mod source;
