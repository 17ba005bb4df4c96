//! Vibration across a contact with constant stiffness in both directions: a normal oscillation
//! lowers friction through tangential compliance.
//!
//! The indentation is given, and the body slides over the contact at constant speed v:
//!
//! ```text
//! u(t) = u0 + a cos(w t)                 indentation
//! N    = kz u for u > 0, else 0          normal force
//! f' = kx v   while f < mu N             the contact sticks, and the tangential spring is loaded
//! f  = mu N   otherwise                  it slips; when contact is lost, the spring relaxes
//! ```
//!
//! (M. Popov, V. L. Popov, N. V. Popov, *Reduction of friction by normal oscillations. I. Influence
//! of contact stiffness*, Friction 5 (2017) 45, doi 10.1007/s40544-016-0136-4; X. Mao, V. L. Popov,
//! J. Starcevic, M. Popov, *II. In-plane system dynamics*, Friction 5 (2017) 194.)
//!
//! While the normal force rises faster than the spring is loaded, the contact sticks, and friction
//! stays below mu N. In units of `mu kz a` and of the phase, the steady state depends on two
//! numbers,
//!
//! ```text
//! A = a / u0                             amplitude in mean indentations; contact is lost above one
//! s = kx v / (mu kz w a)                 sliding speed over the critical speed, at which the
//!                                        spring is loaded as fast as the normal force can rise
//! ```
//!
//! and is computed from its arcs, without time steps (`arcs`). For A <= 1 the paper approximates it
//! by `1 - (3/4) A (1 - s)^2 - (1/4) A (1 - s)^4` for s < 1, and by one for larger s
//! ([`popov_ratio`]). The error of this approximation is at most 0.0144 A.
//!
//! Above A = 1 the result depends on the held quantity. With the indentation u0 held, the mean
//! normal force rises. With the mean load W held, the bodies move apart instead, as in
//! [`super::hertz`]. If the mean position is a gap, u0 < 0, contact begins after the phase of the
//! fastest rise of the normal force, and the critical speed falls to `sqrt(1 - (u0 / a)^2)` times
//! the paper's.
//!
//! The model is quasi-static: no inertia of the body or of the contact, stiffnesses independent of
//! the load, no partial slip within the contact.

mod arcs;
pub mod stepped;

use std::f64::consts::TAU;

use super::SolveError;
use arcs::{Arcs, Indentation};

const METHOD: &str = "compliant";

/// Number of steps into which a displayed period is divided, in addition to its events.
const PERIOD_STEPS: u32 = 256;
/// Error of the ratios, relative to the larger of one and the ratio: a few roundings of the arcs
/// (test `agrees_with_fifty_digits`).
const ROUND_OFF: f64 = 1e-14;

/// Quantity that is held while the bodies vibrate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Press {
    /// Mean normal force, N.
    Load(f64),
    /// Mean indentation, m; negative for a mean gap.
    Indentation(f64),
}

/// Compliant contact whose bodies vibrate across it while they slide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompliantProblem {
    /// Coefficient of friction of the contact.
    pub mu: f64,
    /// Quantity that is held while the bodies vibrate.
    pub press: Press,
    /// Normal stiffness kz, N/m.
    pub normal_n_per_m: f64,
    /// Tangential stiffness kx, N/m.
    pub tangential_n_per_m: f64,
    /// Amplitude of the vibration a, m.
    pub amplitude_m: f64,
    /// Frequency of the vibration, Hz.
    pub frequency_hz: f64,
    /// Sliding speed v, m/s. At zero the solution is the limit of slow sliding, which is the static
    /// friction.
    pub sliding_m_per_s: f64,
}

