//! Vibration in the plane of the contact, at any angle to the sliding: along it, across it, or
//! between.
//!
//! The sliding is along x, the vibration is given, at an angle a to x, and friction is a vector
//! opposite to the slip:
//!
//! ```text
//! slip       w = (Vt + u cos a, u sin a)                 u(t) the vibration velocity, of peak Vv
//! Coulomb    F = Fc w / |w|
//! Dahl       dB/dt = Kt (w - |w| B / Fc),  F = B         B force of the bristles, |B| <= Fc
//! LuGre      dB/dt = Kt (w - |w| B / G),   F = B + (sigma1 / Kt) dB/dt + sigma2 w,
//!            G(|w|) = Fc (1 + (Fs/Fc - 1) exp(-(|w| / Vs)^2))
//! ```
//!
//! At a = 0 these are the laws of [`problem`](super::problem). Separate bristles for each of the
//! two coordinates would have a square yield surface. The vector law with |w| is isotropic
//! (Velenis, Tsiotras and Canudas-de-Wit 2005, *Dynamic tyre friction models for combined
//! longitudinal and lateral vehicle motion*; Dahl's law is theirs without Stribeck effect and
//! damping).
//!
//! The friction ratio is `mean F_x / Fc`. Vibration across the sliding lowers it, too; at small
//! velocity ratios it is proportional to the velocity ratio times a logarithm (Littmann, Storck and
//! Wallaschek 2001, *Sliding friction in the presence of ultrasonic oscillations: superposition of
//! longitudinal oscillations*, and Storck, Littmann, Wallaschek and Mracek 2002; Kumar and
//! Hutchings 2004).
//!
//! | law | method | cost |
//! |---|---|---|
//! | Coulomb | [`coulomb`]: complete elliptic integrals, or elementary | negligible |
//! | Dahl, LuGre | `collocation`: a linear equation with known coefficients, whose solution over a stretch is the same function of its start in every period | one period, independent of their number |
//!
//! A mass on a spring (`Motion::Sdof`) would need two more states and is not supported: only a
//! given vibration can be at an angle.

pub mod coulomb;
mod marks;
mod panel;
mod passage;
mod run;

use super::auto::{Clock, Numerics, Solution, ToleranceOf, of_whole_periods};
use super::problem::{Law, Motion, Problem};
use super::radau::STAGES;
use super::tally::Ratios;
use super::waveform::Shape;
use super::{Method, SolveError};
use run::Means;

/// Number of steps into which the last period is divided for the caller.
const PERIOD_STEPS: u32 = 256;
/// Round-off of the closed forms.
const ROUND_OFF: f64 = 1e-14;

/// Direction of the vibration, a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Component along the sliding.
    pub along: f64,
    /// Component across the sliding.
    pub across: f64,
}

impl Direction {
    /// Returns the direction at an angle to the sliding, degrees; exact at 0 and 90, and accurate
    /// to round-off near them.
    pub fn from_degrees(angle_deg: f64) -> Self {
        let small = |degrees: f64| degrees.to_radians().sin_cos();
        if angle_deg <= 45.0 {
            let (across, along) = small(angle_deg);
            Direction { along, across }
        } else {
            let (along, across) = small(90.0 - angle_deg);
            Direction { along, across }
        }
    }
}

/// Moment of a contact whose vibration is at an angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Time of the moment, s.
    pub time_s: f64,
    /// Displacement of the vibration in its own direction, m.
    pub displacement_m: f64,
    /// Velocity of the vibration in its own direction, m/s.
    pub vibration_m_per_s: f64,
    /// Slip velocity along and across the sliding, m/s.
    pub slip_m_per_s: [f64; 2],
    /// Friction along and across the sliding, N.
    pub friction_n: [f64; 2],
}

/// Effect of a vibration at an angle on friction.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneSolution {
    /// Means along the sliding, and the method used.
    pub solution: Solution,
    /// Root mean square of the friction across the sliding over the window, N.
    pub transverse_rms_n: f64,
    /// Moments of the last period, both ends included; empty unless requested.
    pub last_period: Vec<Moment>,
}

/// Solves a problem with a given vibration in this direction. `pause` is called from time to time.
/// With `moments`, the last period is returned, too.
///
/// # Errors
/// Fails for an oscillator, whose vibration is not given; for a method that does not apply to the
/// law; for a tolerance of the record. Coulomb friction also requires a periodic waveform, and a
/// window of whole periods under one load.
pub fn solve(
    problem: &Problem,
    direction: Direction,
    numerics: &Numerics,
    (pause, clock): (&dyn Fn(), Option<Clock>),
    moments: bool,
) -> Result<PlaneSolution, SolveError> {
    refuse(problem, numerics)?;
    let began = clock.map(|clock| clock());
    let mut solved = match problem.law {
        Law::Coulomb => in_closed_form(problem, direction, numerics, moments)?,
        _ => by_collocation(problem, direction, numerics, pause, moments)?,
    };
    let periods = problem.duration_s * problem.waveform.frequency_hz();
    solved.solution.ns_per_period = clock.zip(began).map(|(clock, began)| (clock() - began).as_secs_f64() * 1e9 / periods);
    Ok(solved)
}

