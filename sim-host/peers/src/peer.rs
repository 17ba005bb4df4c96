//! A peer: an integrator of another project, used on the case as well as its interface allows.

use std::fmt;

use crate::case::Case;

/// An integrator that the methods are compared with.
pub trait Peer {
    /// Whose it is, which method, and how reversals of the slip are treated.
    fn name(&self) -> String;

    /// Where it comes from.
    fn family(&self) -> Family;

    /// From coarse to fine, what it is run with.
    fn settings(&self) -> Vec<Setting>;

    /// Solves the case once.
    fn run(&mut self, case: &Case, setting: Setting) -> anyhow::Result<Outcome>;
}

/// Where a peer comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// A method of this project.
    Ours,
    /// A library in Rust.
    Rust,
    /// Python; slow enough to get fewer periods.
    Python,
}

/// How finely a peer works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// Absolute and relative tolerance.
    Tolerance(f64),
    /// Constant number of steps per period.
    Steps(u32),
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Setting::Tolerance(tolerance) => write!(f, "tolerance {tolerance:.0e}"),
            Setting::Steps(steps) => write!(f, "{steps} steps a period"),
        }
    }
}

/// Tolerances 1e-4 to 1e-11, a decade apart.
pub fn tolerances() -> Vec<Setting> {
    (4..=11).map(|digits| Setting::Tolerance(10f64.powi(-digits))).collect()
}

/// What a run gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Mean friction ratio over the second half.
    pub mean: f64,
    /// Friction over Fc at every quarter period, from zero to the end.
    pub forces: Vec<f64>,
    /// Wall time of the solution, ns.
    pub wall_ns: f64,
}

/// Collects friction at quarter periods, and the quadrature state at the middle and at the end.
#[derive(Clone, Debug)]
pub struct Samples {
    last: u32,
    middle: f64,
    end: f64,
    forces: Vec<f64>,
}

impl Samples {
    /// Nothing yet but the state at rest.
    pub fn new(case: &Case) -> Self {
        let mut forces = Vec::with_capacity(case.last_quarter() as usize + 1);
        forces.push(0.0);
        Samples { last: case.last_quarter(), middle: 0.0, end: 0.0, forces }
    }

    /// Number of the quarter period that comes next; none after the last.
    pub fn next(&self) -> Option<u32> {
        let next = self.forces.len() as u32;
        (next <= self.last).then_some(next)
    }

    /// The state at that quarter period.
    pub fn push(&mut self, y: &[f64]) {
        self.forces.push(y[2]);
        let number = self.forces.len() as u32 - 1;
        if 2 * number == self.last {
            self.middle = y[3];
        } else if number == self.last {
            self.end = y[3];
        }
    }

    /// The outcome; the quadrature state has grown by half the mean in the second half.
    pub fn outcome(self, wall_ns: f64) -> Outcome {
        Outcome { mean: 2.0 * (self.end - self.middle), forces: self.forces, wall_ns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diffsol_peer::{Diffsol, Method};
    use crate::dop853_peer::Dop853Peer;
    use crate::ode_solvers_peer::Dopri5Peer;
    use crate::ours;
    use crate::reference::Reference;

    /// Every peer solves the same case: at a fine setting it comes near the reference, which none of them made.
    #[test]
    fn peers_agree() {
        let case = Case::new(20);
        let reference = Reference::new(&case).unwrap();
        let near = |mut peer: Box<dyn Peer>, setting: Setting, error: (f64, f64)| {
            let (mean, force) = reference.errors(&peer.run(&case, setting).unwrap());
            println!("{} at {setting}: {mean:.1e} {force:.1e}", peer.name());
            assert!(mean < error.0 && force < error.1, "{} at {setting}: {mean:e} {force:e}", peer.name());
        };
        let tolerance = Setting::Tolerance(1e-10);
        near(Box::new(Diffsol(Method::Tsit45)), tolerance, (2e-10, 1e-8));
        near(Box::new(Diffsol(Method::Bdf)), tolerance, (2e-8, 1e-7));
        near(Box::new(Diffsol(Method::Esdirk34)), tolerance, (2e-8, 2e-7));
        near(Box::new(Dopri5Peer::Events), tolerance, (1e-9, 1e-8));
        near(Box::new(Dopri5Peer::Plain), tolerance, (4e-9, 2e-7));
        near(Box::new(Dop853Peer::AutonomousEvents), tolerance, (1e-10, 3e-10));
        near(Box::new(Dop853Peer::Autonomous), tolerance, (2e-9, 4e-8));
        near(Box::new(&ours::METHODS[0]), Setting::Steps(1000), (1e-8, 3e-6));
    }

    #[test]
    fn a_wrong_node_makes_a_peer_fail() {
        let outcome = Dop853Peer::Plain.run(&Case::new(20), Setting::Tolerance(1e-8));
        assert!(outcome.unwrap_err().to_string().contains("stiff"));
    }
}