/// Steady state of a compliant contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompliantSolution {
    /// Mean friction over that without vibration, `mean f / (mu W)`, where W is the held load or
    /// `kz u0` of the held indentation. `None` for a mean gap, which has no friction without
    /// vibration.
    pub friction_ratio: Option<f64>,
    /// Mean friction over mu times the mean normal force: ratio of the coefficients of friction.
    /// With a held load it equals `friction_ratio`.
    pub coefficient_ratio: f64,
    /// Mean friction, N.
    pub friction_n: f64,
    /// Mean normal force, N.
    pub mean_normal_n: f64,
    /// Largest normal force, N.
    pub peak_normal_n: f64,
    /// Mean position u0, m: indentation if positive, a mean gap if negative.
    pub mean_place_m: f64,
    /// Fraction of the period in contact.
    pub contact_share: f64,
    /// Fraction of the period in which the contact sticks.
    pub stick_share: f64,
    /// Sliding speed above which the contact never sticks, m/s.
    pub critical_m_per_s: f64,
    /// Number of periods after which a run with an initially relaxed spring is in the steady state;
    /// infinite without sliding if contact is never lost.
    pub settle_periods: f64,
    /// Round-off error of both ratios.
    pub error_estimate: f64,
}

/// Moment of the period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompliantPoint {
    /// Phase of the vibration since the deepest indentation, turns.
    pub phase_turns: f64,
    /// Indentation u, m; negative for a gap.
    pub indentation_m: f64,
    /// Normal force, N.
    pub normal_n: f64,
    /// Friction, N.
    pub friction_n: f64,
}

/// Returns Popov's closed form of the friction ratio, for an amplitude of up to one mean
/// indentation; `None` above, because contact is lost.
///
/// `indentations` is A, `speed_ratio` is s: sliding speed over the critical speed.
pub fn popov_ratio(indentations: f64, speed_ratio: f64) -> Option<f64> {
    let below = (1.0 - speed_ratio).max(0.0);
    (indentations <= 1.0).then(|| 1.0 - indentations * (0.75 * below.powi(2) + 0.25 * below.powi(4)))
}

/// Returns the friction ratio for an amplitude of A mean indentations and a sliding speed s, with
/// the mean load or the mean indentation held.
pub fn friction_ratio(indentations: f64, speed_ratio: f64, load_is_held: bool) -> f64 {
    if indentations == 0.0 {
        return 1.0;
    }
    let indentation = if load_is_held { Indentation::under(indentations.recip()) } else { Indentation::at(indentations.recip()) };
    Arcs::new(indentation, speed_ratio).mean_friction() * indentations
}

/// Solves for the steady state.
///
/// # Errors
/// Fails if a value is out of its range, or if the bodies never touch.
pub fn solve(problem: &CompliantProblem) -> Result<CompliantSolution, SolveError> {
    let arcs = Unit::new(problem)?;
    Ok(arcs.map_or_else(|| without_vibration(problem), |unit| unit.solution(problem)))
}

/// Returns one steady period, both ends included, with the moments at which the contact begins to
/// stick, to slip, to touch and to part.
///
/// # Errors
/// The errors of [`solve`].
pub fn period(problem: &CompliantProblem) -> Result<Vec<CompliantPoint>, SolveError> {
    let unit = Unit::new(problem)?;
    let solution = unit.as_ref().map_or_else(|| without_vibration(problem), |unit| unit.solution(problem));
    let (kz, mu) = (problem.normal_n_per_m, problem.mu);
    let point = |phase_turns: f64| match &unit {
        Some(unit) => {
            let (place, friction) = unit.arcs.at(TAU * phase_turns);
            let indentation_m = solution.mean_place_m + problem.amplitude_m * place;
            let normal_n = kz * indentation_m.max(0.0);
            CompliantPoint { phase_turns, indentation_m, normal_n, friction_n: mu * unit.force_n * friction }
        }
        None => CompliantPoint {
            phase_turns,
            indentation_m: solution.mean_place_m,
            normal_n: solution.mean_normal_n,
            friction_n: solution.friction_n,
        },
    };
    let mut phases: Vec<f64> = (0..=PERIOD_STEPS).map(|step| f64::from(step) / f64::from(PERIOD_STEPS)).collect();
    let events = unit.iter().flat_map(|unit| unit.arcs.events());
    phases.extend(events.map(|phase| (phase / TAU).rem_euclid(1.0)));
    phases.sort_by(f64::total_cmp);
    phases.dedup();
    Ok(phases.into_iter().map(point).collect())
}

/// Contact in units of its vibration.
struct Unit {
    arcs: Arcs,
    /// Unit of the normal force, kz a, N.
    force_n: f64,
    /// Unit of the sliding speed, mu kz w a / kx, m/s.
    speed_m_per_s: f64,
}

