//! Loads that change at once: the force in the bristles stays, and may be far beyond what the new load can hold.

use super::{Check, Found, linexp, mean, thesis};
use crate::contact::linexp::Extent;
use crate::contact::{Problem, State, Trouble, linexp as method, taylor};
use crate::precision::case::{DRIVE_HZ, table_4_1};

/// Table 4.1 with its load changed by a factor at period 100; `published` is the mean over periods 150 to 200 by another program.
pub fn step(factor: f64, published: f64) -> Result<Found, Trouble> {
    let standard = table_4_1(0.5, 200.0);
    let coulomb_n = factor * standard.coulomb_n;
    let problem =
        Problem { load_steps: vec![(100.0 / DRIVE_HZ, coulomb_n)], window_s: (150.0 / DRIVE_HZ, 200.0 / DRIVE_HZ), ..standard };
    let mut after: Vec<f64> = Vec::new();
    method::run(&problem, 64, 4, Extent::Swift, &mut |state: &State| {
        if state.time_s > 100.0 / DRIVE_HZ {
            after.push(state.force_n.abs() / coulomb_n);
        }
    })?;
    // Above the bound friction may only fall; once below, it stays there.
    let rises = after.windows(2).filter(|pair| pair[1] > pair[0].max(1.0 + 1e-12)).count();
    let beyond_at_the_end = after[after.len() / 2..].iter().fold(0.0f64, |most, ratio| most.max(*ratio)) - 1.0;
    let (_, r) = linexp(&problem, 64, 4)?;
    let truth = mean(&problem, &taylor::run(&problem, 32, 24, &mut |_| ())?);
    Ok(Found {
        problem: "the bristles hold a force of the old load",
        naive: thesis(&problem, truth)?,
        chosen: format!("linexp-4, n = 64: r {r:.9}, |F| / Fc {:.3} a step after", after.first().copied().unwrap_or_default()),
        checks: vec![
            Check::same("rises above the new bound", rises as u64, 0),
            Check::at_most("|F| beyond Fc, 50 periods later", beyond_at_the_end.max(0.0), 1e-12),
            Check::at_most("mean off taylor", r - truth, 1e-8),
            Check::at_most("taylor off the published", truth - published, 1e-8),
        ],
    })
}
