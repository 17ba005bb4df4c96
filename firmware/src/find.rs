//! Procedures that run before the drive can follow the resonance: self-test, scan and
//! identification of the transducer, measurement of its clamped branch, and calibration of the
//! drive lanes. The lanes are also monitored during operation.
//!
//! Each procedure takes measured blocks and returns the [step](crate::generate::step::Step) to play
//! next. This layer depends on [`seam`](crate::seam), [`generate`](crate::generate) and
//! [`sense`](crate::sense).

pub(crate) mod calibrate;
pub mod clamped;
mod damage;
pub(crate) mod givens;
pub(crate) mod identify;
pub(crate) mod lanes;
pub(crate) mod scan;
pub(crate) mod self_test;
