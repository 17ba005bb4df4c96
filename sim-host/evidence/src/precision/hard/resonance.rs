//! Drives at the natural frequency, where the particular solution F0 / (Ks - m w^2) does not exist.
//!
//! Without friction the solutions are known: undamped from rest
//! `v = F0 / (2 m w) (sin w t + w t cos w t)`; damped, in the steady state, `v = F0 / c`. If the
//! belt is slow compared with the vibration, friction reduces the force by its first harmonic,
//! `(4 / pi) Fc`.

use super::{Check, HardResult, last, linexp, mean, thesis, thesis_survives};
use contact::linexp::Options;
use contact::table_4_1::{FORCE_N, MASS_KG, STIFFNESS_N_PER_M, table_4_1};
use contact::{Motion, Problem, Shape, SolveError, Waveform, linexp as method, taylor};

/// Returns Table 4.1 driven at its natural frequency, with `friction` times its friction and with
/// damping.
fn driven(periods: f64, friction: f64, zeta: f64) -> Problem {
    let standard = table_4_1(0.5, periods);
    let natural = (STIFFNESS_N_PER_M / MASS_KG).sqrt();
    let hz = natural / std::f64::consts::TAU;
    Problem {
        motion: Motion::Sdof {
            mass_kg: MASS_KG,
            stiffness_n_per_m: STIFFNESS_N_PER_M,
            damping_n_s_per_m: 2.0 * zeta * MASS_KG * natural,
        },
        coulomb_n: friction * standard.coulomb_n,
        waveform: Waveform::new(Shape::Sine, FORCE_N, hz, periods / hz),
        window_s: (0.5 * periods / hz, periods / hz),
        duration_s: periods / hz,
        ..standard
    }
}

/// Returns the velocity from rest without friction, m/s.
fn exact(t: f64) -> f64 {
    let natural = (STIFFNESS_N_PER_M / MASS_KG).sqrt();
    FORCE_N / (2.0 * MASS_KG * natural) * ((natural * t).sin() + natural * t * (natural * t).cos())
}

/// Runs the undamped case with negligible friction over a thousand periods.
pub fn undamped_without_friction() -> Result<HardResult, SolveError> {
    let problem = driven(1000.0, 1e-12, 0.0);
    let run = |steps| last(|mut watch| method::run(&problem, steps, 4, Options::Plain, &mut watch));
    let (end, tally) = run(16)?;
    let v = exact(end.time_s);
    Ok(HardResult {
        problem: "w = wn, no damping, mu 1e-13: grows by F0 / 2m",
        naive: thesis(&problem, 0.0)?,
        chosen: format!("linexp-4, n = 16: v {:.9} m/s, exact {v:.9} m/s", end.v_m_per_s),
        checks: vec![
            Check::at_most("velocity: deviation from the exact one", end.v_m_per_s / v - 1.0, 1e-10),
            Check::bounded(&tally),
        ],
    })
}

/// Runs the undamped case with friction: soon the slip a period is a thousand bristle lengths.
pub fn undamped_with_friction() -> Result<HardResult, SolveError> {
    let problem = driven(1000.0, 1.0, 0.0);
    let (end, tally) = last(|mut watch| method::run(&problem, 64, 4, Options::Plain, &mut watch))?;
    let (truth, reference) = last(|mut watch| taylor::run(&problem, 64, 20, &mut watch))?;
    let (r, truth_r) = (mean(&problem, &tally), mean(&problem, &reference));
    let free = exact(end.time_s);
    Ok(HardResult {
        problem: "w = wn, no damping, friction of Table 4.1",
        naive: thesis(&problem, truth_r)?,
        chosen: format!("linexp-4, n = 64: v {:.6} m/s, taylor {:.6} m/s", end.v_m_per_s, truth.v_m_per_s),
        checks: vec![
            Check::at_most("velocity: deviation from taylor", end.v_m_per_s / truth.v_m_per_s - 1.0, 5e-10),
            Check::at_most("mean: deviation from taylor", r - truth_r, 3e-10),
            Check::between(
                "loss over (4 / pi) Fc / F0",
                (1.0 - end.v_m_per_s / free) / (4.0 / std::f64::consts::PI * problem.coulomb_n / FORCE_N),
                0.99,
                1.01,
            ),
            Check::same("thesis's method completes", u64::from(thesis_survives(&problem)), 0),
        ],
    })
}

/// Damping ratio of the damped cases.
const DAMPING_RATIO: f64 = 0.05;
/// Periods after which the start transient has decayed to e^-94.
const SETTLED_PERIODS: f64 = 300.0;

/// Runs the damped case with negligible friction.
pub fn damped_without_friction() -> Result<HardResult, SolveError> {
    let problem = driven(SETTLED_PERIODS, 1e-12, DAMPING_RATIO);
    let (end, _) = last(|mut watch| method::run(&problem, 16, 4, Options::Plain, &mut watch))?;
    let v = problem.vibration_m_per_s();
    Ok(HardResult {
        problem: "w = wn, zeta 0.05, mu 1e-13: F0 / c",
        naive: thesis(&problem, 0.0)?,
        chosen: format!("linexp-4, n = 16: v {:.12} m/s, exact {v:.12} m/s", end.v_m_per_s),
        checks: vec![Check::at_most("velocity: deviation from F0 / c", end.v_m_per_s / v - 1.0, 1e-12)],
    })
}

/// Runs the damped case with friction.
pub fn damped_with_friction() -> Result<HardResult, SolveError> {
    let problem = driven(SETTLED_PERIODS, 1.0, DAMPING_RATIO);
    let (end, _) = last(|mut watch| method::run(&problem, 64, 4, Options::Plain, &mut watch))?;
    let (_, r) = linexp(&problem, 64, 4)?;
    let truth = mean(&problem, &taylor::run(&problem, 64, 20, &mut |_| ())?);
    let v = problem.vibration_m_per_s();
    let loss = (1.0 - end.v_m_per_s / v) / (problem.coulomb_n / FORCE_N);
    Ok(HardResult {
        problem: "w = wn, zeta 0.05, friction of Table 4.1",
        naive: thesis(&problem, truth)?,
        chosen: format!("linexp-4, n = 64: v {:.7} m/s of {v:.7} m/s", end.v_m_per_s),
        checks: vec![
            Check::at_most("mean: deviation from taylor", r - truth, 5e-7),
            Check::between("loss over Fc / F0; 4 / pi for a full square", loss, 1.2, 1.28),
        ],
    })
}
