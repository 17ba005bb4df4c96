//! Contact studies: what vibration does to friction, without a controller, converter or stack (thesis chapter 4).
//!
//! ```text
//! scene [excitation] --> problem --> timeline (smooth stretches of forcing) --> method --> tally --> ratios
//!                           waveform ^                                            |
//!                                                             closed | frozen | linexp | taylor | rk4 | rk4-events | midpoint
//! ```
//!
//! A [`problem`] is a motion, a friction law and a forcing, in SI units. Every method walks the same [`timeline`] and fills the same
//! [`tally`]; which one meets a tolerance at the least cost is chosen in [`auto`](mod@auto).
//!
//! # Example
//!
//! How much does a longitudinal vibration lower the friction of the thesis's contact (Table 4.1), at half its vibration velocity?
//!
//! ```
//! use sonoglide_contact::table_4_1::table_4_1;
//! use sonoglide_contact::{Numerics, solve};
//!
//! let problem = table_4_1(0.5, 200.0); // velocity ratio, periods
//! let solution = solve(&problem, &Numerics::default(), &mut |_state| ())?;
//! let (ratio, error) = (solution.ratios.friction, solution.error_estimate.unwrap());
//! println!("{} of the friction is left, ± {error:.0e}, by {:?}", ratio, solution.method);
//! assert!((ratio - 0.664_066).abs() < 1e-6 && error < 1e-7);
//! # Ok::<(), sonoglide_contact::SolveError>(())
//! ```
#![forbid(unsafe_code)]

pub mod air_film;
pub mod auto;
pub mod belt_heating;
pub mod closed;
pub mod compliant;
pub mod empirical;
pub mod flow;
mod forcing;
pub mod hertz;
pub mod method;
pub mod plane;
pub mod problem;
pub mod record;
pub mod state;
pub mod table_4_1;
pub mod tally;
pub mod timeline;
mod turn;
pub mod waveform;
pub mod wrap;

pub use auto::{Clock, Numerics, Solution, ToleranceOf, closed_form, solve, solve_many, solve_unwatched, solve_with};
pub use forcing::Forcing;
pub use method::{Method, coulomb, linexp, midpoint, rk4, rk4_events, rk4_tabulated, taylor};
pub use problem::{Law, Motion, Problem, Sign};
pub use record::Record;
pub use state::State;
pub use tally::Tally;
pub use waveform::{Shape, Waveform};

/// Why a method has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// The method is not made for this problem.
    #[error("{method} cannot do this: {reason}")]
    Unsuited {
        /// The method.
        method: &'static str,
        /// What it lacks.
        reason: String,
    },
    /// The numbers grew without bound or became no numbers at all.
    #[error("{method} diverged at {time_s:e} s")]
    Diverged {
        /// The method.
        method: &'static str,
        /// When, s.
        time_s: f64,
    },
    /// No method has an answer.
    #[error("no method can do this: {reason}; {advice}")]
    Refused {
        /// What every method fails at.
        reason: String,
        /// What to change.
        advice: String,
    },
}
