//! The measured methods, each with step counts that show its range.

use super::rk4_tabulated;
use contact::linexp::Options;
use contact::{Problem, SolveError, State, Tally, linexp, midpoint, rk4, rk4_events, taylor};

/// Runs a problem at a number of steps a period.
pub type Run = fn(&Problem, u32) -> Result<Tally, SolveError>;
/// Runs a problem at a number of steps a period, with a callback for the states.
pub type Watched = fn(&Problem, u32, &mut dyn FnMut(&State)) -> Result<Tally, SolveError>;

/// Role of a method in a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Method that is claimed to be fast.
    Ours,
    /// The thesis's method, unchanged.
    Plain,
    /// The thesis's method, as fast as possible without a change of its results.
    Fair,
    /// Method for comparison only.
    Other,
}

/// Method with its step counts.
pub struct Method {
    /// Name of the method, in one word.
    pub name: &'static str,
    /// Role of the method in a claim.
    pub role: Role,
    /// Function that is timed, without a callback.
    pub run: Run,
    /// Function with a callback for the states.
    pub watched: Watched,
    /// Steps a period; multiples of four, so that every quarter period is the end of a step.
    pub steps: &'static [u32],
    /// Steps a period of a quick measurement.
    pub quick_steps: &'static [u32],
}

impl Method {
    /// Returns the steps a period of a measurement.
    pub fn steps(&self, quick: bool) -> &'static [u32] {
        if quick { self.quick_steps } else { self.steps }
    }
}

/// Finds a method by name.
pub fn by_name(name: &str) -> Option<&'static Method> {
    METHODS.iter().find(|method| method.name == name)
}

/// Builds a method from one call, with and without a callback.
macro_rules! method {
    ($name:literal, $role:ident, $steps:expr, $quick:expr, |$problem:ident, $n:ident, $watch:ident| $call:expr) => {
        Method {
            name: $name,
            role: Role::$role,
            run: |$problem, $n| {
                let $watch = &mut |_: &State| ();
                $call
            },
            watched: |$problem, $n, mut watch| {
                let $watch = &mut watch;
                $call
            },
            steps: &$steps,
            quick_steps: &$quick,
        }
    };
}

/// All methods that are measured.
pub static METHODS: [Method; 13] = [
    method!("linexp-2", Ours, [4, 8, 12, 16, 24, 32, 64, 128, 256], [8, 16, 64], |p, n, w| linexp::run(
        p,
        n,
        2,
        Options::Plain,
        w
    )),
    method!("linexp-4", Ours, [4, 8, 12, 16, 24, 32, 64, 128], [8, 16, 32], |p, n, w| linexp::run(p, n, 4, Options::Plain, w)),
    method!("linexp-6", Ours, [4, 8, 12, 16, 24, 32], [8, 16, 32], |p, n, w| linexp::run(p, n, 6, Options::Plain, w)),
    method!("linexp-10", Ours, [4, 8, 12, 16], [4, 8, 12], |p, n, w| linexp::run(p, n, 10, Options::Plain, w)),
    method!("taylor-8", Ours, [8, 12, 16, 24, 32, 48, 64], [8, 16, 32], |p, n, w| taylor::run_plain(p, n, 8, w)),
    method!("taylor-12", Ours, [8, 12, 16, 20, 24, 32], [8, 16, 24], |p, n, w| taylor::run_plain(p, n, 12, w)),
    method!("taylor-16", Ours, [8, 12, 16, 20], [8, 12, 16], |p, n, w| taylor::run_plain(p, n, 16, w)),
    method!("taylor-20", Ours, [8, 12, 16, 20], [8, 12], |p, n, w| taylor::run_plain(p, n, 20, w)),
    method!("frozen", Other, [8, 16, 32, 64], [8, 16], |p, n, w| linexp::run(p, n, 4, Options::Frozen, w)),
    method!("rk4-plain", Plain, RK4, RK4_QUICK, |p, n, w| rk4::run_plain(p, n, w)),
    method!("rk4-fair", Fair, RK4, RK4_QUICK, |p, n, w| rk4_tabulated::run(p, n, w)),
    method!("rk4-events", Other, [20, 40, 100, 200, 400, 1000, 2000], [40, 100, 400], |p, n, w| rk4_events::run_plain(p, n, w)),
    method!("midpoint", Other, [20, 40, 100, 200, 400, 1000, 2000], [40, 100, 400], |p, n, w| midpoint::run(p, n, w)),
];

const RK4: [u32; 9] = [40, 100, 200, 400, 1000, 2000, 4000, 10_000, 20_000];
const RK4_QUICK: [u32; 5] = [100, 400, 1000, 10_000, 20_000];
