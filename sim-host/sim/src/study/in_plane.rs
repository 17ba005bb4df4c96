//! A contact study with vibration at an angle to the sliding, in the plane of the contact.

use contact::plane::{self, Direction, Moment, PlaneSolution};
use contact::{Clock, Numerics, Problem, Solution, SolveError, State};

/// Results for the direction transverse to the sliding, in addition to the solution.
#[derive(Clone, Debug, PartialEq)]
pub struct InPlane {
    /// Root mean square of the friction transverse to the sliding over the window, N.
    pub transverse_rms_n: f64,
    /// Last period including both ends; empty for a study without a watch.
    pub last_period: Vec<Moment>,
}

/// Solves the problem; `pause` is called repeatedly. `watch` receives the last period: displacement
/// and velocity in the direction of the vibration, and friction along the sliding.
pub(super) fn solve<W: FnMut(&State)>(
    problem: &Problem,
    direction: Direction,
    numerics: &Numerics,
    (pause, clock): (&dyn Fn(), Option<Clock>),
    watch: Option<&mut W>,
) -> Result<(Solution, InPlane), SolveError> {
    let found = plane::solve(problem, direction, numerics, (pause, clock), watch.is_some())?;
    let PlaneSolution { solution, transverse_rms_n, last_period } = found;
    if let Some(watch) = watch {
        for moment in &last_period {
            watch(&State {
                time_s: moment.time_s,
                x_m: moment.displacement_m,
                v_m_per_s: moment.vibration_m_per_s,
                force_n: moment.friction_n[0],
            });
        }
    }
    Ok((solution, InPlane { transverse_rms_n, last_period }))
}
