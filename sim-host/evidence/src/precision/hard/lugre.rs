//! Bristles with a Stribeck curve or with damping that the classical method cannot follow.

use super::{Check, HardResult, mean, thesis, thesis_survives};
use contact::table_4_1::{CONTACT_N_PER_M, table_4_1};
use contact::{Law, Problem, SolveError, midpoint, rk4_events};

fn law(stiffness_n_per_m: f64, sigma1: f64) -> Law {
    Law::Lugre { stiffness_n_per_m, static_ratio: 1.5, stribeck_m_per_s: 0.01, sigma1, sigma2: 0.0 }
}

/// Runs Fs = 1.5 Fc, Vs = 0.01 m/s, and bristles a thousand times stiffer than Table 4.1's.
pub fn stiff() -> Result<HardResult, SolveError> {
    let problem = Problem { law: law(1e3 * CONTACT_N_PER_M, 0.0), ..table_4_1(0.5, 20.0) };
    let reference = mean(&problem, &rk4_events::run(&problem, 40_000, &mut |_| ())?);
    let of = |steps| midpoint::run(&problem, steps, &mut |_| ()).map(|tally| (mean(&problem, &tally) - reference, tally));
    let ((coarse, tally), (fine, _)) = (of(200)?, of(1000)?);
    Ok(HardResult {
        problem: "Kt x 1e3, Stribeck",
        naive: thesis(&problem, reference)?,
        chosen: format!("midpoint: mean off by {coarse:.1e} at n = 200, {fine:.1e} at n = 1000"),
        checks: vec![
            Check::between("largest |F| / Fc, at most Fs / Fc", tally.peak_force_ratio, 1.0, 1.5),
            Check::at_most("mean at n = 200: deviation from rk4-events at n = 40000", coarse, 1e-6),
            Check::at_most("mean at n = 1000: deviation from rk4-events at n = 40000", fine, 1e-9),
            Check::same("thesis's method completes", u64::from(thesis_survives(&problem)), 0),
        ],
    })
}

/// Runs bristles with damping above the stability limit of a step: sigma1 h / m is 8.3 at the
/// thesis's step.
pub fn damped() -> Result<HardResult, SolveError> {
    let problem = Problem { law: law(CONTACT_N_PER_M, 1e7), ..table_4_1(0.5, 20.0) };
    let of = |steps| midpoint::run(&problem, steps, &mut |_| ());
    let (coarse, fine) = (of(400)?, of(4000)?);
    let (r, r_fine) = (mean(&problem, &coarse), mean(&problem, &fine));
    Ok(HardResult {
        problem: "the bristles' damping holds the mass to the belt",
        naive: thesis(&problem, r_fine)?,
        chosen: format!(
            "midpoint, n = 400: largest velocity {:.5} of Vt {:.5} m/s",
            coarse.peak_velocity_m_per_s, problem.sliding_m_per_s
        ),
        checks: vec![
            Check::at_most("largest velocity over Vt", coarse.peak_velocity_m_per_s / problem.sliding_m_per_s, 1.01),
            Check::at_most("mean: change at a tenth of the step, relative", r / r_fine - 1.0, 2e-5),
            Check::same("thesis's method completes", u64::from(thesis_survives(&problem)), 0),
        ],
    })
}
