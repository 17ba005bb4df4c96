//! A contact study whose vibration is at an angle to the sliding, in the plane of the contact.

use contact::plane::{self, Direction, Moment, PlaneSolution};
use contact::{Clock, Numerics, Problem, Solution, SolveError, State};

/// What is known of the direction across the sliding beside the solution.
#[derive(Clone, Debug, PartialEq)]
pub struct InPlane {
    /// Root mean square of the friction across the sliding over the window, N.
    pub transverse_rms_n: f64,
    /// The last period, both ends; empty of a study that nobody watches.
    pub last_period: Vec<Moment>,
}

/// Solves the problem; `pause` is called now and then. Whoever watches sees the last period, displacement and velocity in the direction of the vibration
/// and friction along the sliding.
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
