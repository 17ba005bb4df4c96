//! Contacts so stiff, or loads so light, that a step is many Dahl lengths.

use super::limit;
use super::{Check, Found, linexp, mean, thesis, thesis_survives};
use contact::table_4_1::{CONTACT_N_PER_M, table_4_1};
use contact::{Law, Problem, SolveError, rk4_events};

/// Periods.
const PERIODS: f64 = 20.0;

fn unsuited(reason: &str) -> SolveError {
    SolveError::Unsuited { method: "the Coulomb limit", reason: reason.into() }
}

/// Table 4.1 with its contact so many times stiffer.
pub fn contact(factor: f64) -> Result<Found, SolveError> {
    let law = Law::Dahl { stiffness_n_per_m: factor * CONTACT_N_PER_M };
    let problem = Problem { law, ..table_4_1(0.5, PERIODS) };
    let (coarse, fine) = (linexp(&problem, 64, 4)?, linexp(&problem, 128, 4)?);
    let limit = limit::of(&problem).ok_or_else(|| unsuited("no oscillator"))?;
    let mut checks = vec![Check::bounded(&coarse.0), Check::at_most("half step", coarse.1 - fine.1, (1e-4 / factor).max(2e-9))];
    let beyond = problem.kappa() * (fine.1 - limit.lagging);
    let reference = if factor <= 1e4 {
        // As many steps as the classical method needs to stay, and then some.
        let steps = 4_000 * (factor / 1e3) as u32;
        let reference = mean(&problem, &rk4_events::run(&problem, steps, &mut |_| ())?);
        checks.push(Check::at_most(format!("off rk4-events at n = {steps}"), coarse.1 - reference, 1e-4 / factor));
        reference
    } else {
        checks.push(Check::between("kappa (r - limit)", beyond, 0.12, 0.18));
        limit.lagging
    };
    // From 3e3 on the thesis's method must leave, or this case shows nothing.
    checks.push(Check::same("thesis survives", u64::from(thesis_survives(&problem)), u64::from(factor < 3e3)));
    Ok(Found {
        problem: "a step is many Dahl lengths",
        naive: thesis(&problem, reference)?,
        chosen: format!("linexp-4, n = 64: r {:.7}, Coulomb {:.7}, limit {:.7}", coarse.1, limit.coulomb, limit.lagging),
        checks,
    })
}

/// Table 4.1 with so small a coefficient of friction.
pub fn slippery(mu: f64) -> Result<Found, SolveError> {
    let standard = table_4_1(0.5, PERIODS);
    let problem = Problem { coulomb_n: mu / 0.1 * standard.coulomb_n, ..standard };
    let (coarse, fine) = (linexp(&problem, 64, 4)?, linexp(&problem, 128, 4)?);
    let limit = limit::of(&problem).ok_or_else(|| unsuited("no oscillator"))?;
    let kappa = problem.kappa();
    Ok(Found {
        problem: "next to no friction: Coulomb's limit of a contact of any stiffness",
        naive: thesis(&problem, limit.lagging)?,
        chosen: format!("linexp-4, n = 64: r {:.9}, Coulomb {:.9}, limit {:.9}", coarse.1, limit.coulomb, limit.lagging),
        checks: vec![
            Check::bounded(&coarse.0),
            Check::at_most("half step", coarse.1 - fine.1, 1e-8),
            Check::at_most("off the two-frequency Coulomb limit", coarse.1 - limit.lagging, 0.3 / kappa + 1e-11),
            Check::same("thesis survives", u64::from(thesis_survives(&problem)), 0),
        ],
    })
}
