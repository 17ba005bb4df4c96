//! Choice of the method and its settings: the cheapest that meets the tolerance, with the reason
//! and an error estimate.
//!
//! | problem | method | reason |
//! |---|---|---|
//! | kinematic, Coulomb or Dahl, window in the steady state | closed | no steps are needed |
//! | Dahl, Coulomb | linexp | cheapest at every tolerance from 1e-3 to 3e-12 (`evidence precision`) |
//! | Dahl, bristles shorter than round-off | linexp for Coulomb's law | the limit of Dahl's law; gives a note |
//! | LuGre, bristles too short for the steps of Runge-Kutta | midpoint, then rk4-events | bounded at any stiffness |
//! | other LuGre | rk4-events, then midpoint | fourth order, stable above a known number of steps |
//! | LuGre at tight tolerances, and cases that the methods above cannot solve | taylor | round-off accuracy at any stiffness, but expensive |
//!
//! A tolerance of the whole record is met by the Taylor series, whose settings all share the same
//! moments. If the bristles are too stiff for a series, linexp meets it.
//!
//! `frozen` is never chosen: it costs as much as linexp and neglects the coupling. The settings are
//! found by runs on a `ladder`: `refine` estimates the error of each run from the differences
//! between the runs. The coarsest run that meets the tolerance gives the solution. For a long
//! periodic run the settings are compared on a short `pilot` only. `evidence contacts` tests this
//! choice on random contacts.

use std::time::Duration;

mod ladder;
mod many;
mod pilot;
mod refine;
mod runs;
mod steady;
mod stepped;

use super::SolveError;
use super::closed::ClosedForm;
use super::method::Method;
use super::problem::Problem;
use super::tally::{Ratios, State, Tally};
use crate::orbit::Orbit;
pub use ladder::stable_steps;
pub use many::solve_many;
pub(crate) use runs::Runs;

/// Quantity that the tolerance of a contact study limits: the mean friction ratio, or the whole
/// record. Default: mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "schema",
    derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema),
    serde(rename_all = "kebab-case")
)]
pub enum ToleranceOf {
    /// Mean friction ratio over the window.
    #[default]
    Mean,
    /// Whole record from the start: friction over the Coulomb force, displacement and velocity over
    /// their maximum, at every recorded moment.
    Record,
}

/// Method and accuracy with which a problem is to be solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerics {
    /// Integration method that solves the problem.
    pub method: Method,
    /// Steps per period. `None`: the method's default, refined if the tolerance requires it.
    pub steps_per_period: Option<u32>,
    /// Order of the Taylor series or of linexp. `None`: the method's default.
    pub order: Option<u32>,
    /// Largest permitted error of the mean friction ratio or of the record.
    pub tolerance: f64,
    /// Quantity that the tolerance limits.
    pub tolerance_of: ToleranceOf,
    /// `true` if the energies are added up, too, in a separate run. Otherwise only the friction and
    /// power ratios are computed.
    pub energies: bool,
    /// `true` if the run continues after the window, so that peaks and reversals cover the whole
    /// run.
    pub whole_run: bool,
    /// `true` if the means are those of the periodic steady state, over one period, if it is found;
    /// the window has then no effect.
    pub steady: bool,
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
            steady: false,
        }
    }
}

/// Solution of a contact problem, with the settings used.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Method used.
    pub method: Method,
    /// Reason for the choice of this method.
    pub why: String,
    /// Steps per period of the method; `None` in closed form.
    pub steps_per_period: Option<u32>,
    /// Order of the method; `None` if it has a fixed order.
    pub order: Option<u32>,
    /// Friction and power ratios of the solution.
    pub ratios: Ratios,
    /// Sums from which the ratios are computed; `None` in closed form.
    pub tally: Option<Tally>,
    /// Estimated error of the friction ratio, from runs with other steps. In closed form: the
    /// remaining influence of the start.
    pub error_estimate: Option<f64>,
    /// Estimated error of the record, from the same runs; `None` unless the tolerance limits the
    /// record.
    pub record_error_estimate: Option<f64>,
    /// Periodic steady state that the means belong to; `None` for those of a window.
    pub orbit: Option<Orbit>,
    /// `true` if the estimated error is within the tolerance.
    pub tolerance_met: bool,
    /// Warnings for the user, such as a tolerance that is not met.
    pub warnings: Vec<String>,
    /// Number of states that were integrated.
    pub states: usize,
    /// Wall time of the whole solution per period of the problem, ns: choice of the settings, error
    /// estimate, energies and the observer. `None` without a clock.
    pub ns_per_period: Option<f64>,
}

