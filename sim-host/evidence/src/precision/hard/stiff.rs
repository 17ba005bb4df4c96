//! Contacts so stiff, or loads so light, that a step spans many Dahl lengths.

use super::limit;
use super::{Check, HardResult, linexp, mean, thesis, thesis_survives};
use contact::table_4_1::{CONTACT_N_PER_M, table_4_1};
use contact::{Law, Problem, SolveError, rk4_events};

/// Number of periods.
const PERIODS: f64 = 20.0;

fn unsuited(reason: &str) -> SolveError {
    SolveError::Unsuited { method: "the Coulomb limit", reason: reason.into() }
}

/// Runs Table 4.1 with a contact stiffer by a factor.
pub fn contact(factor: f64) -> Result<HardResult, SolveError> {
    let law = Law::Dahl { stiffness_n_per_m: factor * CONTACT_N_PER_M };
    let problem = Problem { law, ..table_4_1(0.5, PERIODS) };
    let (coarse, fine) = (linexp(&problem, 64, 4)?, linexp(&problem, 128, 4)?);
    let limit = limit::coulomb_limit(&problem).ok_or_else(|| unsuited("no oscillator"))?;
    let mut checks = vec![Check::bounded(&coarse.0), Check::at_most("half step", coarse.1 - fine.1, (1e-4 / factor).max(2e-9))];
    let beyond = problem.kappa() * (fine.1 - limit.lagging);
    let reference = if factor <= 1e4 {
        // More steps than the classical method needs for stability.
        let steps = 4_000 * (factor / 1e3) as u32;
        let reference = mean(&problem, &rk4_events::run(&problem, steps, &mut |_| ())?);
        checks.push(Check::at_most(format!("deviation from rk4-events at n = {steps}"), coarse.1 - reference, 1e-4 / factor));
        reference
    } else {
        checks.push(Check::between("kappa (r - limit)", beyond, 0.12, 0.18));
        limit.lagging
    };
    // From 3e3 on the thesis's method must diverge, or the case proves nothing.
    checks.push(Check::same("thesis's method completes", u64::from(thesis_survives(&problem)), u64::from(factor < 3e3)));
    Ok(HardResult {
        problem: "a step spans many Dahl lengths",
        naive: thesis(&problem, reference)?,
        chosen: format!("linexp-4, n = 64: r {:.7}, Coulomb {:.7}, limit {:.7}", coarse.1, limit.coulomb, limit.lagging),
        checks,
    })
}

/// Runs Table 4.1 with a very small coefficient of friction.
pub fn slippery(mu: f64) -> Result<HardResult, SolveError> {
    let standard = table_4_1(0.5, PERIODS);
    let problem = Problem { coulomb_n: mu / 0.1 * standard.coulomb_n, ..standard };
    let (coarse, fine) = (linexp(&problem, 64, 4)?, linexp(&problem, 128, 4)?);
    let limit = limit::coulomb_limit(&problem).ok_or_else(|| unsuited("no oscillator"))?;
    let kappa = problem.kappa();
    Ok(HardResult {
        problem: "negligible friction: Coulomb's limit of a contact of any stiffness",
        naive: thesis(&problem, limit.lagging)?,
        chosen: format!("linexp-4, n = 64: r {:.9}, Coulomb {:.9}, limit {:.9}", coarse.1, limit.coulomb, limit.lagging),
        checks: vec![
            Check::bounded(&coarse.0),
            Check::at_most("half step", coarse.1 - fine.1, 1e-8),
            Check::at_most("deviation from the two-frequency Coulomb limit", coarse.1 - limit.lagging, 0.3 / kappa + 1e-11),
            Check::same("thesis's method completes", u64::from(thesis_survives(&problem)), 0),
        ],
    })
}
