//! Which method, and how finely: the cheapest that meets the tolerance, with the reason, and an error estimate.
//!
//! | problem | method | because |
//! |---|---|---|
//! | kinematic, Coulomb or Dahl, window in the steady state | closed | nothing is cheaper than no steps |
//! | Dahl, Coulomb | linexp | cheapest at every tolerance from 1e-3 to 1e-12 (`sim-host validate precision`) |
//! | LuGre with stiff bristles or a fast Stribeck curve | midpoint | bounded at any stiffness |
//! | other LuGre | rk4-events | order four, and no restriction to slip |
//!
//! `frozen` is never chosen: it costs what linexp costs, and leaves out what linexp has. The step is halved until the friction ratio of
//! one step and that of the half step agree within the tolerance; the half step's is the answer, and that difference its error estimate.

use std::time::Duration;

use super::closed;
use super::method::Method;
use super::problem::{Law, Motion, Problem};
use super::tally::{Ratios, State, Tally};
use super::{Shape, SolveError};

/// How a problem is to be solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerics {
    /// Integration method that solves the problem.
    pub method: Method,
    /// Steps a period; none: the method's own choice, and finer where the tolerance needs it.
    pub steps_per_period: Option<u32>,
    /// Order of the Taylor series, or of linexp; none: the method's own choice.
    pub order: Option<u32>,
    /// Largest error of the mean friction ratio.
    pub tolerance: f64,
    /// Whether the energies are added up, too, in a run of their own; without them there are friction and power ratio.
    pub energies: bool,
}

impl Default for Numerics {
    fn default() -> Self {
        Numerics { method: Method::Auto, steps_per_period: None, order: None, tolerance: 1e-7, energies: true }
    }
}

/// Solution of a contact problem, with the settings that it was solved by.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The method that was used.
    pub method: Method,
    /// Why this one, in words.
    pub why: String,
    /// Steps per period of the method; none in closed form.
    pub steps_per_period: Option<u32>,
    /// Order of the method, where it can be chosen.
    pub order: Option<u32>,
    /// Friction and power ratios of the solution.
    pub ratios: Ratios,
    /// The sums behind them; none in closed form.
    pub tally: Option<Tally>,
    /// How far the friction ratio is from that of half the step; in closed form what is left of the start.
    pub error_estimate: Option<f64>,
    /// What is wrong with the answer, in words: a tolerance that is not met.
    pub warnings: Vec<String>,
    /// States that were integrated.
    pub states: usize,
    /// Wall time of the solution by itself, without error estimate and energy account, over the periods run, ns. None without a clock.
    pub ns_per_period: Option<f64>,
}

/// A monotonic clock: time since some fixed moment. The library has none of its own, so that it runs where there is none.
pub type Clock = fn() -> Duration;

/// Finest step that is tried, per period.
const FINEST: u32 = 1 << 14;
/// Error of the closed forms, and of a mean over many steps.
const ROUND_OFF: f64 = 1e-14;
const ROUND_OFF_OF_SUMS: f64 = 1e-13;
/// A run is timed again until this much time has gone by, s, or this many times.
const TIMED_S: f64 = 1e-3;
const TIMED: u32 = 5;

/// Solves a problem. `watch` sees the state after every step; in closed form, over one steady period.
///
/// # Errors
/// If the method cannot do this problem, or its numbers grow without bound.
pub fn solve(problem: &Problem, numerics: &Numerics, watch: &mut impl FnMut(&State)) -> Result<Solution, SolveError> {
    solve_with(problem, numerics, &|| (), None, watch)
}

/// Solves a problem as [`solve`] does; `pause` is called every now and then in the runs without a watch. With a `clock` the solution is
/// timed, for which short runs are repeated.
///
/// # Errors
/// The errors of [`solve`].
pub fn solve_with(
    problem: &Problem,
    numerics: &Numerics,
    pause: &dyn Fn(),
    clock: Option<Clock>,
    watch: &mut impl FnMut(&State),
) -> Result<Solution, SolveError> {
    let (method, why) = match numerics.method {
        Method::Auto => choice(problem, numerics.tolerance),
        method => (method, "asked for".to_owned()),
    };
    match method {
        Method::Closed => in_closed_form(problem, numerics, why, clock, watch),
        _ => in_steps(problem, numerics, (method, why), (pause, clock), watch),
    }
}

