//! Slip that hardly reverses, or oscillates around zero. Here a sign taken from round-off, or a
//! missed touch of zero, causes errors.

use super::{Check, HardResult, linexp, mean, thesis};
use contact::table_4_1::{DRIVE_HZ, FORCE_N, MASS_KG, STIFFNESS_N_PER_M, table_4_1};
use contact::{Motion, Problem, Shape, SolveError, State, Waveform, rk4_events, taylor};

/// Runs without sliding, from rest: the slip is the vibration alone.
pub fn no_sliding_from_rest() -> Result<HardResult, SolveError> {
    let problem = table_4_1(0.0, 400.0);
    let reference = taylor::run(&problem, 16, 20, &mut |_| ())?;
    let truth = mean(&problem, &reference);
    let (tally, r) = linexp(&problem, 16, 6)?;
    let events = rk4_events::run(&problem, 100, &mut |_| ())?;
    Ok(HardResult {
        problem: "the slip starts at zero, so its sign is round-off",
        naive: thesis(&problem, truth)?,
        chosen: format!("linexp-6, n = 16: {} reversals in 400 periods", tally.reversals),
        checks: vec![
            Check::same("reversals, linexp", tally.reversals, 800),
            Check::same("reversals, rk4-events", events.reversals, 800),
            Check::same("reversals, taylor", reference.reversals, 800),
            Check::at_most("mean: deviation from taylor", r - truth, 3e-12),
        ],
    })
}

/// Runs without sliding in the steady state; a damper makes the start transient decay.
pub fn no_sliding_steady() -> Result<HardResult, SolveError> {
    let mut problem = table_4_1(0.0, 1000.0);
    let natural = (STIFFNESS_N_PER_M / MASS_KG).sqrt();
    let damping_n_s_per_m = 0.1 * MASS_KG * natural;
    problem.motion = Motion::Sdof { mass_kg: MASS_KG, stiffness_n_per_m: STIFFNESS_N_PER_M, damping_n_s_per_m };
    let (tally, r) = linexp(&problem, 16, 4)?;
    Ok(HardResult {
        problem: "steady state, zeta 0.05: by symmetry the mean is zero",
        naive: thesis(&problem, 0.0)?,
        chosen: format!("linexp-4, n = 16: mean {r:.1e}, {} reversals in 1000 periods", tally.reversals),
        checks: vec![
            Check::at_most("mean", r, 1e-15),
            Check::same("reversals", tally.reversals, 2000),
            // Friction acts nevertheless: the bristles bend to half of their limit, by the motion's
            // kappa.
            Check::between("largest |F| / Fc", tally.peak_force_ratio, 0.2, 1.0),
        ],
    })
}

/// Runs a belt nearly as fast as the vibration: a period has two close reversals, or none.
pub fn grazing(velocity_ratio: f64) -> Result<HardResult, SolveError> {
    let problem = table_4_1(velocity_ratio, 130.0);
    let reference = taylor::run(&problem, 64, 28, &mut |_| ())?;
    let truth = mean(&problem, &reference);
    let mut checks = Vec::new();
    for (steps, bound) in [(8, 2e-9), (16, 1e-10), (32, 5e-12), (64, 3e-13)] {
        let (tally, r) = linexp(&problem, steps, 6)?;
        checks.push(Check::same(format!("reversals, linexp-6 n = {steps}"), tally.reversals, reference.reversals));
        checks.push(Check::at_most("mean: deviation from taylor", r - truth, bound));
    }
    Ok(HardResult {
        problem: "a check at the ends of the steps alone would miss the reversals",
        naive: thesis(&problem, truth)?,
        chosen: format!("linexp-6: {} reversals at every n", reference.reversals),
        checks,
    })
}

/// Runs a belt exactly as fast as the steady vibration: the slip touches zero once a period.
pub fn touching() -> Result<HardResult, SolveError> {
    let standard = table_4_1(1.0, 200.0);
    let omega = std::f64::consts::TAU * standard.waveform.frequency_hz();
    let x_m = FORCE_N / (STIFFNESS_N_PER_M - MASS_KG * omega * omega);
    let problem = Problem { start: State { x_m, ..State::default() }, ..standard };
    let truth = mean(&problem, &taylor::run(&problem, 32, 28, &mut |_| ())?);
    let (coarse, r) = linexp(&problem, 16, 6)?;
    Ok(HardResult {
        problem: "the slip touches zero without crossing it, except for the effect of friction on the motion",
        naive: thesis(&problem, truth)?,
        chosen: format!("linexp-6, n = 16: r {r:.9}"),
        checks: vec![
            Check::at_most("mean: deviation from taylor", r - truth, 1e-13),
            Check::at_most("mean: deviation from one", 1.0 - r, 2e-6),
            Check::bounded(&coarse),
        ],
    })
}

/// Runs a prescribed motion whose slip velocity touches zero once a period and is never negative,
/// except for round-off.
pub fn touching_given_motion() -> Result<HardResult, SolveError> {
    let standard = table_4_1(1.0, 200.0);
    let waveform = Waveform::new(Shape::Sine, standard.vibration_m_per_s(), DRIVE_HZ, standard.duration_s);
    let problem = Problem { motion: Motion::Kinematic, waveform, ..standard };
    let ((two, r_two), (six, r_six)) = (linexp(&problem, 16, 2)?, linexp(&problem, 16, 6)?);
    Ok(HardResult {
        problem: "the slip touches zero and stays positive, except for round-off",
        naive: thesis(&problem, 1.0)?,
        chosen: format!("linexp-6, n = 16: off one by {:.1e}", r_six - 1.0),
        checks: vec![
            Check::at_most("mean of linexp-2: deviation from one", r_two - 1.0, 3e-12),
            Check::at_most("mean of linexp-6: deviation from one", r_six - 1.0, 3e-12),
            Check::bounded(&two),
            Check::bounded(&six),
        ],
    })
}
