//! The reference for the errors, and the checks that support it.
//!
//! Taylor series of orders 32 and 28 at different steps must agree to 1e-12. Runge-Kutta with
//! located reversals at a fine step shares only the problem with them and must agree within its own
//! accuracy.

use super::method::Watched;
use super::sample::{Errors, Sample, take};
use contact::{Problem, SolveError, rk4_events, taylor};

/// Both settings of the series: steps a period and order.
pub const SETTINGS: [(u32, u32); 2] = [(24, 32), (16, 28)];
/// Largest difference between the two settings.
pub const MAX_SETTINGS_DIFFERENCE: f64 = 1e-12;
/// Steps a period of the independent method; here its error of order four is smaller than
/// round-off.
pub const INDEPENDENT_STEPS: u32 = 2000;
/// Largest difference to the independent method: about 1e-12 of round-off over the 400 000 steps of
/// the standard case, with a margin.
pub const MAX_INDEPENDENT_DIFFERENCE: f64 = 1e-11;

/// Reference with its checks.
#[derive(Clone, Debug)]
pub struct Reference {
    /// States of the reference at the quarter periods.
    pub sample: Sample,
    /// Differences to the other setting of the series.
    pub settings: Errors,
    /// Differences to the independent method.
    pub independent: Errors,
}

/// Reason why there is no reference.
#[derive(Debug, thiserror::Error)]
pub enum NoReference {
    /// A run of the reference failed.
    #[error(transparent)]
    SolveError(#[from] SolveError),
    /// The runs do not agree.
    #[error(
        "the reference is not reliable: its two settings differ by {settings:?}, the independent method differs by \
         {independent:?}"
    )]
    Disagreement {
        /// Differences between the two settings.
        settings: Errors,
        /// Differences between the series and the independent method.
        independent: Errors,
    },
}

/// Computes the reference of a problem; fails if its checks disagree.
pub fn make(problem: &Problem) -> Result<Reference, NoReference> {
    let sample = take(problem, FINE_SERIES, SETTINGS[0].0)?;
    let settings = take(problem, OTHER_SERIES, SETTINGS[1].0)?.errors(&sample, problem.coulomb_n);
    let independent = take(problem, INDEPENDENT_METHOD, INDEPENDENT_STEPS)?.errors(&sample, problem.coulomb_n);
    let largest = |errors: &Errors| errors.force.max(errors.mean).max(errors.displacement);
    // This comparison is also false for NaN.
    if largest(&settings) <= MAX_SETTINGS_DIFFERENCE && largest(&independent) <= MAX_INDEPENDENT_DIFFERENCE {
        Ok(Reference { sample, settings, independent })
    } else {
        Err(NoReference::Disagreement { settings, independent })
    }
}

const FINE_SERIES: Watched = |problem, n, mut watch| taylor::run(problem, n, SETTINGS[0].1, &mut watch);
const OTHER_SERIES: Watched = |problem, n, mut watch| taylor::run(problem, n, SETTINGS[1].1, &mut watch);
const INDEPENDENT_METHOD: Watched = |problem, n, mut watch| rk4_events::run(problem, n, &mut watch);

#[cfg(test)]
mod tests {
    use super::*;
    use contact::Law;
    use contact::table_4_1::{CONTACT_N_PER_M, standard, table_4_1};

    #[test]
    fn the_standard_case_has_a_reference() {
        let reference = make(&standard()).unwrap();
        // By another program, in 34 digits: 0.664066.
        assert!((reference.sample.mean - 0.664_066).abs() < 5e-7);
        assert_eq!(reference.sample.quarters.len(), 401);
    }

    #[test]
    fn a_reference_with_disagreement_is_refused() {
        // A contact so stiff that 2000 steps of the independent method are far too few.
        let law = Law::Dahl { stiffness_n_per_m: 1e3 * CONTACT_N_PER_M };
        assert!(make(&Problem { law, ..table_4_1(0.5, 20.0) }).is_err());
    }
}
