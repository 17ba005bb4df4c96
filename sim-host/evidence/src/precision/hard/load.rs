//! Sudden load changes: the bristle force stays and may be far above the bound of the new load.

use super::{Check, HardResult, linexp, mean, thesis};
use contact::linexp::Options;
use contact::table_4_1::{DRIVE_HZ, table_4_1};
use contact::{Problem, SolveError, State, linexp as method, taylor};

/// Runs Table 4.1 with its load changed by a factor at period 100. `published` is the mean over
/// periods 150 to 200 by another program. `tolerance` is the error due to the step, which is large
/// if the new kappa is 400.
pub fn step(factor: f64, published: f64, tolerance: f64) -> Result<HardResult, SolveError> {
    let standard = table_4_1(0.5, 200.0);
    let coulomb_n = factor * standard.coulomb_n;
    let problem =
        Problem { load_steps: vec![(100.0 / DRIVE_HZ, coulomb_n)], window_s: (150.0 / DRIVE_HZ, 200.0 / DRIVE_HZ), ..standard };
    let mut after: Vec<f64> = Vec::new();
    method::run(&problem, 64, 4, Options::Plain, &mut |state: &State| {
        if state.time_s > 100.0 / DRIVE_HZ {
            after.push(state.force_n.abs() / coulomb_n);
        }
    })?;
    // Above the bound friction may only fall; once below it must stay below.
    let falls = |pair: &&[f64]| pair[1] <= pair[0] || pair[1] <= 1.0 + 1e-12;
    let rises = after.windows(2).count() - after.windows(2).filter(falls).count();
    let within = after.iter().skip(3200).filter(|ratio| **ratio <= 1.0 + 1e-12).count();
    let (_, r) = linexp(&problem, 64, 4)?;
    let truth = mean(&problem, &taylor::run(&problem, 32, 24, &mut |_| ())?);
    Ok(HardResult {
        problem: "the bristles still hold the force of the old load",
        naive: thesis(&problem, truth)?,
        chosen: format!("linexp-4, n = 64: r {r:.9}, |F| / Fc {:.3} one step later", after.first().copied().unwrap_or_default()),
        checks: vec![
            Check::same("steps in 100 periods", after.len() as u64, 6400),
            Check::same("rises above the new bound", rises as u64, 0),
            Check::same("steps with |F| <= Fc in the last 50 periods", within as u64, 3200),
            Check::at_most("mean: deviation from taylor", r - truth, tolerance),
            Check::at_most("taylor: deviation from the published mean", truth - published, 6e-10),
        ],
    })
}
