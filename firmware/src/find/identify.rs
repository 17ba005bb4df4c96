//! Identification of the transducer: its equivalent circuit, the deviations, and its other modes.
//!
//! [`pole_fit`]: resonances from a spectrum. [`mode_search`]: how many it shows. [`choice`]: the one to drive.
//! [`givens`](crate::find::givens): the least squares behind the fit.

pub(crate) mod choice;
pub(crate) mod circuit;
pub(crate) mod mode_search;
pub(crate) mod pole_fit;
pub(crate) mod scatter;
