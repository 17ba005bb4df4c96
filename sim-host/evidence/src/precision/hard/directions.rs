//! Vibration in other directions than the sliding: bristles in two dimensions, and a contact that
//! vibration across it loads and unloads.

use std::f64::consts::{FRAC_PI_4, TAU};

use super::{Check, HardResult};
use contact::compliant::stepped;
use contact::compliant::{CompliantProblem, Press, friction_ratio, solve};
use contact::plane::{self, Direction, coulomb};
use contact::{Law, Motion, Numerics, Problem, Shape, Sign, SolveError, State, Waveform};

const HZ: f64 = 60e3;
const VIBRATION_M_PER_S: f64 = 0.05;
const COULOMB_N: f64 = 2.0;
const PERIODS: u32 = 40;
/// Steps a period of the thesis.
const STEPS: u32 = 1000;
/// Steps a period of the reference for a compliant contact.
const REFERENCE_STEPS: u32 = 1 << 17;

/// Returns Dahl's bristles under a prescribed sine, shorter than its amplitude by the factor kappa;
/// the mean covers the second half of the run.
pub fn bristles(kappa: f64, velocity_ratio: f64) -> Problem {
    let duration_s = f64::from(PERIODS) / HZ;
    Problem {
        motion: Motion::Kinematic,
        law: Law::Dahl { stiffness_n_per_m: kappa * TAU * HZ * COULOMB_N / VIBRATION_M_PER_S },
        coulomb_n: COULOMB_N,
        sliding_m_per_s: velocity_ratio * VIBRATION_M_PER_S,
        sign: Sign::Passive,
        waveform: Waveform::new(Shape::Sine, VIBRATION_M_PER_S, HZ, duration_s),
        start: State::default(),
        load_steps: Vec::new(),
        window_s: (0.5 * duration_s, duration_s),
        duration_s,
    }
}

/// Compares nearly rigid bristles at an angle with their limit, Coulomb's closed form.
pub fn in_plane(angle_deg: f64, velocity_ratio: f64) -> Result<HardResult, SolveError> {
    let problem = bristles(1e10, velocity_ratio);
    let numerics = Numerics { tolerance: 1e-9, ..Numerics::default() };
    let solved = plane::solve(&problem, Direction::from_degrees(angle_deg), &numerics, (&|| (), None), false)?.solution;
    let (r, limit) = (solved.ratios.friction, coulomb::friction_ratio(velocity_ratio, angle_deg));
    Ok(HardResult {
        problem: "bristles of 1e-10 of the amplitude in two dimensions, stiff except where the slip is smallest",
        naive: naive(&problem, angle_deg),
        chosen: format!("collocation: r {r:.9}, Coulomb's limit {limit:.9}"),
        checks: vec![
            Check::at_most("mean: deviation from Coulomb's limit", r - limit, 1e-8),
            Check::at_most("stated error", solved.error_estimate.unwrap_or(f64::NAN), 1e-9),
        ],
    })
}

/// Integrates the two bristle forces over Fc with the classical Runge-Kutta method at the thesis's
/// step.
fn naive(problem: &Problem, angle_deg: f64) -> String {
    let direction = Direction::from_degrees(angle_deg);
    let per_m = problem.law.stiffness_n_per_m().unwrap_or(f64::NAN) / problem.coulomb_n;
    let rates = |[x, y]: [f64; 2], turns: f64| {
        let u = VIBRATION_M_PER_S * (TAU * turns).cos();
        let (along, across) = (problem.sliding_m_per_s + direction.along * u, direction.across * u);
        let size = along.hypot(across);
        [per_m * (along - size * x), per_m * (across - size * y)]
    };
    let h = 1.0 / f64::from(STEPS);
    let step_s = h / HZ;
    let mut force = [0.0; 2];
    for step in 0..PERIODS * STEPS {
        let turns = f64::from(step) * h;
        let along = |k: [f64; 2], part: f64| [force[0] + part * step_s * k[0], force[1] + part * step_s * k[1]];
        let k1 = rates(force, turns);
        let k2 = rates(along(k1, 0.5), turns + 0.5 * h);
        let k3 = rates(along(k2, 0.5), turns + 0.5 * h);
        let k4 = rates(along(k3, 1.0), turns + h);
        force = [0, 1].map(|i| force[i] + step_s / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        let size = force[0].hypot(force[1]);
        if size.is_nan() || size > 1e3 {
            return format!("n = {STEPS}: diverges in period {:.3}", f64::from(step + 1) * h);
        }
    }
    format!("n = {STEPS}: survives")
}

/// Returns a contact under constant load, in units of its load and stiffnesses.
pub fn contact(indentations: f64, speed: f64) -> CompliantProblem {
    CompliantProblem {
        mu: 0.3,
        press: Press::Load(1.0),
        normal_n_per_m: 1.0,
        tangential_n_per_m: 1.0,
        amplitude_m: indentations,
        frequency_hz: 1.0 / TAU,
        sliding_m_per_s: speed * 0.3 * indentations,
    }
}

/// Runs a contact that is lost for most of the period.
pub fn parted() -> Result<HardResult, SolveError> {
    let problem = contact(1e3, 0.1);
    let (solution, coarse, fine) = (solve(&problem)?, stepped::solve(&problem, STEPS), stepped::solve(&problem, REFERENCE_STEPS));
    let (r, steps) = (solution.coefficient_ratio, fine.coefficient_ratio);
    Ok(HardResult {
        problem: "contact for a fifteenth of the period, in which friction never reaches mu N for long",
        naive: format!("return mapping, n = {STEPS}: mean off by {:.1e}", coarse.coefficient_ratio - r),
        chosen: format!("arcs: r {r:.9}, in contact for {:.4} of the period", solution.contact_share),
        checks: vec![
            Check::between("r", r, 0.0, 1.0),
            Check::at_most("mean: deviation from 131 072 steps, over their uncertainty", (r - steps) / fine.unknown, 4.0),
            Check::at_most("uncertainty of 131 072 steps", fine.unknown, 1e-5),
        ],
    })
}

/// Runs a contact just below the critical speed, where the effect vanishes with the square of the
/// distance to it.
pub fn near_critical() -> Result<HardResult, SolveError> {
    const BELOW_CRITICAL_REL: f64 = 1e-4;
    let problem = contact(0.5, 1.0 - BELOW_CRITICAL_REL);
    let lost = 1.0 - friction_ratio(0.5, 1.0 - BELOW_CRITICAL_REL, true);
    // A (9 / (4 pi)) (1 - s)^2, docs/evidence/normal-vibration.md.
    let limit = 0.5 * 9.0 / (16.0 * FRAC_PI_4) * BELOW_CRITICAL_REL * BELOW_CRITICAL_REL;
    let coarse = stepped::solve(&problem, STEPS);
    Ok(HardResult {
        problem: "the contact sticks for a short time only, and loses 1e-8 of its friction",
        naive: format!("return mapping, n = {STEPS}: loses {:.1e}", 1.0 - coarse.coefficient_ratio),
        chosen: format!("arcs: loses {lost:.4e}, the limit {limit:.4e}"),
        checks: vec![Check::at_most("loss: deviation from its limit, relative", lost / limit - 1.0, 1e-3)],
    })
}
