//! Friction laws that a user writes: any internal states, any force, and jumps that are located.
//!
//! ```text
//! z' = rates(z, V, sgn V, Fc),   F = force(z, V, sgn V, Fc)
//! ```
//!
//! A law is a type with the trait [`FrictionLaw`], or text ([`Expression`]). Between two events it
//! is integrated by collocation at the Radau points (`panel`), whose intervals adapt to the
//! solution; each event ends an interval (`run`). Events are the reversals of the slip and the
//! switches of the law. The means are those of the steady state, found by shooting, or of a window
//! of the run.
//!
//! The built-in laws have methods of their own, which are faster.
//!
//! # Example
//!
//! Dahl's law with an exponent of two, under the vibration of Table 4.1:
//!
//! ```
//! use sonoglide_contact::Numerics;
//! use sonoglide_contact::custom::{At, FrictionLaw, solve};
//! use sonoglide_contact::table_4_1::table_4_1;
//!
//! struct Square;
//!
//! impl FrictionLaw for Square {
//!     fn start(&self) -> Vec<f64> {
//!         vec![0.0]
//!     }
//!
//!     fn rates(&self, at: &At, rates: &mut [f64]) -> f64 {
//!         // The sign is constant between two reversals, which the solver locates.
//!         let left = 1.0 - at.states[0] / at.coulomb_n * at.sign;
//!         rates[0] = 5.6e4 * at.slip_m_per_s * left * left;
//!         at.states[0]
//!     }
//! }
//!
//! let numerics = Numerics::default();
//! let problem = table_4_1(0.5, 100.0); // velocity ratio, periods
//! let solution = solve(&problem, &Square, &numerics, (&|| (), None), None)?;
//! assert!(solution.tolerance_met && solution.ratios.friction < 1.0);
//! # Ok::<(), sonoglide_contact::SolveError>(())
//! ```

mod event;
pub mod expression;
mod panel;
mod run;
mod steady;

pub use expression::{Expression, ExpressionError, Source};

use crate::auto::{Numerics, ToleranceOf};
use crate::orbit::{Orbit, Unsteady};
use crate::tally::Ratios;
use crate::{Clock, Method, Motion, Problem, Solution, SolveError, State};
use run::{MIN_INTERVALS_PER_PERIOD, Ran, Start};

/// Factor between the tolerances of two runs whose difference is the error of the coarser one.
const FINER: f64 = 1e-2;
/// Tolerance of an interval, over that of the mean.
const INTERVAL_TOLERANCE_REL: f64 = 0.1;
/// Smallest tolerance of an interval; below it is round-off of stiff motions.
const MIN_INTERVAL_TOLERANCE: f64 = 1e-11;
/// Smallest error that is stated: round-off of the sums.
const ROUND_OFF: f64 = 1e-13;

/// Friction law of a user.
pub trait FrictionLaw {
    /// Returns the values of the internal states at the start; their number is that of the states.
    fn start(&self) -> Vec<f64>;

    /// Computes the rates of the states, per second, and returns the friction, N. Must be smooth
    /// between two events.
    fn rates(&self, at: &At, rates: &mut [f64]) -> f64;

    /// Computes the partial derivatives, if they are known; otherwise differences give them.
    /// For a given motion only those of the rates by the states are needed.
    fn derivatives(&self, _at: &At, _partial: &mut Partial) -> bool {
        false
    }

    /// Returns the positions of the switches at the start; their number is that of the switches.
    fn switches(&self) -> Vec<bool> {
        Vec::new()
    }

    /// Returns the margin of a switch: it changes its position when its margin falls below zero.
    /// The margin may depend on the present position, so that a switch can have hysteresis.
    fn margin(&self, _switch: usize, _at: &At) -> f64 {
        1.0
    }
}

/// Moment at which a law is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct At<'a> {
    /// Slip velocity V, m/s.
    pub slip_m_per_s: f64,
    /// Sign of the slip velocity, one or minus one; constant between two events.
    pub sign: f64,
    /// Coulomb force Fc = mu N, N.
    pub coulomb_n: f64,
    /// Internal states of the law.
    pub states: &'a [f64],
    /// Positions of the switches; constant between two events.
    pub switches: &'a [bool],
}

