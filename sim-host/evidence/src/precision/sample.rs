//! States at the quarter periods of the drive within the window, and their errors against the
//! reference.

use super::method::Watched;
use contact::table_4_1::DRIVE_HZ;
use contact::tally::Ratios;
use contact::{Problem, SolveError, State};

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Sample {
    /// States at the quarter periods of the window.
    pub quarters: Vec<State>,
    /// Mean friction ratio over the window.
    pub mean: f64,
}

/// Errors of a run against the reference, each the largest over the quarter periods.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Error of the friction, over Fc.
    pub force: f64,
    /// Error of the mean friction ratio.
    pub mean: f64,
    /// Error of the displacement, over the largest displacement.
    pub displacement: f64,
}

/// Largest distance from a quarter period, in quarters, that counts as at it; covers the round-off
/// of the clock over a few hundred periods.
const MAX_OFF_QUARTER: f64 = 1e-7;

/// Runs a problem and keeps the states at the quarter periods.
///
/// A method with events also reports the states at reversals; states are selected by time alone.
pub fn take(problem: &Problem, run: Watched, steps: u32) -> Result<Sample, SolveError> {
    let quarter_hz = 4.0 * DRIVE_HZ;
    let first = (problem.window_s.0 * quarter_hz).round();
    let count = (problem.window_s.1 * quarter_hz).round() - first + 1.0;
    let mut quarters = vec![State::default(); count as usize];
    let mut keep = |state: &State| {
        let quarter = state.time_s * quarter_hz;
        let index = quarter.round() - first;
        if (quarter - quarter.round()).abs() < MAX_OFF_QUARTER && index >= 0.0 {
            quarters[(index as usize).min(count as usize - 1)] = *state;
        }
    };
    let tally = run(problem, steps, &mut keep)?;
    Ok(Sample { quarters, mean: Ratios::of(problem, &tally).friction })
}

impl Sample {
    /// Computes the errors of this sample against a reference.
    pub fn errors(&self, reference: &Sample, coulomb_n: f64) -> Errors {
        let pairs = || self.quarters.iter().zip(&reference.quarters);
        let largest = |error: fn(&State, &State) -> f64| pairs().map(|(one, other)| error(one, other)).fold(0.0, f64::max);
        let size = reference.quarters.iter().map(|state| state.x_m.abs()).fold(0.0, f64::max);
        Errors {
            force: largest(|a, b| (a.force_n - b.force_n).abs()) / coulomb_n,
            mean: (self.mean - reference.mean).abs(),
            displacement: largest(|a, b| (a.x_m - b.x_m).abs()) / size,
        }
    }
}
