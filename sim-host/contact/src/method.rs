//! The integration methods by name: purpose, initial settings and dispatch.

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
    /// The cheapest method that meets the tolerance.
    #[default]
    Auto,
    /// Steady state in closed form: kinematic, Coulomb or Dahl.
    Closed,
    /// Friction computed on the motion that the oscillator has without friction.
    Frozen,
    /// Exact flow of the linear motion, and friction as an exact function of the slip, coupled at
    /// Gauss-Legendre nodes. For Coulomb friction: exact from reversal to reversal.
    Linexp,
    /// Taylor series of high order with located reversals.
    Taylor,
    /// The thesis's Runge-Kutta method with a fixed step.
    Rk4,
    /// Runge-Kutta with located reversals.
    Rk4Events,
    /// Exponential midpoint rule, with friction as an exact function of the slip, for stiff LuGre
    /// contacts.
    Midpoint,
    /// High-order collocation for a vibration at an angle to the sliding (`excitation.angle_deg`):
    /// one period is solved as a whole.
    Collocation,
}

impl Method {
    /// Returns the name of the method in a scene.
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

    /// Returns the initial number of steps per period; `None` for methods without steps. `kappa` is
    /// the vibration amplitude in Dahl lengths.
    ///
    /// The exponent of friction over one step must stay below one, so the step depends on kappa.
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
            // A step that is too long for the series is split into several.
            Method::Taylor => Some(6),
            Method::Rk4 => Some(1000),
            Method::Rk4Events => Some(by_stiffness(32)),
            Method::Midpoint => Some(by_stiffness(64)),
        }
    }

    /// Returns the method that replaces this one, if it is deprecated: the next version removes it
    /// from scenes.
    pub fn replacement(self) -> Option<Method> {
        match self {
            Method::Frozen => Some(Method::Linexp),
            Method::Rk4 => Some(Method::Rk4Events),
            _ => None,
        }
    }

    /// Returns the initial order; `None` if the method has a fixed order.
    pub fn order(self) -> Option<u32> {
        match self {
            Method::Frozen | Method::Linexp => Some(6),
            Method::Taylor => Some(24),
            _ => None,
        }
    }

    /// Runs a problem. With `accounted`, the energies are added up, too.
    pub fn run(
        self,
        problem: &Problem,
        (steps, order): (u32, Option<u32>),
        accounted: bool,
        watch: &mut dyn FnMut(&State),
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

    /// Returns the number of states that the method integrates.
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