/// Monotonic clock: time since some fixed moment. The caller provides it, so that the library also
/// runs on targets without a clock.
pub type Clock = fn() -> Duration;

/// Error of the closed forms.
const ROUND_OFF: f64 = 1e-14;

/// Solves a problem. `watch` receives the state after every step; in closed form, over one steady
/// period.
///
/// # Errors
/// Fails if the method does not apply to this problem, or if its values grow without bound.
pub fn solve(problem: &Problem, numerics: &Numerics, watch: &mut impl FnMut(&State)) -> Result<Solution, SolveError> {
    solve_with(problem, numerics, &|| (), None, watch)
}

/// Solves a problem as [`solve`] does. `pause` is called from time to time in the unobserved runs.
/// With a `clock`, the whole solution is timed.
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

/// Solves a problem without an observer, so that no run has to be repeated for it.
///
/// # Errors
/// The errors of [`solve`].
pub fn solve_unwatched(problem: &Problem, numerics: &Numerics, pause: &dyn Fn()) -> Result<Solution, SolveError> {
    by_method(problem, numerics, &pause, None::<&mut fn(&State)>)
}

/// Chosen way to solve a problem.
enum Plan {
    /// Closed form of the steady state, with the reason for its choice.
    Closed(ClosedForm, &'static str),
    /// Time steps, by this method; `None`: a method still to be chosen.
    Stepped(Option<Method>),
}

impl Plan {
    fn new(problem: &Problem, numerics: &Numerics) -> Result<Self, SolveError> {
        let unsuited = |method: Method, reason: &str| Err(SolveError::Unsuited { method: method.name(), reason: reason.into() });
        match numerics.method {
            Method::Closed if numerics.tolerance_of == ToleranceOf::Record => {
                unsuited(Method::Closed, "it gives one steady period, not a record from the start; use linexp or taylor")
            }
            Method::Closed if !of_whole_periods(problem) => {
                unsuited(Method::Closed, "the window is not a whole number of periods under one load; linexp accepts any window")
            }
            Method::Closed => Ok(Plan::Closed(ClosedForm::new(problem)?, "requested")),
            Method::Auto => {
                let is_whole = of_whole_periods(problem) || numerics.steady && problem.load_steps.is_empty();
                let may_be_closed = numerics.tolerance_of == ToleranceOf::Mean && problem.waveform.is_periodic() && is_whole;
                let form = may_be_closed.then(|| ClosedForm::new(problem).ok()).flatten();
                // The remaining influence of the start must be far below the tolerance.
                let form = form.filter(|form| start_left(form, problem, numerics) < 0.1 * numerics.tolerance);
                let why = "kinematic, and the window lies in the steady state: closed form";
                Ok(form.map_or(Plan::Stepped(None), |form| Plan::Closed(form, why)))
            }
            Method::Collocation => unsuited(Method::Collocation, "it is for a vibration at an angle to the sliding"),
            method => Ok(Plan::Stepped(Some(method))),
        }
    }
}

/// Returns the influence of the start on the means, as a fraction of Fc.
fn start_left(form: &ClosedForm, problem: &Problem, numerics: &Numerics) -> f64 {
    if numerics.steady { 0.0 } else { form.start_left(problem.window_s.0 * problem.waveform.frequency_hz()) }
}

pub(crate) fn by_method<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    runs: &dyn Runs,
    watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    match Plan::new(problem, numerics)? {
        Plan::Closed(form, why) => Ok(in_closed_form(problem, numerics, &form, why, watch)),
        Plan::Stepped(method) if numerics.steady && numerics.tolerance_of == ToleranceOf::Mean => {
            steady::solve(problem, numerics, method, runs, watch)
        }
        Plan::Stepped(None) => stepped::solve_automatically(problem, numerics, runs, watch),
        Plan::Stepped(Some(method)) => stepped::solve(problem, numerics, (method, "requested".to_owned()), runs, watch),
    }
}

/// Returns the closed form that [`solve`] would use, which describes one steady period; `None` if
/// it would take time steps.
pub fn closed_form(problem: &Problem, numerics: &Numerics) -> Option<ClosedForm> {
    match Plan::new(problem, numerics) {
        Ok(Plan::Closed(form, _)) => Some(form),
        _ => None,
    }
}

/// Returns `true` if the means over the window equal those over a period: the window is a whole
/// number of periods under one load.
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
    let left = start_left(form, problem, numerics);
    let early = format!(
        "the closed form is the steady state, but up to {left:.1e} of the initial difference remains when the window begins"
    );
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
        orbit: None,
        tolerance_met,
        warnings: (!tolerance_met).then_some(early).into_iter().collect(),
        states: 0,
        ns_per_period: None,
    }
}

#[cfg(test)]
mod tests;
