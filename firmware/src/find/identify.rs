//! What a transducer is: its equivalent circuit, how sure that is, and what else rings.
//!
//! [`pole_fit`]: resonances from a spectrum. [`mode_search`]: how many it shows. [`choice`]: the one that is wanted.
//! [`triangle`]: the least squares behind the fit.

pub mod choice;
pub mod circuit;
pub mod mode_search;
pub mod pole_fit;
pub mod scatter;
pub mod triangle;

pub use crate::find::identify::scatter::Scatter;
