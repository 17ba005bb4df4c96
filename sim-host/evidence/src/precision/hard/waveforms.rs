//! Forces with jumps, and a sweep through the resonance.

use super::{Check, HardResult, THESIS_STEPS, linexp, mean, naive, thesis};
use crate::precision::interpolate::order;
use contact::linexp::Options;
use contact::table_4_1::{DRIVE_HZ, FORCE_N, MASS_KG, STIFFNESS_N_PER_M, table_4_1};
use contact::{Problem, Shape, SolveError, State, Waveform, linexp as method, rk4, rk4_events, taylor};

/// Runs a square force. Its jumps are between steps, but the last stage of the naive step already
/// samples the force after the jump.
pub fn square() -> Result<HardResult, SolveError> {
    let mut problem = table_4_1(0.5, 100.0);
    problem.waveform = Waveform::new(Shape::Square, FORCE_N, DRIVE_HZ, problem.duration_s);
    let truth = mean(&problem, &taylor::run(&problem, 32, 28, &mut |_| ())?);
    let events = mean(&problem, &rk4_events::run(&problem, 1000, &mut |_| ())?);
    let (_, r) = linexp(&problem, 16, 6)?;
    let mut curve = Vec::new();
    for steps in [100u32, 1000, 10_000] {
        let error = (mean(&problem, &rk4::run(&problem, steps, &mut |_| ())?) - truth).abs();
        curve.push((f64::from(steps), error));
    }
    let naive_order = order(&curve).unwrap_or(f64::NAN);
    let mut frozen = Vec::new();
    method::run(&problem, 16, 6, Options::Frozen, &mut |state: &State| frozen.push(*state))?;
    let off_exact = frozen.iter().map(|state| (state.x_m - piecewise(state.time_s)).abs()).fold(0.0, f64::max);
    let size = frozen.iter().map(|state| state.x_m.abs()).fold(0.0, f64::max);
    Ok(HardResult {
        problem: "the force jumps twice a period",
        naive: format!("{}, order {naive_order:.2}", naive(&problem, THESIS_STEPS, truth)?),
        chosen: format!("linexp-6, n = 16: mean off by {:.1e}", r - truth),
        checks: vec![
            Check::between("order of the naive method", naive_order, 0.9, 1.1),
            Check::at_most("mean: deviation from taylor", r - truth, 3e-11),
            Check::at_most("taylor: deviation from rk4-events", truth - events, 1e-12),
            Check::at_most("motion: deviation from the piecewise exact one", off_exact / size, 5e-12),
        ],
    })
}

/// Returns the displacement from rest under the square force without friction: in each half period
/// a circle around `+-F0 / Ks`.
fn piecewise(time_s: f64) -> f64 {
    let natural = (STIFFNESS_N_PER_M / MASS_KG).sqrt();
    let half_s = 0.5 / DRIVE_HZ;
    // Sum of the step responses: a step of height u at time t0 adds u / Ks (1 - cos(wn (t - t0))).
    let whole = (time_s / half_s + 1e-9).floor() as u32;
    let step = |index: u32| {
        let height = if index == 0 { FORCE_N } else { 2.0 * FORCE_N * if index.is_multiple_of(2) { 1.0 } else { -1.0 } };
        height / STIFFNESS_N_PER_M * (1.0 - (natural * (time_s - f64::from(index) * half_s)).cos())
    };
    (0..=whole).map(step).sum()
}

/// Runs a chirp from 5 to 25 kHz in 20 ms, through the resonance at 13 kHz.
pub fn chirp() -> Result<HardResult, SolveError> {
    let (start_hz, stop_hz, sweep_s) = (5e3, 25e3, 20e-3);
    let mut problem = Problem { window_s: (0.0, sweep_s), duration_s: sweep_s, ..table_4_1(0.5, 100.0) };
    problem.waveform = Waveform::new(Shape::Chirp { start_hz, stop_hz, sweep_s }, FORCE_N, DRIVE_HZ, sweep_s);
    let reference = taylor::run(&problem, 64, 20, &mut |_| ())?;
    let other = rk4_events::run(&problem, 4000, &mut |_| ())?;
    let (tally, r) = linexp(&problem, 64, 4)?;
    let truth = mean(&problem, &reference);
    // Through resonance at a rate a: v = F0 / 2m sqrt(1 / a), times the overshoot of a Fresnel
    // integral, 1.17 of its limit.
    let rate = (stop_hz - start_hz) / sweep_s;
    let fresnel = FORCE_N / (2.0 * MASS_KG * rate.sqrt());
    Ok(HardResult {
        problem: "5 to 25 kHz in 20 ms: the amplitude grows by factors of hundreds",
        naive: format!("{}; {}", thesis(&problem, truth)?, naive(&problem, 100, truth)?),
        chosen: format!("linexp-4, n = 64: r {r:.8}, largest velocity {:.3} m/s", tally.peak_velocity_m_per_s),
        checks: vec![
            Check::at_most("mean: deviation from taylor", r - truth, 3e-10),
            Check::at_most("taylor: deviation from rk4-events", truth - mean(&problem, &other), 5e-10),
            Check::between("largest velocity over the Fresnel limit", tally.peak_velocity_m_per_s / fresnel, 1.1, 1.25),
        ],
    })
}
