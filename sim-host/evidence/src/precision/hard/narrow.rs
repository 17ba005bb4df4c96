//! Single precision: fit for use if the phase restarts every period, and not if the time is added up.

use super::{Check, Found, last, linexp};
use crate::precision::single::{Clock, run};
use contact::table_4_1::{FORCE_N, MASS_KG, STIFFNESS_N_PER_M, table_4_1};
use contact::{SolveError, rk4, taylor};

/// Steps a period in single precision.
const STEPS: u32 = 100;

/// Both clocks over so many periods, against double precision.
pub fn single(periods: u32) -> Result<Found, SolveError> {
    let problem = table_4_1(0.5, f64::from(periods));
    // The same method in double precision is off by its step; what single precision adds is the difference to it.
    let (double, _) = last(|mut watch| rk4::run_plain(&problem, STEPS, &mut watch))?;
    let (_, mean) = linexp(&problem, 32, 6)?;
    let (truth, _) = last(|mut watch| taylor::run(&problem, 16, 20, &mut watch))?;
    let omega = std::f64::consts::TAU * problem.waveform.frequency_hz();
    let forced_m = (FORCE_N / (STIFFNESS_N_PER_M - MASS_KG * omega * omega)).abs();
    let of = |clock| {
        let single = run(problem.sliding_m_per_s, periods, STEPS, clock);
        ((f64::from(single.x_m) - double.x_m).abs() / forced_m, (single.mean - mean).abs())
    };
    let (naive, reset) = (of(Clock::Accumulated), of(Clock::Reset));
    Ok(Found {
        problem: "f32 has 7 digits, and w t needs them all",
        naive: format!("t += h: x off by {:.1e} of its amplitude, mean by {:.1e}", naive.0, naive.1),
        chosen: format!("phase reset: x off by {:.1e} of its amplitude, mean by {:.1e}", reset.0, reset.1),
        checks: vec![
            Check::at_most("f32 off f64, x", reset.0, 3e-4),
            Check::at_most("f32 off f64, mean", reset.1, 2e-5),
            Check::between("t += h off f64, x", naive.0, 0.01, f64::INFINITY),
            Check::at_most("f64 at this step off taylor, x", (double.x_m - truth.x_m) / forced_m, 2e-6),
        ],
    })
}