/// The cheapest method for a problem.
fn choice(problem: &Problem, tolerance: f64) -> (Method, String) {
    let kappa = problem.kappa();
    match problem.law {
        Law::Coulomb | Law::Dahl { .. } if is_steady(problem, tolerance) => {
            (Method::Closed, "kinematic, and the window lies in the steady state: closed form".into())
        }
        Law::Coulomb => (Method::Linexp, "Coulomb friction: exact from reversal to reversal".into()),
        Law::Dahl { .. } => (Method::Linexp, format!("Dahl friction, kappa {kappa:.3}: exact flow, friction exact in slip")),
        Law::Lugre { .. } if is_stiff(problem) => {
            (Method::Midpoint, format!("stiff bristles, kappa {kappa:.0}: friction exact in slip at the midpoint"))
        }
        Law::Lugre { .. } => (Method::Rk4Events, "LuGre friction that is not stiff: Runge-Kutta with located reversals".into()),
    }
}

/// The point of a problem that [`solve`] solves in closed form and whose vibration is a sine: many of these are solved at once in
/// [`lanes`](super::lanes). None of any other problem.
pub fn closed_point(problem: &Problem, numerics: &Numerics) -> Option<closed::Point> {
    let point = closed::Point::of(problem).filter(|_| of_whole_periods(problem))?;
    let from = problem.window_s.0 * problem.waveform.frequency_hz();
    let closed = match numerics.method {
        Method::Auto => has_settled(point.start_left(from), numerics.tolerance),
        method => method == Method::Closed,
    };
    closed.then_some(point)
}

/// Whether what is left of the start is nothing beside the tolerance.
fn has_settled(start_left: f64, tolerance: f64) -> bool {
    start_left < 0.1 * tolerance
}

/// Whether the window is whole periods of a steady state.
fn is_steady(problem: &Problem, tolerance: f64) -> bool {
    let periodic = matches!(problem.waveform.shape(), Shape::Sine | Shape::Square | Shape::Sawtooth | Shape::Triangle);
    if problem.motion != Motion::Kinematic || !periodic || !of_whole_periods(problem) {
        return false;
    }
    let from = problem.window_s.0 * problem.waveform.frequency_hz();
    closed::solve(problem, &mut |_| ()).is_ok_and(|form| has_settled(form.start_left(from), tolerance))
}

/// Whether the means of a window are those of a period: it is whole periods, all under one load.
fn of_whole_periods(problem: &Problem) -> bool {
    let (from, to) = (problem.window_s.0 * problem.waveform.frequency_hz(), problem.window_s.1 * problem.waveform.frequency_hz());
    (to - from - (to - from).round()).abs() < 1e-9 * to && problem.load_steps.is_empty()
}

/// Whether steps that resolve the motion do not resolve the bristles.
fn is_stiff(problem: &Problem) -> bool {
    let fast_stribeck = match problem.law {
        Law::Lugre { static_ratio, stribeck_m_per_s, .. } => {
            static_ratio > 1.0 && stribeck_m_per_s < 1e-3 * problem.vibration_m_per_s()
        }
        _ => false,
    };
    problem.kappa() > 50.0 || fast_stribeck
}

fn in_closed_form(
    problem: &Problem,
    numerics: &Numerics,
    why: String,
    clock: Option<Clock>,
    watch: &mut impl FnMut(&State),
) -> Result<Solution, SolveError> {
    if !of_whole_periods(problem) {
        let reason = "the window is not whole periods under one load; linexp has any window".into();
        return Err(SolveError::Unsuited { method: Method::Closed.name(), reason });
    }
    let ns = clock.map(|clock| timed(clock, || closed::solve(problem, &mut |_| ()))).transpose()?;
    let form = closed::solve(problem, watch)?;
    let left = form.start_left(problem.window_s.0 * problem.waveform.frequency_hz());
    let early = format!("the window begins before the steady state, which this is: up to {left:.1e} of the start is left there");
    Ok(Solution {
        method: Method::Closed,
        why,
        steps_per_period: None,
        order: None,
        ratios: form.ratios,
        tally: None,
        error_estimate: Some(left.max(ROUND_OFF)),
        warnings: (left > numerics.tolerance).then_some(early).into_iter().collect(),
        states: 0,
        // All periods are one.
        ns_per_period: ns.map(|ns| ns / (problem.duration_s * problem.waveform.frequency_hz())),
    })
}

