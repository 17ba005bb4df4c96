//! The answer of a contact study.

use super::across::Across;
use super::in_plane::InPlane;
use contact::{Problem, Solution};

/// A problem and its solution.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Problem that was solved.
    pub problem: Problem,
    /// Solution of the problem.
    pub solution: Solution,
    /// The normal direction, if the vibration is across the surface.
    pub across: Option<Across>,
    /// The direction across the sliding, if the vibration is at an angle to it.
    pub in_plane: Option<InPlane>,
}
