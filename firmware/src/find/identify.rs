//! What a transducer is: its equivalent circuit, how sure that is, and what else rings.
//!
//! [`pole_fit`]: resonances from a spectrum. [`mode_search`]: how many it shows. [`choice`]: the one to drive.
//! [`triangle`]: the least squares behind the fit.

pub(crate) mod choice;
pub(crate) mod circuit;
pub(crate) mod mode_search;
pub(crate) mod pole_fit;
pub(crate) mod scatter;
pub(crate) mod triangle;
