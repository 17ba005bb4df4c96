//! The truth that errors are measured against, and what speaks for it.
//!
//! Taylor series of orders 32 and 28 at different steps must agree to 1e-12; and a method that shares nothing with them but the
//! problem, Runge-Kutta with located reversals at a fine step, must agree with them to what it can.

use super::method::Watched;
use super::sample::{Errors, Sample, take};
use contact::{Problem, SolveError, rk4_events, taylor};

/// The two settings of the series: steps a period and order.
pub const SETTINGS: [(u32, u32); 2] = [(24, 32), (16, 28)];
/// The most they may differ by.
pub const AGREEMENT: f64 = 1e-12;
/// Steps a period of the independent method; its own error there, of order four, is below round-off's share.
pub const INDEPENDENT_STEPS: u32 = 2000;
/// The most it may differ by: some 1e-12 of round-off over the 400 000 steps of the standard case.
pub const INDEPENDENT_AGREEMENT: f64 = 1e-11;

/// The reference and its credentials.
#[derive(Clone, Debug)]
pub struct Reference {
    /// States of the reference at the quarter periods.
    pub sample: Sample,
    /// How far the other setting of the series is.
    pub settings: Errors,
    /// How far the independent method is.
    pub independent: Errors,
}

/// Why there is no reference.
#[derive(Debug, thiserror::Error)]
pub enum NoReference {
    /// A run of the reference failed.
    #[error(transparent)]
    SolveError(#[from] SolveError),
    /// The runs do not agree.
    #[error(
        "the reference is not to be trusted: its two settings differ by {settings:?}, the independent method by {independent:?}"
    )]
    Disagreement {
        /// Between the two settings.
        settings: Errors,
        /// Between the series and the independent method.
        independent: Errors,
    },
}

/// Makes the reference of a problem, and refuses one that does not agree.
pub fn make(problem: &Problem) -> Result<Reference, NoReference> {
    let sample = take(problem, FINE, SETTINGS[0].0)?;
    let settings = take(problem, OTHER, SETTINGS[1].0)?.errors(&sample, problem.coulomb_n);
    let independent = take(problem, INDEPENDENT, INDEPENDENT_STEPS)?.errors(&sample, problem.coulomb_n);
    let largest = |errors: &Errors| errors.force.max(errors.mean).max(errors.displacement);
    // A comparison that fails on what is no number, too.
    if largest(&settings) <= AGREEMENT && largest(&independent) <= INDEPENDENT_AGREEMENT {
        Ok(Reference { sample, settings, independent })
    } else {
        Err(NoReference::Disagreement { settings, independent })
    }
}

const FINE: Watched = |problem, n, mut watch| taylor::run(problem, n, SETTINGS[0].1, &mut watch);
const OTHER: Watched = |problem, n, mut watch| taylor::run(problem, n, SETTINGS[1].1, &mut watch);
const INDEPENDENT: Watched = |problem, n, mut watch| rk4_events::run(problem, n, &mut watch);

#[cfg(test)]
mod tests {
    use super::*;
    use contact::Law;
    use contact::table_4_1::{CONTACT_N_PER_M, standard, table_4_1};

    #[test]
    fn the_standard_case_has_a_reference() {
        let reference = make(&standard()).unwrap();
        // Another program, in 34 digits: 0.664066.
        assert!((reference.sample.mean - 0.664_066).abs() < 5e-7);
        assert_eq!(reference.sample.quarters.len(), 401);
    }

    #[test]
    fn what_does_not_agree_is_refused() {
        // A contact so stiff that 2000 steps of the independent method are far too few.
        let law = Law::Dahl { stiffness_n_per_m: 1e3 * CONTACT_N_PER_M };
        assert!(make(&Problem { law, ..table_4_1(0.5, 20.0) }).is_err());
    }
}
