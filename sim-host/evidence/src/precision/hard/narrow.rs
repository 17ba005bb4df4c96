//! Single precision: accurate enough if the phase restarts every period, but not if time
//! accumulates.

use super::{Check, HardResult, last, linexp};
use crate::precision::single::{Clock, run};
use contact::table_4_1::{FORCE_N, MASS_KG, STIFFNESS_N_PER_M, table_4_1};
use contact::{SolveError, rk4, taylor};

/// Steps a period in single precision.
const STEPS: u32 = 100;

/// Compares both clocks with double precision after `periods` periods.
pub fn single(periods: u32) -> Result<HardResult, SolveError> {
    let problem = table_4_1(0.5, f64::from(periods));
    // In double precision the method has the error of its step; the difference to that run is the
    // error due to single precision.
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
    Ok(HardResult {
        problem: "f32 has 7 digits, and w t needs all of them",
        naive: format!("t += h: x off by {:.1e} of its amplitude, mean by {:.1e}", naive.0, naive.1),
        chosen: format!("phase reset: x off by {:.1e} of its amplitude, mean by {:.1e}", reset.0, reset.1),
        checks: vec![
            Check::at_most("x: deviation of f32 from f64", reset.0, 3e-4),
            Check::at_most("mean: deviation of f32 from f64", reset.1, 2e-5),
            Check::between("x: deviation of t += h from f64", naive.0, 0.01, f64::INFINITY),
            Check::at_most("x: deviation of f64 at this step from taylor", (double.x_m - truth.x_m) / forced_m, 2e-6),
        ],
    })
}
