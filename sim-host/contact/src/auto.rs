//! Which method, and how finely: the cheapest that meets the tolerance, with the reason, and an error estimate.
//!
//! | problem | method | because |
//! |---|---|---|
//! | kinematic, Coulomb or Dahl, window in the steady state | closed | nothing is cheaper than no steps |
//! | Dahl, Coulomb | linexp | cheapest at every tolerance from 1e-3 to 1e-12 (`evidence precision`) |
//! | Dahl, bristles shorter than round-off | linexp of Coulomb's law | its limit, with a note |
//! | LuGre, bristles too short for the steps of Runge-Kutta | midpoint, then rk4-events | bounded at any stiffness |
//! | other LuGre | rk4-events, then midpoint | order four, stable from a number of steps on that is known |
//! | LuGre at tight tolerances, and whatever these have no answer to | taylor | at round-off at any stiffness, and dear |
//!
//! A tolerance of the whole record is met by the Taylor series, all of whose settings have the same moments, and by linexp where bristles are too
//! stiff for a series.
//!
//! `frozen` is never chosen: it costs what linexp costs, and leaves out what linexp has. How finely is found by runs on a
//! `ladder` of settings: `refine` estimates the error of each from how the runs close in on each other. The coarsest that meets the
//! tolerance has the answer; of a long periodic run the settings are compared on a `pilot` alone. `evidence contacts` holds all of
//! it against random contacts.

use std::time::Duration;

mod ladder;
mod many;
mod pilot;
mod refine;
mod runs;
mod stepped;

use super::SolveError;
use super::closed::ClosedForm;
use super::method::Method;
use super::problem::Problem;
use super::tally::{Ratios, State, Tally};
pub use ladder::stable_steps;
pub use many::solve_many;
use runs::Runs;

/// What the tolerance of a contact study is of: the mean friction ratio, or the whole record. Default: mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "schema",
    derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema),
    serde(rename_all = "kebab-case")
)]
pub enum ToleranceOf {
    /// The mean friction ratio over the window.
    #[default]
    Mean,
    /// The whole record, from the start on: friction over the Coulomb force, displacement and velocity over their largest, at every moment that is shown.
    Record,
}

/// How a problem is to be solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerics {
    /// Integration method that solves the problem.
    pub method: Method,
    /// Steps a period; none: the method's own choice, and finer where the tolerance needs it.
    pub steps_per_period: Option<u32>,
    /// Order of the Taylor series, or of linexp; none: the method's own choice.
    pub order: Option<u32>,
    /// Largest error of the mean friction ratio, or of the record.
    pub tolerance: f64,
    /// What the tolerance is of.
    pub tolerance_of: ToleranceOf,
    /// Whether the energies are added up, too, in a run of their own; without them there are friction and power ratio.
    pub energies: bool,
    /// Whether the run goes on behind the window, for the peaks and reversals that are of all of it.
    pub whole_run: bool,
}

impl Default for Numerics {
    fn default() -> Self {
        Numerics {
            method: Method::Auto,
            steps_per_period: None,
            order: None,
            tolerance: 1e-7,
            tolerance_of: ToleranceOf::Mean,
            energies: true,
            whole_run: true,
        }
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
    /// Estimated error of the friction ratio, by runs in other steps; in closed form what is left of the start.
    pub error_estimate: Option<f64>,
    /// Estimated error of the record, by the same runs, where the tolerance is of it.
    pub record_error_estimate: Option<f64>,
    /// Whether the estimated error is within the tolerance.
    pub tolerance_met: bool,
    /// What is wrong with the answer, in words: a tolerance that is not met.
    pub warnings: Vec<String>,
    /// States that were integrated.
    pub states: usize,
    /// Wall time from the question to the answer over the periods run, ns: choice of the settings, error estimate, energies, and whoever
    /// watches. None without a clock.
    pub ns_per_period: Option<f64>,
}

/// A monotonic clock: time since some fixed moment. The library has none of its own, so that it runs where there is none.
pub type Clock = fn() -> Duration;

/// Error of the closed forms.
const ROUND_OFF: f64 = 1e-14;

/// Solves a problem. `watch` sees the state after every step; in closed form, over one steady period.
///
/// # Errors
/// If the method cannot do this problem, or its numbers grow without bound.
pub fn solve(problem: &Problem, numerics: &Numerics, watch: &mut impl FnMut(&State)) -> Result<Solution, SolveError> {
    solve_with(problem, numerics, &|| (), None, watch)
}

/// Solves a problem as [`solve`] does; `pause` is called every now and then in the runs without a watch. With a `clock` all of it is timed.
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
    let began = clock.map(|clock| clock());
    let mut solution = by_method(problem, numerics, &pause, Some(watch))?;
    let periods = problem.duration_s * problem.waveform.frequency_hz();
    solution.ns_per_period = clock.zip(began).map(|(clock, began)| (clock() - began).as_secs_f64() * 1e9 / periods);
    Ok(solution)
}

