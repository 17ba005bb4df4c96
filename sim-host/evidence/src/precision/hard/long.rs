//! A million periods: nothing drifts, and the oscillator reaches the steady state of the closed
//! form.

use std::time::Instant;

use super::{Check, HardResult, Scale, last, linexp};
use contact::linexp::Options;
use contact::table_4_1::{DRIVE_HZ, FORCE_N, MASS_KG, STIFFNESS_N_PER_M, table_4_1};
use contact::{Problem, SolveError, linexp as method, rk4};

/// Steady kinematic friction ratio at Table 4.1 and velocity ratio 0.5, in 40 digits by another
/// program.
const STEADY_RATIO: f64 = 0.674_948_67;
/// Period after which the natural motion has died away by friction, with a decay of about 9 280
/// periods.
const DECAYED_PERIODS: f64 = 50_000.0;

fn periods(scale: Scale) -> f64 {
    if scale == Scale::Full { 1e6 } else { 1e5 }
}

/// Runs Table 4.1 until the rest of the start transient is below the coupling, and further.
pub fn to_the_steady_state(scale: Scale) -> Result<HardResult, SolveError> {
    let periods = periods(scale);
    let problem = Problem { window_s: (DECAYED_PERIODS / DRIVE_HZ, periods / DRIVE_HZ), ..table_4_1(0.5, periods) };
    let began = Instant::now();
    let (tally, r) = linexp(&problem, 16, 4)?;
    let took_s = began.elapsed().as_secs_f64();
    let short = Problem { window_s: (0.0, 0.01 * problem.duration_s), duration_s: 0.01 * problem.duration_s, ..problem.clone() };
    let began = Instant::now();
    rk4::run_plain(&short, 1000, &mut |_| ())?;
    let thesis_s = 100.0 * began.elapsed().as_secs_f64();
    Ok(HardResult {
        problem: "the start transient takes 9 280 periods to decay by friction alone",
        naive: format!("n = 1000: would take {thesis_s:.0} s for {periods:.0e} periods"),
        chosen: format!("linexp-4, n = 16: {took_s:.2} s for {periods:.0e} periods, r {r:.8}"),
        checks: vec![
            Check::at_most("deviation from the closed form 0.67494867", r - STEADY_RATIO, 1e-5),
            Check::same("excess over 2 reversals a period, in hundreds", tally.reversals.abs_diff(2 * periods as u64) / 100, 0),
        ],
    })
}

/// Compares the motion without the effect of friction with its closed form
/// `xa (cos w t - cos wn t)`.
pub fn drift(scale: Scale) -> Result<HardResult, SolveError> {
    let periods = periods(scale);
    let problem = table_4_1(0.5, periods);
    let (end, _) = last(|mut watch| method::run(&problem, 16, 4, Options::Frozen, &mut watch))?;
    let omega = std::f64::consts::TAU * DRIVE_HZ;
    let forced_m = FORCE_N / (STIFFNESS_N_PER_M - MASS_KG * omega * omega);
    // The run ends at the end of a drive period.
    let exact_m = forced_m * (1.0 - ((STIFFNESS_N_PER_M / MASS_KG).sqrt() * periods / DRIVE_HZ).cos());
    let (naive, _) = last(|mut watch| rk4::run_plain(&table_4_1(0.5, 0.1 * periods), 100, &mut watch))?;
    let naive_m = forced_m * (1.0 - ((STIFFNESS_N_PER_M / MASS_KG).sqrt() * 0.1 * periods / DRIVE_HZ).cos());
    Ok(HardResult {
        problem: "the phase of the natural motion without friction",
        naive: format!(
            "n = 100, with friction, a tenth of the duration: x off by {:.1e} of its forced part",
            (naive.x_m - naive_m) / forced_m
        ),
        chosen: format!("x off by {:.1e} of its forced part", (end.x_m - exact_m) / forced_m),
        checks: vec![Check::at_most("x: deviation from the closed form", (end.x_m - exact_m) / forced_m, 1e-13 * periods)],
    })
}
