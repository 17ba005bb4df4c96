//! Where the runs of a solution come from: made there and then, or beside those of other problems (`many`).

use super::ladder::Setting;
use crate::SolveError;
use crate::method::Method;
use crate::problem::Problem;
use crate::record::Record;
use crate::tally::{State, Tally};

/// Steps between two pauses.
const PAUSE: u32 = 1 << 16;

/// What makes runs without a watch.
pub trait Runs {
    /// The run of a problem by a method in a setting; with `accounted`, the energies are added up, too.
    fn run(&self, problem: &Problem, method: Method, setting: Setting, accounted: bool) -> Result<Tally, SolveError>;

    /// The same without energies, and with its record.
    fn recorded(&self, problem: &Problem, method: Method, setting: Setting) -> Result<(Tally, Record), SolveError>;
}

/// Every run when it is asked for, with a pause now and then.
impl Runs for &dyn Fn() {
    fn run(&self, problem: &Problem, method: Method, setting: Setting, accounted: bool) -> Result<Tally, SolveError> {
        let mut count = 0u32;
        method.run(problem, setting, accounted, &mut |_: &State| {
            count = count.wrapping_add(1);
            if count.is_multiple_of(PAUSE) {
                self();
            }
        })
    }

    fn recorded(&self, problem: &Problem, method: Method, setting: Setting) -> Result<(Tally, Record), SolveError> {
        let (mut count, mut record) = (0u32, Record::default());
        let tally = method.run(problem, setting, false, &mut |state: &State| {
            count = count.wrapping_add(1);
            if count.is_multiple_of(PAUSE) {
                self();
            }
            record.add(state);
        })?;
        Ok((tally, record))
    }
}
