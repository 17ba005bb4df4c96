//! A peer: an integrator, used on a case as well as its interface allows.

use std::fmt;

use crate::case::{Case, Kind};
use crate::scaled::Scaled;

/// An integrator that takes part in the comparison.
pub trait Peer {
    /// Returns the name.
    fn name(&self) -> String;

    /// Returns the origin.
    fn family(&self) -> Family;

    /// Returns the ways to use it on a case.
    fn ways(&self, kind: Kind) -> Vec<Way>;

    /// Solves a case once.
    fn run(&mut self, case: &Case, way: &Way, setting: Setting) -> anyhow::Result<Outcome>;
}

/// A way to use a peer: everything except its accuracy.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Name in tables: method, and treatment of the reversals of the slip.
    pub name: String,
    /// Number by which the peer identifies this way.
    pub number: usize,
    /// Longest step, scaled; `None` leaves it to the peer.
    pub longest: Option<f64>,
    /// Accuracies, from coarse to fine.
    pub settings: Vec<Setting>,
}

impl Way {
    /// Creates a way with its accuracies.
    pub fn new(number: usize, name: impl Into<String>, settings: Vec<Setting>) -> Self {
        Way { name: name.into(), number, longest: None, settings }
    }
}

/// Longest steps that are tried if there is a Stribeck peak, because a long step can miss the peak.
const PEAK_STEPS: [f64; 3] = [0.1, 0.03, 0.01];

/// Adds the same ways with shorter longest steps if there is a Stribeck peak.
pub fn with_longest_steps(kind: Kind, ways: Vec<Way>) -> Vec<Way> {
    if kind != Kind::Lugre {
        return ways;
    }
    let limited = |way: &Way| {
        PEAK_STEPS.map(|longest| Way { name: format!("{}, h <= {longest}", way.name), longest: Some(longest), ..way.clone() })
    };
    let extra: Vec<Way> = ways.iter().flat_map(limited).collect();
    ways.into_iter().chain(extra).collect()
}

/// Origin of a peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// The methods of this project.
    Ours,
    /// A library in Rust.
    Rust,
    /// A compiled program: C, Fortran, or compiled just in time.
    Compiled,
    /// A program mostly in Python; so slow that it runs fewer periods.
    Python,
}

/// Accuracy of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// Absolute and relative tolerance.
    Tolerance(f64),
    /// Constant number of steps per period.
    Steps(u32),
}

impl Setting {
    /// Returns the tolerance.
    ///
    /// # Errors
    /// If the setting is a number of steps.
    pub fn tolerance(self) -> anyhow::Result<f64> {
        match self {
            Setting::Tolerance(tolerance) => Ok(tolerance),
            Setting::Steps(_) => anyhow::bail!("the peer needs a tolerance, not a number of steps"),
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Setting::Tolerance(tolerance) => write!(f, "{tolerance:.0e}"),
            Setting::Steps(steps) => write!(f, "{steps} steps"),
        }
    }
}

/// Returns tolerances half a decade apart, for quick peers.
pub fn fine_tolerances(first: i32, last: i32) -> Vec<Setting> {
    (2 * first..=2 * last).map(|halves| Setting::Tolerance(10f64.powf(-0.5 * f64::from(halves)))).collect()
}

/// Returns tolerances a decade apart.
pub fn tolerances(first: i32, last: i32) -> Vec<Setting> {
    (first..=last).map(|digits| Setting::Tolerance(10f64.powi(-digits))).collect()
}

/// Result of a run.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
pub struct Outcome {
    /// Mean friction ratio over the second half.
    pub mean: f64,
    /// Displacement, velocity and friction at the end, scaled.
    pub end: [f64; 3],
    /// Wall time of the solution, ns.
    pub wall_ns: f64,
}

impl Outcome {
    /// Computes the result from the states at the middle and at the end. In the second half the
    /// quadrature state grows by half the mean.
    pub fn new(scaled: &Scaled, sign: f64, middle: &[f64], end: &[f64], wall_ns: f64) -> Self {
        Outcome { mean: 2.0 * (end[3] - middle[3]), end: [end[0], end[1], scaled.force(sign, end)], wall_ns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::c_peers::Compiled;
    use crate::diffsol_peer::Diffsol;
    use crate::ode_solvers_peer::OdeSolvers;
    use crate::ours::Ours;
    use crate::python_peers::{Heyoka, Scipy};
    use crate::reference::Reference;

    /// Every peer solves the same cases. At fine settings it comes near the reference, which is
    /// independent of all peers.
    #[test]
    fn peers_agree() {
        let folder = std::env::temp_dir().join(format!("peers-{}", std::process::id()));
        let mut peers: Vec<Box<dyn Peer>> = vec![Box::new(Ours), Box::new(Diffsol), Box::new(OdeSolvers)];
        let skipped = |name: &str, error: anyhow::Error| println!("SKIPPED {name}: {error:#}");
        match Heyoka::start("python3") {
            Ok(peer) => peers.push(Box::new(peer)),
            Err(error) => skipped("heyoka", error),
        }
        match Scipy::start("python3") {
            Ok(peer) => peers.push(Box::new(peer)),
            Err(error) => skipped("SciPy", error),
        }
        match Compiled::lsodar(&folder) {
            Ok(peer) => peers.push(Box::new(peer)),
            Err(error) => skipped("LSODAR", error),
        }
        match Compiled::sundials(&folder) {
            Ok(both) => peers.extend(both.map(|peer| Box::new(peer) as Box<dyn Peer>)),
            Err(error) => skipped("CVODE, ERKStep", error),
        }
        for kind in Kind::ALL {
            let case = Case::new(kind, 20);
            let reference = Reference::new(&case).unwrap();
            for peer in &mut peers {
                let mut best = (f64::INFINITY, f64::INFINITY);
                for way in peer.ways(kind) {
                    // The finest settings are left out, because some peers fail there.
                    for &setting in way.settings.iter().rev().skip(2).step_by(3) {
                        let Ok(outcome) = peer.run(&case, &way, setting) else { continue };
                        let (mean, end) = reference.errors(&outcome);
                        best = (best.0.min(mean), best.1.min(end));
                    }
                }
                println!("{kind:?}, {}: {:.1e} {:.1e}", peer.name(), best.0, best.1);
                assert!(best.0 < 1e-9 && best.1 < 1e-8, "{kind:?}, {}: {best:?}", peer.name());
            }
        }
        drop(peers);
        // The folder exists only if something was compiled.
        let _ = std::fs::remove_dir_all(folder);
    }
}