/// Steps between two pauses.
const PAUSE: u32 = 1 << 16;

fn in_steps(
    problem: &Problem,
    numerics: &Numerics,
    (method, why): (Method, String),
    (pause, clock): (&dyn Fn(), Option<Clock>),
    watch: &mut impl FnMut(&State),
) -> Result<Solution, SolveError> {
    let order = numerics.order.or(method.order()).filter(|_| problem.law != Law::Coulomb && method.order().is_some());
    let ratio = |tally: &Tally| Ratios::of(problem, tally).friction;
    let by = |method: Method, steps: u32| {
        let mut count = 0u32;
        method.run(problem, (steps, order), false, &mut |_: &State| {
            count = count.wrapping_add(1);
            if count.is_multiple_of(PAUSE) {
                pause();
            }
        })
    };
    let run = |steps: u32| by(method, steps);
    let given = numerics.steps_per_period;
    let may_refine = given.is_none() && method != Method::Rk4;
    let mut steps = given.or(method.steps(problem.kappa())).unwrap_or(1);
    let mut coarse = run(steps);
    // A step that is too coarse may diverge where a finer one does not.
    while may_refine && matches!(coarse, Err(SolveError::Diverged { .. })) && 4 * steps <= FINEST {
        steps *= 2;
        coarse = run(steps);
    }
    let (mut coarse, mut fine) = (coarse?, run(2 * steps)?);
    while may_refine && (ratio(&coarse) - ratio(&fine)).abs() > numerics.tolerance && 4 * steps <= FINEST {
        steps *= 2;
        (coarse, fine) = (fine, run(2 * steps)?);
    }
    let mut estimate = (ratio(&coarse) - ratio(&fine)).abs().max(ROUND_OFF_OF_SUMS);
    // What was asked for is what is shown; of what was found, the finer.
    let (steps, tally) = if may_refine { (2 * steps, fine) } else { (steps, coarse) };
    let mut warnings = Vec::new();
    if method == Method::Frozen {
        let left_out = (ratio(&tally) - ratio(&by(Method::Linexp, steps)?)).abs();
        warnings
            .push(format!("what friction does to the motion is left out; with it the friction ratio moves by {left_out:.1e}"));
        estimate += left_out;
    }
    if estimate > numerics.tolerance {
        let asked = numerics.tolerance;
        warnings.push(format!("the tolerance of {asked:e} is not met: the friction ratio is good to {estimate:.1e}"));
    }
    let ns = clock.map(|clock| timed(clock, || run(steps))).transpose()?;
    // What is shown and accounted for is the same run, once more.
    let accounted = method.run(problem, (steps, order), numerics.energies, watch)?;
    let (plain, full) = (Ratios::of(problem, &tally), Ratios::of(problem, &accounted));
    Ok(Solution {
        method,
        why,
        steps_per_period: Some(steps),
        order,
        ratios: Ratios { friction: plain.friction, power: plain.power.or(full.power), ..full },
        tally: Some(accounted),
        error_estimate: Some(estimate),
        warnings,
        states: method.states(problem),
        ns_per_period: ns.map(|ns| ns / (problem.duration_s * problem.waveform.frequency_hz())),
    })
}

/// The least time that an answer took, ns.
fn timed<T>(clock: Clock, mut run: impl FnMut() -> Result<T, SolveError>) -> Result<f64, SolveError> {
    let began = clock();
    let mut least = f64::INFINITY;
    let mut times = 0;
    loop {
        let start = clock();
        run()?;
        least = least.min((clock() - start).as_secs_f64() * 1e9);
        times += 1;
        if times >= TIMED || (clock() - began).as_secs_f64() > TIMED_S {
            return Ok(least);
        }
    }
}

#[cfg(test)]
mod tests;
