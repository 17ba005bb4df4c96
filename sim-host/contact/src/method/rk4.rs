//! The thesis's method: classical fourth-order Runge-Kutta with a fixed step and the sign function
//! in the right-hand side (4.2).
//!
//! At a reversal of the slip the right-hand side has a corner, so the order is two. At a jump of
//! the forcing the last stage already samples the value after it, so the order is one. Nothing here
//! is chosen for accuracy: this is the baseline.
//!
//! | entry | integrated states | forcing |
//! |---|---|---|
//! | [`run`] | all integrals of the tally | the waveform, three times per step |
//! | [`run_plain`] | those of the thesis's solver: x, x', f and the mean | the same |

use super::rates::{FULL_STATES, LEAN_STATES, Rates, totals};
use crate::SolveError;
use crate::problem::{Law, Problem};
use crate::tally::{Meter, State, Tally};
use crate::timeline::Timeline;

const METHOD: &str = "rk4";

/// Runs a problem with a number of steps per period; `watch` receives the state after every step.
pub fn run(problem: &Problem, steps_per_period: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
    go::<FULL_STATES>(problem, steps_per_period, watch)
}

/// Runs a problem without the integrals of the energies, for timing. These and the peaks are zero
/// in the tally.
pub fn run_plain(problem: &Problem, steps_per_period: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
    go::<LEAN_STATES>(problem, steps_per_period, watch)
}

fn go<const N: usize>(problem: &Problem, steps_per_period: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
    if problem.law == Law::Coulomb {
        let reason = "Coulomb friction has a jump at every reversal, which needs located events".into();
        return Err(SolveError::Unsuited { method: METHOD, reason });
    }
    let (mut rates, mut y) = Rates::new::<N>(problem);
    let mut meter = Meter::new(N == FULL_STATES);
    let mut state = problem.start;
    let mut timeline = Timeline::new(problem).peekable();
    while let Some(stretch) = timeline.next() {
        if let Some(force) = stretch.load {
            rates.load(&mut y, force);
        }
        let forcing = |s: f64| stretch.forcing.value(s);
        let beyond = timeline.peek().map_or(forcing(stretch.length_s), |next| next.forcing.value(0.0));
        state = rates.state(&y, forcing(0.0), stretch.start_s);
        meter.totals = totals(&y);
        meter.at(&stretch, &state, rates.coulomb_n);
        let steps = stretch.steps(steps_per_period);
        let h = stretch.length_s / f64::from(steps);
        for step in 0..steps {
            let s = f64::from(step) * h;
            let at_end = if step + 1 == steps { beyond } else { forcing(s + h) };
            let first = rates.derivatives(&y, forcing(s), f64::abs);
            y = rates.step(&y, &first, h, (forcing(s + 0.5 * h), at_end), f64::abs);
            let time_s = stretch.start_s + f64::from(step + 1) * h;
            if rates.escaped(&y) {
                return Err(SolveError::Diverged { method: METHOD, time_s });
            }
            state = rates.state(&y, at_end, time_s);
            if N == FULL_STATES {
                meter.step(&state, state.force_n / rates.coulomb_n);
            } else {
                meter.tally.steps += 1;
            }
            watch(&state);
        }
    }
    meter.totals = totals(&y);
    Ok(meter.finish(&state, rates.coulomb_n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table_4_1::table_4_1;
    use crate::tally::Ratios;

    #[test]
    fn plain_steps_are_bit_for_bit_those_with_integrals() {
        let problem = table_4_1(0.5, 20.0);
        let (mut one, mut other) = (Vec::new(), Vec::new());
        let plain = run_plain(&problem, 100, &mut |state| one.push(*state)).unwrap();
        let full = run(&problem, 100, &mut |state| other.push(*state)).unwrap();
        assert_eq!((one, plain.totals.friction_n_s), (other, full.totals.friction_n_s));
        // Only the full run gives the energy residual, which is within the method's error at so few
        // steps.
        let residual = Ratios::of(&problem, &full).energy_residual.unwrap();
        println!("{residual:e}");
        assert!(residual.abs() < 2e-5);
    }

    #[test]
    fn diverging_runs_are_reported() {
        for factor in [3e3, 1e4, 1e6] {
            let mut problem = table_4_1(0.5, 20.0);
            problem.law = Law::Dahl { stiffness_n_per_m: factor * 0.056e6 };
            let result = run(&problem, 1000, &mut |_| ());
            assert!(matches!(result, Err(SolveError::Diverged { .. })), "{factor}: {result:?}");
        }
        for factor in [1e-6, 1e-12] {
            let problem = Problem { coulomb_n: factor * 0.01962, ..table_4_1(0.5, 20.0) };
            let result = run(&problem, 1000, &mut |_| ());
            assert!(matches!(result, Err(SolveError::Diverged { .. })), "{factor}: {result:?}");
        }
    }
}
