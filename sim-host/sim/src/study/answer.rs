//! Answer of a contact study.

use super::across::Across;
use super::in_plane::InPlane;
use contact::{Orbit, Problem, Solution};

/// A problem and its solution.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Problem that was solved.
    pub problem: Problem,
    /// Solution of the problem.
    pub solution: Solution,
    /// Steady friction ratio and its motion, if they are known.
    pub steady: Option<(f64, Orbit)>,
    /// Normal direction, if the vibration is normal to the surface.
    pub across: Option<Across>,
    /// Direction transverse to the sliding, if the vibration is at an angle to it.
    pub in_plane: Option<InPlane>,
}
