//! Solutions in the periodic steady state, over one period.

use super::runs::Runs;
use super::{Numerics, ROUND_OFF, Solution, by_method, stepped};
use crate::SolveError;
use crate::method::Method;
use crate::orbit::Orbit;
use crate::problem::Problem;
use crate::state::State;
use crate::tally::Ratios;

/// Minimum number of steps of the period, from which its curves and peaks are taken.
const MIN_STEPS_PER_PERIOD: u32 = 128;

/// Solves one period of the steady state by a method, or by that of the search. Without a steady
/// state, solves the run and warns.
pub fn solve<W: FnMut(&State)>(
    problem: &Problem,
    numerics: &Numerics,
    method: Option<Method>,
    runs: &dyn Runs,
    watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    let transient = Numerics { steady: false, ..*numerics };
    let orbit = match Orbit::new(problem, runs) {
        Ok(orbit) => orbit,
        Err(reason) => {
            let mut solution = by_method(problem, &transient, runs, watch)?;
            solution.warnings.push(format!("{reason}: the means are those of a window of the run, and may depend on the window"));
            return Ok(solution);
        }
    };
    let period = orbit.period(problem);
    let mut solution = match method {
        Some(method) => stepped::solve(&period, &transient, (method, "requested".to_owned()), runs, watch)?,
        None => by_search(&period, &orbit, numerics.energies, watch)?,
    };
    let error = solution.error_estimate.unwrap_or(0.0) + orbit.error;
    if solution.tolerance_met {
        stepped::state_errors(&mut solution, (error, None), numerics.tolerance);
    }
    Ok(Solution { orbit: Some(orbit), error_estimate: Some(error), ..solution })
}

/// Runs a steady period by the method of the search.
fn by_search<W: FnMut(&State)>(
    period: &Problem,
    orbit: &Orbit,
    energies: bool,
    watch: Option<&mut W>,
) -> Result<Solution, SolveError> {
    let (steps, order) = orbit.setting;
    let setting = (steps.max(MIN_STEPS_PER_PERIOD), order);
    let tally = match watch {
        Some(watch) => orbit.method.run(period, setting, energies, watch)?,
        None => orbit.method.run(period, setting, energies, &mut |_: &State| ())?,
    };
    Ok(Solution {
        method: orbit.method,
        why: "steady state: Newton's method on the state at the beginning of a period".to_owned(),
        steps_per_period: Some(setting.0),
        order,
        ratios: Ratios::of(period, &tally),
        tally: Some(tally),
        error_estimate: Some(ROUND_OFF),
        record_error_estimate: None,
        orbit: None,
        tolerance_met: true,
        warnings: Vec::new(),
        states: orbit.method.states(period),
        ns_per_period: None,
    })
}