impl Unit {
    /// Computes the arcs of a problem; `None` for a contact without vibration.
    fn new(problem: &CompliantProblem) -> Result<Option<Self>, SolveError> {
        let unsuited = |reason: String| Err(SolveError::Unsuited { method: METHOD, reason });
        let (held, name) = match problem.press {
            Press::Load(normal_n) => (normal_n / problem.normal_n_per_m, "load"),
            Press::Indentation(indentation_m) => (indentation_m, "indentation"),
        };
        let positive = [
            ("coefficient of friction", problem.mu),
            ("normal stiffness", problem.normal_n_per_m),
            ("tangential stiffness", problem.tangential_n_per_m),
            ("frequency", problem.frequency_hz),
        ];
        if let Some((what, value)) = positive.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite())) {
            return unsuited(format!("the {what} is {value}, and must be above zero"));
        }
        for (what, value) in [("amplitude", problem.amplitude_m), ("sliding speed", problem.sliding_m_per_s)] {
            if !(value >= 0.0 && value.is_finite()) {
                return unsuited(format!("the {what} is {value}, and must not be below zero"));
            }
        }
        if !held.is_finite() {
            return unsuited(format!("the {name} must be a number"));
        }
        if held <= 0.0 && name == "load" {
            return unsuited("the load must be above zero".into());
        }
        if held + problem.amplitude_m <= 0.0 {
            let gap_m = -held;
            return unsuited(format!(
                "the bodies never touch: a mean gap of {gap_m:e} m, and an amplitude of {:e} m",
                problem.amplitude_m
            ));
        }
        let depth = held / problem.amplitude_m;
        if !depth.is_finite() {
            return Ok(None);
        }
        let force_n = problem.normal_n_per_m * problem.amplitude_m;
        let speed_m_per_s = problem.mu * force_n * TAU * problem.frequency_hz / problem.tangential_n_per_m;
        let indentation = if name == "load" { Indentation::under(depth) } else { Indentation::at(depth) };
        Ok(Some(Unit { arcs: Arcs::new(indentation, problem.sliding_m_per_s / speed_m_per_s), force_n, speed_m_per_s }))
    }

    fn solution(&self, problem: &CompliantProblem) -> CompliantSolution {
        let arcs = &self.arcs;
        let (friction, normal) = (arcs.mean_friction(), arcs.mean_normal());
        let nominal = match problem.press {
            Press::Load(normal_n) => normal_n / self.force_n,
            Press::Indentation(indentation_m) => indentation_m / problem.amplitude_m,
        };
        let friction_ratio = (nominal > 0.0).then(|| friction / nominal);
        CompliantSolution {
            friction_ratio,
            coefficient_ratio: friction / normal,
            friction_n: problem.mu * self.force_n * friction,
            mean_normal_n: self.force_n * normal,
            peak_normal_n: self.force_n * arcs.peak_normal(),
            mean_place_m: problem.amplitude_m * arcs.mean_place(),
            contact_share: arcs.contact_share(),
            stick_share: arcs.stick_share(),
            critical_m_per_s: self.speed_m_per_s * arcs.critical(),
            settle_periods: arcs.settle_periods(),
            error_estimate: ROUND_OFF * friction_ratio.unwrap_or(1.0).max(1.0),
        }
    }
}

/// Returns steady sliding, in which friction is mu N.
fn without_vibration(problem: &CompliantProblem) -> CompliantSolution {
    let (normal_n, place_m) = match problem.press {
        Press::Load(normal_n) => (normal_n, normal_n / problem.normal_n_per_m),
        Press::Indentation(indentation_m) => (problem.normal_n_per_m * indentation_m, indentation_m),
    };
    // The spring is loaded to mu N once.
    let loading_s = problem.mu * normal_n / (problem.tangential_n_per_m * problem.sliding_m_per_s);
    CompliantSolution {
        friction_ratio: Some(1.0),
        coefficient_ratio: 1.0,
        friction_n: problem.mu * normal_n,
        mean_normal_n: normal_n,
        peak_normal_n: normal_n,
        mean_place_m: place_m,
        contact_share: 1.0,
        stick_share: 0.0,
        critical_m_per_s: 0.0,
        settle_periods: loading_s * problem.frequency_hz,
        error_estimate: ROUND_OFF,
    }
}

#[cfg(test)]
mod tests;