/// Refuses problems that a vibration at an angle does not support.
fn refuse(problem: &Problem, numerics: &Numerics) -> Result<(), SolveError> {
    let unsuited = |reason: &str| Err(SolveError::Unsuited { method: numerics.method.name(), reason: reason.to_owned() });
    if problem.motion != Motion::Kinematic {
        return unsuited("only a given vibration can be at an angle to the sliding");
    }
    if numerics.tolerance_of == ToleranceOf::Record {
        return unsuited("the tolerance of a vibration at an angle to the sliding applies to the mean only");
    }
    match (numerics.method, problem.law) {
        (Method::Auto, _) | (Method::Closed, Law::Coulomb) => Ok(()),
        (Method::Collocation, Law::Dahl { .. } | Law::Lugre { .. }) => Ok(()),
        (_, Law::Coulomb) => unsuited("Coulomb friction under a vibration at an angle has a closed form only"),
        _ => unsuited("bristles under a vibration at an angle require collocation"),
    }
}

/// Returns the power that sustains the vibration: the dissipation of friction beyond the work of
/// the sliding.
fn input(problem: &Problem, power: Option<f64>, friction: f64) -> Option<f64> {
    power.map(|power| problem.sign.factor() * (power - friction))
}

/// Solves Coulomb friction, which has no memory.
fn in_closed_form(
    problem: &Problem,
    direction: Direction,
    numerics: &Numerics,
    moments: bool,
) -> Result<PlaneSolution, SolveError> {
    let unsuited = |reason: &str| SolveError::Unsuited { method: Method::Closed.name(), reason: reason.to_owned() };
    if !of_whole_periods(problem) {
        return Err(unsuited("the window is not a whole number of periods under one load"));
    }
    let peak = if problem.waveform.shape() == Shape::Still { 0.0 } else { problem.waveform.amplitude() };
    let means = coulomb::means(problem.waveform.shape(), problem.sliding_m_per_s / peak, direction)
        .ok_or_else(|| unsuited("the vibration is not periodic; use bristles, [contact.dahl], which accept any waveform"))?;
    // The dissipated power is positive. Divided by Fc Vt it has the sign of the sliding speed Vt.
    let power = means.power.map(|power| power.copysign(problem.sliding_m_per_s));
    let ratios = Ratios { friction: means.friction, power, input: input(problem, power, means.friction), ..Ratios::default() };
    let solution = Solution {
        method: Method::Closed,
        why: "Coulomb friction of a vibration at an angle to the sliding: closed form".into(),
        steps_per_period: None,
        order: None,
        ratios,
        tally: None,
        error_estimate: Some(ROUND_OFF),
        record_error_estimate: None,
        tolerance_met: ROUND_OFF <= numerics.tolerance,
        warnings: Vec::new(),
        states: 0,
        orbit: None,
        ns_per_period: None,
    };
    let last_period = if moments { coulomb::period(problem, direction, PERIOD_STEPS) } else { Vec::new() };
    Ok(PlaneSolution { solution, transverse_rms_n: means.transverse_square.sqrt() * problem.coulomb_n.abs(), last_period })
}

/// Solves friction with bristles.
fn by_collocation(
    problem: &Problem,
    direction: Direction,
    numerics: &Numerics,
    pause: &dyn Fn(),
    moments: bool,
) -> Result<PlaneSolution, SolveError> {
    let Means { friction, power, transverse_square, error, panels, coulomb_n } = run::means(problem, direction, pause)?;
    let last_period = if moments { run::last_period(problem, direction, PERIOD_STEPS, pause)? } else { Vec::new() };
    let tolerance_met = error <= numerics.tolerance;
    let missed = format!("the tolerance of {:e} is not met: the error of the friction ratio is {error:.1e}", numerics.tolerance);
    let ratios = Ratios { friction, power, input: input(problem, power, friction), ..Ratios::default() };
    let solution = Solution {
        method: Method::Collocation,
        why: format!(
            "bristles in two directions: a period of the vibration is solved once, in {panels} panels of {} nodes",
            STAGES
        ),
        steps_per_period: None,
        order: None,
        ratios,
        tally: None,
        error_estimate: Some(error),
        record_error_estimate: None,
        tolerance_met,
        warnings: (!tolerance_met).then_some(missed).into_iter().collect(),
        states: 2,
        orbit: None,
        ns_per_period: None,
    };
    Ok(PlaneSolution { solution, transverse_rms_n: transverse_square.sqrt() * coulomb_n, last_period })
}

#[cfg(test)]
mod tests;
