//! Time series on an even grid, with any steps of the method.

use super::sweep::numerics;
use contact::{Method, Numerics, Problem, SolveError, State, solve};

/// Returns the states at each multiple of `every_s` in a part of the run.
pub fn trace(problem: &Problem, every_s: f64, from_s: f64, to_s: f64) -> Result<Vec<State>, SolveError> {
    let moments: Vec<f64> = (0..)
        .map(|index| f64::from(index) * every_s)
        .skip_while(|&at_s| at_s < from_s - 0.5 * every_s)
        .take_while(|&at_s| at_s < to_s + 0.5 * every_s && at_s <= problem.duration_s)
        .collect();
    let mut gridded = problem.clone();
    // A load step to the present load changes nothing, but makes every method stop there.
    gridded.load_steps.extend(moments.iter().filter(|&&at_s| at_s > 0.0).map(|&at_s| (at_s, problem.coulomb_n)));
    let mut states = Vec::with_capacity(moments.len());
    let mut ahead = moments.iter().copied().peekable();
    if ahead.next_if(|&at_s| at_s == 0.0).is_some() {
        states.push(problem.start);
    }
    let same_s = 1e-3 * every_s;
    // A method that steps through the whole run; a closed form would show one steady period.
    let stepping = Numerics { method: Method::Linexp, energies: false, ..numerics() };
    solve(&gridded, &stepping, &mut |state| {
        if ahead.next_if(|&at_s| state.time_s >= at_s - same_s).is_some() {
            states.push(*state);
        }
    })?;
    Ok(states)
}

/// Returns the instantaneous dissipated power, W.
pub fn power_w(problem: &Problem, state: &State) -> f64 {
    state.force_n * (problem.sliding_m_per_s + problem.sign.factor() * state.v_m_per_s)
}

/// Returns the amplitude of the velocity's part at a frequency over time: bin middles, s, and
/// amplitudes, m/s.
pub fn amplitude_over_time(problem: &Problem, hz: f64, bin_s: f64) -> Result<(Vec<f64>, Vec<f64>), SolveError> {
    let omega = std::f64::consts::TAU * hz;
    let bins = (problem.duration_s / bin_s).round() as usize;
    let mut sums = vec![(0.0, 0.0, 0.0); bins];
    let mut last = problem.start;
    // The trapezoidal rule may need more steps than the method; energies are not needed.
    let fine = Numerics { steps_per_period: Some(32), energies: false, ..numerics() };
    solve(problem, &fine, &mut |state| {
        let step_s = state.time_s - last.time_s;
        if let Some((real, imaginary, total_s)) = sums.get_mut((state.time_s / bin_s) as usize) {
            // Trapezoidal rule, with each end at its own phase.
            for end in [&last, state] {
                let (sine, cosine) = (omega * end.time_s).sin_cos();
                *real += 0.5 * step_s * end.v_m_per_s * cosine;
                *imaginary += 0.5 * step_s * end.v_m_per_s * sine;
            }
            *total_s += step_s;
        }
        last = *state;
    })?;
    let middles = (0..bins).map(|bin| (bin as f64 + 0.5) * bin_s).collect();
    let amplitudes = sums.iter().map(|(real, imaginary, total_s)| 2.0 * real.hypot(*imaginary) / total_s).collect();
    Ok((middles, amplitudes))
}
