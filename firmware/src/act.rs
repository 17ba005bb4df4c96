//! Commands to the drive while the resonance is tracked: the friction switch, and the restraint of
//! a seat belt in a crash.
//!
//! Both are omitted from an image built without the feature `friction`. This layer depends on
//! [`seam`](crate::seam) and [`sense`](crate::sense).

pub mod friction;
pub(crate) mod restraint;
