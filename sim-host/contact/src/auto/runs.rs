//! Source of the runs of a solution: computed on request, or batched with those of other problems
//! (`many`).

use super::ladder::Setting;
use crate::SolveError;
use crate::method::Method;
use crate::problem::Problem;
use crate::record::Record;
use crate::tally::{State, Tally};

/// Number of steps between two pauses.
const STEPS_PER_PAUSE: u32 = 1 << 16;

/// Source of runs without an observer.
pub trait Runs {
    /// Runs a problem by a method in a setting. With `accounted`, the energies are added up, too.
    fn run(&self, problem: &Problem, method: Method, setting: Setting, accounted: bool) -> Result<Tally, SolveError>;

    /// Runs a problem without energies, and returns its record, too.
    fn recorded(&self, problem: &Problem, method: Method, setting: Setting) -> Result<(Tally, Record), SolveError>;
}

/// Computes every run on request, with a pause from time to time.
impl Runs for &dyn Fn() {
    fn run(&self, problem: &Problem, method: Method, setting: Setting, accounted: bool) -> Result<Tally, SolveError> {
        let mut count = 0u32;
        method.run(problem, setting, accounted, &mut |_: &State| {
            count = count.wrapping_add(1);
            if count.is_multiple_of(STEPS_PER_PAUSE) {
                self();
            }
        })
    }

    fn recorded(&self, problem: &Problem, method: Method, setting: Setting) -> Result<(Tally, Record), SolveError> {
        let (mut count, mut record) = (0u32, Record::default());
        let tally = method.run(problem, setting, false, &mut |state: &State| {
            count = count.wrapping_add(1);
            if count.is_multiple_of(STEPS_PER_PAUSE) {
                self();
            }
            record.add(state);
        })?;
        Ok((tally, record))
    }
}
