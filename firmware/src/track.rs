//! The resonance while it is driven: observer and phase loop that follow it, the lock detector, and the transducer that is learned on the way.
//!
//! This layer depends on [`seam`](crate::seam), [`generate`](crate::generate), [`sense`](crate::sense) and [`find`](crate::find).

pub(crate) mod tracked_transducer;
pub mod tracker;