/// Partial derivatives of a law.
#[derive(Clone, Debug, Default)]
pub struct Partial {
    /// Derivative of rate i by state j, at `i * states + j`.
    pub rates_by_states: Vec<f64>,
    /// Derivatives of the rates by the slip velocity.
    pub rates_by_slip: Vec<f64>,
    /// Derivatives of the friction by the states.
    pub force_by_states: Vec<f64>,
    /// Derivative of the friction by the slip velocity, N s/m.
    pub force_by_slip: f64,
    /// `true` if only `rates_by_states` is needed.
    pub is_motion_given: bool,
}

impl Partial {
    fn new(states: usize) -> Self {
        Partial {
            rates_by_states: vec![0.0; states * states],
            rates_by_slip: vec![0.0; states],
            force_by_states: vec![0.0; states],
            force_by_slip: 0.0,
            is_motion_given: false,
        }
    }
}

/// Solves a problem with a law of a user; the law of the problem itself has no effect. `pause` is
/// called from time to time; `watch` receives the states of the last run, at least 96 a period.
///
/// # Errors
/// If the states grow without bound, or if the law jumps to and fro without a state that holds it.
pub fn solve(
    problem: &Problem,
    law: &dyn FrictionLaw,
    numerics: &Numerics,
    (pause, clock): (&dyn Fn(), Option<Clock>),
    watch: Option<&mut dyn FnMut(&State)>,
) -> Result<Solution, SolveError> {
    let began = clock.map(|clock| clock());
    let periods = problem.duration_s * problem.waveform.frequency_hz();
    let wants_steady = numerics.steady && numerics.tolerance_of == ToleranceOf::Mean;
    let (mut warnings, mut orbit) = (Vec::new(), None);
    let mut span = (problem.clone(), Start::new(problem, law));
    if wants_steady {
        match steady::find(problem, law, pause) {
            Ok((found, start)) => {
                span = (found.period(problem), start);
                orbit = Some(found);
            }
            Err(reason) => warnings.push(missing(reason)),
        }
    }
    let (problem, start) = span;
    let problem = if numerics.whole_run { problem } else { problem.up_to_window() };
    let tolerance = (INTERVAL_TOLERANCE_REL * numerics.tolerance).max(MIN_INTERVAL_TOLERANCE / FINER);
    // Where the intervals are at their longest, only their number makes the runs differ.
    let coarse = run::run(&problem, law, &start, (tolerance, MIN_INTERVALS_PER_PERIOD), pause, None)?;
    let fine = run::run(&problem, law, &start, (FINER * tolerance, 2.0 * MIN_INTERVALS_PER_PERIOD), pause, watch)?;
    let of_coarse = (mean(&fine) - mean(&coarse)).abs();
    // The error of the finer run is at most that of the coarser one.
    let error = of_coarse.max(ROUND_OFF) + orbit.map_or(0.0, |orbit: Orbit| orbit.error);
    let tolerance_met = error <= numerics.tolerance;
    if !tolerance_met {
        warnings.push(format!(
            "the tolerance of {:e} is not met: the error of the friction ratio is {error:.1e}",
            numerics.tolerance
        ));
    }
    Ok(Solution {
        method: Method::Collocation,
        why: format!("a law of your own: {} intervals of collocation, {} events", fine.intervals, fine.events),
        steps_per_period: None,
        order: None,
        ratios: Ratios::of(&problem, &fine.tally),
        tally: Some(fine.tally),
        error_estimate: Some(error),
        record_error_estimate: None,
        orbit,
        tolerance_met,
        warnings,
        states: start.states.len() + if problem.motion == Motion::Kinematic { 0 } else { 2 },
        ns_per_period: clock.zip(began).map(|(clock, began)| (clock() - began).as_secs_f64() * 1e9 / periods),
    })
}

fn mean(ran: &Ran) -> f64 {
    ran.tally.totals.friction_n_s / (ran.tally.coulomb_n * ran.tally.time_s)
}

fn missing(reason: Unsteady) -> String {
    format!("{reason}: the means are those of a window of the run, and may depend on the window")
}

#[cfg(test)]
mod tests;
