//! Interpolation of states between the steps of a method. Some methods need only sixteen steps per
//! period, which would be drawn as a polygon.
//!
//! Displacement is the cubic that matches position and velocity at both ends of the step; velocity
//! is its derivative. Friction is computed from this motion: Coulomb friction from the sign of the
//! slip velocity, Dahl friction from its exact exponential in slip. LuGre friction is interpolated
//! linearly, because its methods take enough steps. The computed friction misses the known value at
//! the end of the step by a small amount, which is spread linearly over the step.

use contact::{Law, Problem, State};

/// Minimum number of states per period.
const STATES_PER_PERIOD: f64 = 96.0;

/// Returns the states, with interpolated ones where there are too few.
pub(super) fn filled(problem: &Problem, states: &[State]) -> Vec<State> {
    let mut filled: Vec<State> = states.first().copied().into_iter().collect();
    for ends in states.windows(2) {
        if let [from, to] = ends {
            fill(problem, from, to, &mut filled);
            filled.push(*to);
        }
    }
    filled
}

fn fill(problem: &Problem, from: &State, to: &State, filled: &mut Vec<State>) {
    let step_s = to.time_s - from.time_s;
    let parts =
        (step_s * problem.waveform.frequency_hz() * STATES_PER_PERIOD - 1e-6).ceil().clamp(1.0, STATES_PER_PERIOD) as usize;
    if parts == 1 {
        return;
    }
    let coulomb_n = coulomb_n(problem, from.time_s);
    let first = filled.len();
    let mut last = *from;
    for part in 1..=parts {
        let mut state = along(from, to, part as f64 / parts as f64);
        state.force_n = friction(problem, coulomb_n, &last, &state, to);
        filled.push(state);
        last = state;
    }
    // The last interpolated state is the end itself, except for the error of the law.
    let missed_n = to.force_n - last.force_n;
    filled.pop();
    for (index, state) in filled[first..].iter_mut().enumerate() {
        state.force_n += missed_n * (index + 1) as f64 / parts as f64;
    }
}

/// Returns the state at a fraction of the step, with the friction of its beginning.
fn along(from: &State, to: &State, part: f64) -> State {
    let step_s = to.time_s - from.time_s;
    let (a, b, rise) = (step_s * from.v_m_per_s, step_s * to.v_m_per_s, to.x_m - from.x_m);
    // x = x0 + a s + c2 s^2 + c3 s^3, with the slopes a and b at its ends
    let (c2, c3) = (3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise);
    State {
        time_s: from.time_s + part * step_s,
        x_m: from.x_m + part * (a + part * (c2 + part * c3)),
        v_m_per_s: (a + part * (2.0 * c2 + part * 3.0 * c3)) / step_s,
        force_n: from.force_n,
    }
}

/// Returns the friction at a state after `last`, in the step to `end`, N.
fn friction(problem: &Problem, coulomb_n: f64, last: &State, state: &State, end: &State) -> f64 {
    let sign = problem.sign.factor();
    match problem.law {
        Law::Coulomb => coulomb_n * (problem.sliding_m_per_s + sign * state.v_m_per_s).signum(),
        Law::Dahl { stiffness_n_per_m } => {
            let slip_m = problem.sliding_m_per_s * (state.time_s - last.time_s) + sign * (state.x_m - last.x_m);
            let limit_n = coulomb_n * slip_m.signum();
            limit_n + (last.force_n - limit_n) * (-stiffness_n_per_m * slip_m.abs() / coulomb_n).exp()
        }
        Law::Lugre { .. } => {
            let left = (state.time_s - last.time_s) / (end.time_s - last.time_s);
            last.force_n + left * (end.force_n - last.force_n)
        }
    }
}

/// Returns the Coulomb force at a time, N.
pub(super) fn coulomb_n(problem: &Problem, time_s: f64) -> f64 {
    let stepped = problem.load_steps.iter().rfind(|(at_s, _)| *at_s <= time_s);
    stepped.map_or(problem.coulomb_n, |&(_, force)| force)
}

#[cfg(test)]
mod tests {
    use super::*;
    use contact::rk4;
    use contact::table_4_1::table_4_1;

    /// Of 960 steps per period, every 60th is kept; the interpolation is compared with the others.
    #[test]
    fn interpolation_matches_the_omitted_states() {
        for (stiffness_n_per_m, bound) in [(0.056e6, 5e-4), (0.56e6, 7e-3)] {
            let problem = Problem { law: Law::Dahl { stiffness_n_per_m }, ..table_4_1(0.5, 4.0) };
            let mut fine = Vec::new();
            rk4::run(&problem, 960, &mut |state| fine.push(*state)).unwrap();
            let few: Vec<State> = fine.iter().step_by(60).copied().collect();
            let filled = filled(&problem, &few);
            assert_eq!(filled.len(), (few.len() - 1) * 6 + 1);
            let vibration = problem.vibration_m_per_s();
            let (mut velocity, mut friction) = (0.0f64, 0.0f64);
            for (state, truth) in filled.iter().zip(fine.iter().step_by(10)) {
                assert!((state.time_s - truth.time_s).abs() < 1e-15);
                velocity = velocity.max((state.v_m_per_s - truth.v_m_per_s).abs() / vibration);
                friction = friction.max((state.force_n - truth.force_n).abs() / problem.coulomb_n);
            }
            // The errors are 4.6e-4 and 1.7e-4 at the softer contact, and 2.2e-3 at the stiffer.
            assert!(velocity < 1.5e-3 && friction < bound, "{velocity:e} {friction:e}");
        }
    }

    #[test]
    fn dense_states_are_not_changed() {
        let problem = table_4_1(0.5, 4.0);
        let mut fine = Vec::new();
        rk4::run(&problem, 100, &mut |state| fine.push(*state)).unwrap();
        assert_eq!(filled(&problem, &fine), fine);
    }

    #[test]
    fn load_step_changes_the_coulomb_force() {
        let problem = Problem { load_steps: vec![(1e-5, 1.0), (2e-5, 2.0)], ..table_4_1(0.5, 4.0) };
        assert_eq!([0.0, 1e-5, 1.9e-5, 1.0].map(|at| coulomb_n(&problem, at)), [problem.coulomb_n, 1.0, 1.0, 2.0]);
    }
}
