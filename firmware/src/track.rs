//! Tracking of the resonance while it is driven: observer, phase loop, lock detector, and the
//! transducer that is identified meanwhile.
//!
//! This layer depends on [`seam`](crate::seam), [`generate`](crate::generate),
//! [`sense`](crate::sense) and [`find`](crate::find).

pub(crate) mod tracked_transducer;
pub mod tracker;
