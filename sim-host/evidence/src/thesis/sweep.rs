//! Parallel solution of many problems.

use rayon::prelude::*;

use contact::tally::Ratios;
use contact::{Numerics, Problem, Solution, SolveError, solve};

/// Returns the settings for all problems of the thesis: the cheapest method with an error of the
/// mean friction below 1e-6.
pub fn numerics() -> Numerics {
    Numerics { tolerance: 1e-6, ..Numerics::default() }
}

/// Solves a problem by the automatic method.
pub fn solution(problem: &Problem) -> Result<Solution, SolveError> {
    solve(problem, &numerics(), &mut |_| ())
}

/// Computes the ratios of a problem.
pub fn ratios(problem: &Problem) -> Result<Ratios, SolveError> {
    Ok(solution(problem)?.ratios)
}

/// Computes the friction ratio of a problem without its energies, which do not affect the ratio.
pub fn friction(problem: &Problem) -> Result<f64, SolveError> {
    let lean = Numerics { energies: false, ..numerics() };
    Ok(solve(problem, &lean, &mut |_| ())?.ratios.friction)
}

/// Computes one result for each item, in parallel.
pub fn each<T: Sync, R: Send>(items: &[T], of: impl Fn(&T) -> Result<R, SolveError> + Sync + Send) -> Result<Vec<R>, SolveError> {
    items.par_iter().map(of).collect()
}

/// Computes the points of each curve, all in parallel.
pub fn curves<C: Sync, R: Send>(
    curves: &[C],
    points: &[f64],
    of: impl Fn(&C, f64) -> Result<R, SolveError> + Sync + Send,
) -> Result<Vec<Vec<R>>, SolveError> {
    curves.par_iter().map(|curve| points.par_iter().map(|&point| of(curve, point)).collect()).collect()
}

/// Returns equally spaced values, both ends included.
pub fn spaced(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| from + (to - from) * i as f64 / (count - 1) as f64).collect()
}

/// Returns the velocity ratios of the curves.
pub fn velocity_ratios() -> Vec<f64> {
    spaced(0.025, 1.0, 40)
}

/// Returns values of a geometric series, both ends included.
pub fn geometric(from: f64, to: f64, count: usize) -> Vec<f64> {
    spaced(from.ln(), to.ln(), count).into_iter().map(f64::exp).collect()
}

/// Returns `true` if each value exceeds the one before it.
pub fn rises(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] > pair[0])
}

/// Returns `true` if each value is below the one before it.
pub fn falls(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] < pair[0])
}
