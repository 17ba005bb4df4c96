//! Contact studies: the effect of vibration on friction, without controller, converter or stack
//! (thesis chapter 4).
//!
//! ```text
//! scene [excitation] --> problem --> timeline (smooth stretches of forcing) --> method --> tally --> ratios
//!                           waveform ^                                            |
//!                                                             closed | frozen | linexp | taylor | rk4 | rk4-events | midpoint
//! ```
//!
//! A [`problem`] is a motion, a friction law and a forcing, in SI units. All methods step through
//! the same [`timeline`] and fill the same [`tally`]. [`auto`](mod@auto) chooses the method that
//! meets a tolerance at the lowest cost.
//!
//! # Example
//!
//! Friction of the thesis's contact (Table 4.1) under longitudinal vibration, at a sliding speed of
//! half the vibration velocity:
//!
//! ```
//! use sonoglide_contact::table_4_1::table_4_1;
//! use sonoglide_contact::{Numerics, solve};
//!
//! let problem = table_4_1(0.5, 200.0); // velocity ratio, periods
//! let solution = solve(&problem, &Numerics::default(), &mut |_state| ())?;
//! let (ratio, error) = (solution.ratios.friction, solution.error_estimate.unwrap());
//! println!("friction ratio {} ± {error:.0e}, by {:?}", ratio, solution.method);
//! assert!((ratio - 0.664_066).abs() < 1e-6 && error < 1e-7);
//! # Ok::<(), sonoglide_contact::SolveError>(())
//! ```
#![forbid(unsafe_code)]

pub mod air_film;
pub mod auto;
pub mod belt_heating;
pub mod closed;
pub mod compliant;
pub mod custom;
pub mod empirical;
pub mod flow;
mod forcing;
pub mod hertz;
pub mod method;
pub mod orbit;
pub mod plane;
pub mod problem;
mod radau;
pub mod record;
mod shooting;
pub mod state;
pub mod table_4_1;
pub mod tally;
pub mod timeline;
mod turn;
pub mod waveform;
pub mod wrap;

pub use auto::{Clock, Numerics, Solution, ToleranceOf, closed_form, solve, solve_many, solve_unwatched, solve_with};
pub use forcing::Forcing;
pub use method::{Method, coulomb, linexp, midpoint, rk4, rk4_events, taylor};
pub use orbit::{Orbit, Unsteady};
pub use problem::{Law, Motion, Problem, Sign};
pub use record::Record;
pub use state::State;
pub use tally::Tally;
pub use waveform::{Shape, Waveform};

/// Reason why a method has no solution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// The method does not apply to this problem.
    #[error("{method} cannot do this: {reason}")]
    Unsuited {
        /// Method name.
        method: &'static str,
        /// Reason, for the user.
        reason: String,
    },
    /// A value grew without bound or became NaN.
    #[error("{method} diverged at {time_s:e} s")]
    Diverged {
        /// Method name.
        method: &'static str,
        /// Time of the divergence, s.
        time_s: f64,
    },
    /// No method has a solution.
    #[error("no method can do this: {reason}; {advice}")]
    Refused {
        /// Reason why every method fails.
        reason: String,
        /// Change that would make the problem solvable.
        advice: String,
    },
}
