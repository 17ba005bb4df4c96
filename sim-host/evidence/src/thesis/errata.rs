//! Contradictions of the thesis with itself or with physics, each with numbers that show it.

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

/// Contradiction within the thesis.
#[derive(Clone, Debug, PartialEq)]
pub struct Erratum {
    /// Short name of the contradiction.
    pub id: &'static str,
    /// Equations, tables and sections that disagree.
    pub places: &'static str,
    /// Statement as printed.
    pub printed: &'static str,
    /// Correct statement.
    pub instead: &'static str,
    /// Numbers, and the result whether they show the contradiction.
    pub evidence: Check,
}

/// Computes all known contradictions.
pub fn all() -> Result<Vec<Erratum>, SolveError> {
    Ok([sign::errata()?, energy::errata()?, transducer::errata(), beam::errata(), sheet::errata()].concat())
}
