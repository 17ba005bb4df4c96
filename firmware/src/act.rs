//! What decides when and how strongly to drive while the resonance is followed: the friction switch, and the restraint of a seat belt in a crash.
//!
//! Both are left out of an image that is built without the feature `friction`. This layer depends on [`seam`](crate::seam) and
//! [`sense`](crate::sense).

pub mod friction;
pub(crate) mod restraint;
