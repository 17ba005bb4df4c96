//! The methods by name: what each is for, what it starts with, and how it is run.

pub mod bristle;
pub mod coulomb;
pub mod linexp;
pub mod midpoint;
pub mod oscillator;
mod polynomial;
pub mod rates;
pub mod reversal;
pub mod rk4;
pub mod rk4_events;
pub mod rk4_tabulated;
pub mod taylor;

#[cfg(test)]
mod convergence;
#[cfg(test)]
mod energetics;
#[cfg(test)]
mod limits;

use linexp::Options;

use super::SolveError;
use super::problem::{Law, Motion, Problem};
use super::tally::{State, Tally};

/// Method of a contact study.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "schema",
    derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema),
    serde(rename_all = "kebab-case")
)]
pub enum Method {
    /// The cheapest that meets the tolerance.
    #[default]
    Auto,
    /// Steady state in closed form: kinematic, Coulomb or Dahl.
    Closed,
    /// Friction on the motion that the oscillator has without it.
    Frozen,
    /// Exact linear flow, friction exact in slip, coupled at Gauss-Legendre nodes. Of Coulomb friction: exact from reversal to reversal.
    Linexp,
    /// Taylor series of high order with located reversals.
    Taylor,
    /// The thesis's Runge-Kutta of fixed step.
    Rk4,
    /// Runge-Kutta with located reversals.
    Rk4Events,
    /// Exponential midpoint, friction exact in slip, for stiff LuGre contacts.
    Midpoint,
    /// Collocation of high order of a vibration at an angle to the sliding (`excitation.angle_deg`): a period is solved once.
    Collocation,
}

impl Method {
    /// Name of the method in a scene.
    pub fn name(self) -> &'static str {
        match self {
            Method::Auto => "auto",
            Method::Closed => "closed",
            Method::Frozen => "frozen",
            Method::Linexp => "linexp",
            Method::Taylor => "taylor",
            Method::Rk4 => "rk4",
            Method::Rk4Events => "rk4-events",
            Method::Midpoint => "midpoint",
            Method::Collocation => "collocation",
        }
    }

    /// Steps a period to begin with; none in closed form. `kappa` is the vibration amplitude in Dahl lengths.
    ///
    /// Friction's exponent over a step is to be below one, so the step follows from kappa.
    pub fn steps(self, kappa: f64) -> Option<u32> {
        let by_stiffness = |least: u32| match kappa {
            k if k < 1.0 => least,
            k if k < 10.0 => 2 * least,
            k if k < 100.0 => 4 * least,
            _ => 8 * least,
        };
        match self {
            Method::Auto | Method::Closed | Method::Collocation => None,
            Method::Frozen | Method::Linexp => Some(by_stiffness(4)),
            // A step that is too long for the series is several of it.
            Method::Taylor => Some(6),
            Method::Rk4 => Some(1000),
            Method::Rk4Events => Some(by_stiffness(32)),
            Method::Midpoint => Some(by_stiffness(64)),
        }
    }

    /// Order to begin with, where it can be chosen.
    pub fn order(self) -> Option<u32> {
        match self {
            Method::Frozen | Method::Linexp => Some(6),
            Method::Taylor => Some(24),
            _ => None,
        }
    }

    /// Runs a problem; with `accounted`, the energies are added up, too.
    pub fn run(
        self,
        problem: &Problem,
        (steps, order): (u32, Option<u32>),
        accounted: bool,
        watch: &mut impl FnMut(&State),
    ) -> Result<Tally, SolveError> {
        let order = order.or(self.order()).unwrap_or(0);
        let extent = match (self, accounted) {
            (Method::Frozen, _) => Options::Frozen,
            (_, true) => Options::EnergySums,
            (_, false) => Options::Plain,
        };
        match self {
            Method::Linexp if problem.law == Law::Coulomb => coulomb::run(problem, steps, watch),
            Method::Linexp | Method::Frozen => linexp::run(problem, steps, order, extent, watch),
            Method::Taylor if accounted => taylor::run(problem, steps, order, watch),
            Method::Taylor => taylor::run_plain(problem, steps, order, watch),
            Method::Rk4 if accounted => rk4::run(problem, steps, watch),
            Method::Rk4 => rk4::run_plain(problem, steps, watch),
            Method::Rk4Events if accounted => rk4_events::run(problem, steps, watch),
            Method::Rk4Events => rk4_events::run_plain(problem, steps, watch),
            Method::Midpoint => midpoint::run(problem, steps, watch),
            Method::Auto | Method::Closed | Method::Collocation => {
                let reason = "it has no steps".into();
                Err(SolveError::Unsuited { method: self.name(), reason })
            }
        }
    }

    /// States that it integrates.
    pub fn states(self, problem: &Problem) -> usize {
        let motion = match problem.motion {
            Motion::Kinematic => 0,
            Motion::Sdof { .. } => 2,
        };
        match (self, problem.law) {
            (Method::Closed, _) => 0,
            (_, Law::Coulomb) => motion,
            _ => motion + 1,
        }
    }
}
