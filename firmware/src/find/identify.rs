//! Identification of the transducer: its equivalent circuit with standard deviations, and its
//! other modes.
//!
//! [`pole_fit`] fits resonances to a spectrum, [`mode_search`] determines their number, and
//! [`choice`] selects the one to drive. [`givens`](crate::find::givens) contains the least squares
//! behind the fit.

pub(crate) mod choice;
pub(crate) mod circuit;
pub(crate) mod mode_search;
pub(crate) mod pole_fit;
pub(crate) mod scatter;
