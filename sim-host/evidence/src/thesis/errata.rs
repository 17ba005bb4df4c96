//! Where the thesis contradicts itself or physics, each with the numbers that show it.

mod beam;
mod energy;
mod open;
mod sheet;
mod sign;
mod transducer;

use super::claim::Check;
use contact::SolveError;

pub use beam::table as equations;
pub use open::{Choice, choices};

/// A contradiction within the thesis.
#[derive(Clone, Debug, PartialEq)]
pub struct Erratum {
    /// Short name of the contradiction.
    pub id: &'static str,
    /// Equations, tables and sections that disagree.
    pub places: &'static str,
    /// Statement as it is printed.
    pub printed: &'static str,
    /// Statement that holds instead.
    pub instead: &'static str,
    /// Whether the numbers show it, and the numbers.
    pub evidence: Check,
}

/// All contradictions that were found.
pub fn all() -> Result<Vec<Erratum>, SolveError> {
    Ok([sign::errata()?, energy::errata()?, transducer::errata(), beam::errata(), sheet::errata()].concat())
}