/// Solves a problem that nobody watches: what a run has found is not run again.
///
/// # Errors
/// The errors of [`solve`].
pub fn solve_unwatched(problem: &Problem, numerics: &Numerics, pause: &dyn Fn()) -> Result<Solution, SolveError> {
    by_method(problem, numerics, &pause, None::<&mut fn(&State)>)
}

/// The way to solve a problem.
enum Plan {
    /// The steady state, with the reason for taking it.
    Closed(ClosedForm, &'static str),
    /// Steps in time, by this method or by one that is chosen.
    Stepped(Option<Method>),
}

impl Plan {
    fn new(problem: &Problem, numerics: &Numerics) -> Result<Self, SolveError> {
        let unsuited = |method: Method, reason: &str| Err(SolveError::Unsuited { method: method.name(), reason: reason.into() });
        match numerics.method {
            Method::Closed if numerics.tolerance_of == ToleranceOf::Record => {
                unsuited(Method::Closed, "it has one steady period, and no record from the start on; linexp and taylor have")
            }
            Method::Closed if !of_whole_periods(problem) => {
                unsuited(Method::Closed, "the window is not whole periods under one load; linexp has any window")
            }
            Method::Closed => Ok(Plan::Closed(ClosedForm::new(problem)?, "asked for")),
            Method::Auto => {
                let may_be_closed =
                    numerics.tolerance_of == ToleranceOf::Mean && problem.waveform.is_periodic() && of_whole_periods(problem);
                let form = may_be_closed.then(|| ClosedForm::new(problem).ok()).flatten();
                // The rest of the start is far below the tolerance.
                let form = form.filter(|form| form.start_left(periods_before(problem)) < 0.1 * numerics.tolerance);
                let why = "kinematic, and the window lies in the steady state: closed form";
                Ok(form.map_or(Plan::Stepped(None), |form| Plan::Closed(form, why)))
            }
            Method::Collocation => unsuited(Method::Collocation, "it is for a vibration at an angle to the sliding"),
            method => Ok(Plan::Stepped(Some(method))),
        }
    }
}

/// Periods before the window.
fn periods_before(problem: &Problem) -> f64 {
    problem.window_s.0 * problem.waveform.frequency_hz()
}

fn by_method<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    runs: &dyn Runs,
    watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    match Plan::new(problem, numerics)? {
        Plan::Closed(form, why) => Ok(in_closed_form(problem, numerics, &form, why, watch)),
        Plan::Stepped(None) => stepped::chosen(problem, numerics, runs, watch),
        Plan::Stepped(Some(method)) => stepped::solve(problem, numerics, (method, "asked for".to_owned()), runs, watch),
    }
}

/// Returns the closed form by which [`solve`] solves a problem: it shows one steady period. None if it takes steps.
pub fn closed_form(problem: &Problem, numerics: &Numerics) -> Option<ClosedForm> {
    match Plan::new(problem, numerics) {
        Ok(Plan::Closed(form, _)) => Some(form),
        _ => None,
    }
}

/// Whether the means of a window are those of a period: it is whole periods, all under one load.
pub(crate) fn of_whole_periods(problem: &Problem) -> bool {
    let (from, to) = (problem.window_s.0 * problem.waveform.frequency_hz(), problem.window_s.1 * problem.waveform.frequency_hz());
    (to - from - (to - from).round()).abs() < 1e-9 * to && problem.load_steps.is_empty()
}

fn in_closed_form<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    form: &ClosedForm,
    why: &str,
    watch: Option<&mut W>,
) -> Solution {
    if let Some(watch) = watch {
        form.show(problem, watch);
    }
    let left = form.start_left(periods_before(problem));
    let early = format!("the window begins before the steady state, which this is: up to {left:.1e} of the start is left there");
    let tolerance_met = left.max(ROUND_OFF) <= numerics.tolerance;
    Solution {
        method: Method::Closed,
        why: why.to_owned(),
        steps_per_period: None,
        order: None,
        ratios: form.ratios(),
        tally: None,
        error_estimate: Some(left.max(ROUND_OFF)),
        record_error_estimate: None,
        tolerance_met,
        warnings: (!tolerance_met).then_some(early).into_iter().collect(),
        states: 0,
        ns_per_period: None,
    }
}

#[cfg(test)]
mod tests;
