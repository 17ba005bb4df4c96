//! Vibration in the plane of the contact, at any angle to the sliding: along it, across it, or between.
//!
//! The sliding is along x, the vibration is given, at an angle a to x, and friction is a vector against the slip:
//!
//! ```text
//! slip       w = (Vt + u cos a, u sin a)                 u(t) the vibration velocity, of peak Vv
//! Coulomb    F = Fc w / |w|
//! Dahl       dB/dt = Kt (w - |w| B / Fc),  F = B         B force of the bristles, |B| <= Fc
//! LuGre      dB/dt = Kt (w - |w| B / G),   F = B + (sigma1 / Kt) dB/dt + sigma2 w,
//!            G(|w|) = Fc (1 + (Fs/Fc - 1) exp(-(|w| / Vs)^2))
//! ```
//!
//! At a = 0 these are the laws of [`problem`](super::problem). A bristle of a direction of its own for each of two coordinates would have a yield
//! surface that is a square; a vector against |w| is the isotropic one (Velenis, Tsiotras and Canudas-de-Wit 2005, *Dynamic tyre friction models for
//! combined longitudinal and lateral vehicle motion*; Dahl's law is theirs without Stribeck effect and damping).
//!
//! The friction ratio is `mean F_x / Fc`. Vibration across the sliding lowers it, too, but to a part that is proportional to the velocity ratio only up to
//! a logarithm (Littmann, Storck and Wallaschek 2001, *Sliding friction in the presence of ultrasonic oscillations: superposition of longitudinal
//! oscillations*, and Storck, Littmann, Wallaschek and Mracek 2002; Kumar and Hutchings 2004).
//!
//! | law | method | cost |
//! |---|---|---|
//! | Coulomb | [`coulomb`]: complete elliptic integrals, or elementary | nothing |
//! | Dahl, LuGre | `collocation`: a linear equation with known coefficients, whose solution over a stretch is the same function of its start in every period | one period, however many there are |
//!
//! A mass on a spring (`Motion::Sdof`) would have two more states and is not made: only a given vibration has an angle.

pub mod coulomb;
mod marks;
mod panel;
mod passage;
mod radau;
mod run;

use super::auto::{Clock, Numerics, Solution, ToleranceOf, of_whole_periods};
use super::problem::{Law, Motion, Problem};
use super::tally::Ratios;
use super::waveform::Shape;
use super::{Method, SolveError};
use run::Means;

/// Moments of the last period that are handed out.
const MOMENTS: u32 = 256;
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
    /// The direction at an angle to the sliding, degrees; exact at 0 and 90, and to round-off near them.
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

/// A moment of a contact whose vibration is at an angle.
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

/// What vibration at an angle does to friction.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneSolution {
    /// Means along the sliding, and how they were found.
    pub solution: Solution,
    /// Root mean square of the friction across the sliding over the window, N.
    pub transverse_rms_n: f64,
    /// The last period, both ends; empty if nobody asked for it.
    pub last_period: Vec<Moment>,
}

/// Solves a problem of a given vibration in this direction; `pause` is called every now and then. The last period is handed out if `moments`.
///
/// # Errors
/// Of a mass, whose vibration is not given; of a method that is not made for the law; of Coulomb friction under a waveform that is not periodic, or over a
/// window that is not whole periods under one load; of a tolerance of the record.
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

/// What is not made of a vibration at an angle.
fn refuse(problem: &Problem, numerics: &Numerics) -> Result<(), SolveError> {
    let unsuited = |reason: &str| Err(SolveError::Unsuited { method: numerics.method.name(), reason: reason.to_owned() });
    if problem.motion != Motion::Kinematic {
        return unsuited("only a given vibration can be at an angle to the sliding");
    }
    if numerics.tolerance_of == ToleranceOf::Record {
        return unsuited("vibration at an angle to the sliding has a tolerance of its mean only");
    }
    match (numerics.method, problem.law) {
        (Method::Auto, _) | (Method::Closed, Law::Coulomb) => Ok(()),
        (Method::Collocation, Law::Dahl { .. } | Law::Lugre { .. }) => Ok(()),
        (_, Law::Coulomb) => unsuited("Coulomb friction of a vibration at an angle has its closed form only"),
        _ => unsuited("bristles under a vibration at an angle are for collocation"),
    }
}

/// Power that keeps the vibration up: what friction takes beyond the work of the sliding.
fn input(problem: &Problem, power: Option<f64>, friction: f64) -> Option<f64> {
    power.map(|power| problem.sign.factor() * (power - friction))
}

/// Coulomb friction, which has no memory.
fn in_closed_form(
    problem: &Problem,
    direction: Direction,
    numerics: &Numerics,
    moments: bool,
) -> Result<PlaneSolution, SolveError> {
    let unsuited = |reason: &str| SolveError::Unsuited { method: Method::Closed.name(), reason: reason.to_owned() };
    if !of_whole_periods(problem) {
        return Err(unsuited("the window is not whole periods under one load"));
    }
    let peak = if problem.waveform.shape() == Shape::Still { 0.0 } else { problem.waveform.amplitude() };
    let means = coulomb::means(problem.waveform.shape(), problem.sliding_m_per_s / peak, direction)
        .ok_or_else(|| unsuited("the vibration is not periodic: bristles, [contact.dahl], go through any"))?;
    // Over Fc Vt, which is negative where the sliding is.
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
        ns_per_period: None,
    };
    let last_period = if moments { coulomb::period(problem, direction, MOMENTS) } else { Vec::new() };
    Ok(PlaneSolution { solution, transverse_rms_n: means.transverse_square.sqrt() * problem.coulomb_n.abs(), last_period })
}

/// Bristles.
fn by_collocation(
    problem: &Problem,
    direction: Direction,
    numerics: &Numerics,
    pause: &dyn Fn(),
    moments: bool,
) -> Result<PlaneSolution, SolveError> {
    let Means { friction, power, transverse_square, error, panels, coulomb_n } = run::means(problem, direction, pause)?;
    let last_period = if moments { run::last_period(problem, direction, MOMENTS, pause)? } else { Vec::new() };
    let tolerance_met = error <= numerics.tolerance;
    let missed = format!("the tolerance of {:e} is not met: the friction ratio is good to {error:.1e}", numerics.tolerance);
    let ratios = Ratios { friction, power, input: input(problem, power, friction), ..Ratios::default() };
    let solution = Solution {
        method: Method::Collocation,
        why: format!(
            "bristles in two directions: a period of the vibration is solved once, in {panels} panels of {} nodes",
            radau::STAGES
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
        ns_per_period: None,
    };
    Ok(PlaneSolution { solution, transverse_rms_n: transverse_square.sqrt() * coulomb_n, last_period })
}

#[cfg(test)]
mod tests;
