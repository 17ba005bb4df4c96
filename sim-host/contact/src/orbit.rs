//! Periodic steady state: the motion that repeats after one period of the excitation, by shooting.
//!
//! ```text
//! s = (x, x', f)       state at the beginning of a period; f, the force in the bristles over Fc
//! P(s)                 state one period later, by time steps
//! s* = P(s*)           steady state, by Newton's method: (I - P') ds = P(s) - s, P' by differences
//! |lambda| of P'       below one: a small disturbance decays by this factor in each period
//! ```
//!
//! T. S. Parker, L. O. Chua, Practical Numerical Algorithms for Chaotic Systems, Springer 1989,
//! chapter 5. A weakly damped oscillator reaches its steady state only after many periods; Newton's
//! method needs a dozen.

use crate::SolveError;
use crate::auto::{Numerics, Runs, ToleranceOf, by_method, stable_steps};
use crate::method::{Method, rates::level};
use crate::problem::{Law, Motion, Problem};
use crate::shooting::{self, Lost, Map as _, difference, newton_step};
use crate::state::State;

/// Largest error of the record of one period, from which the steps of the map follow.
const RECORD_TOLERANCE: f64 = 1e-9;
/// Number of steps for the stability of a Runge-Kutta method above which LuGre's bristles are too
/// stiff for the search.
const MAX_STABLE_STEPS: f64 = 5000.0;
/// Largest amplification of the force in the bristles by its computation from the whole friction.
const MAX_BRISTLE_GAIN: f64 = 1e3;

/// Periodic steady state of a problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// State at the beginning of a period; `force_n` is the force in the bristles.
    pub start: State,
    /// Difference of the state after one period, over the vibration and Fc.
    pub residual: f64,
    /// Largest modulus of a Floquet multiplier: factor by which a disturbance decays per period.
    pub multiplier: f64,
    /// Error of the mean friction ratio due to the steps of the search.
    pub error: f64,
    /// Method of the search.
    pub method: Method,
    /// Steps per period and order of its last steps.
    pub setting: (u32, Option<u32>),
}

/// Reason why a problem has no known steady state.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Unsteady {
    /// The excitation or the load is not periodic.
    #[error("the excitation and the load do not repeat")]
    Aperiodic,
    /// Newton's method has found no state that repeats.
    #[error("no motion was found that repeats after one period")]
    NotFound,
    /// A disturbance of the steady state grows.
    #[error("the motion that repeats is unstable, because a disturbance grows by {:.1e} of itself in each period", .0 - 1.0)]
    Unstable(f64),
    /// A disturbance decays too slowly, or not at all.
    #[error("the steady state depends on the start, or the motion approaches it too slowly to tell")]
    NotUnique,
    /// The bristles of LuGre's law are too stiff.
    #[error("the bristles are too stiff for the search of the steady state")]
    TooStiff,
}

impl From<Lost> for Unsteady {
    fn from(lost: Lost) -> Self {
        match lost {
            Lost::NotFound => Unsteady::NotFound,
            Lost::Unstable(multiplier) => Unsteady::Unstable(multiplier),
            Lost::NotUnique => Unsteady::NotUnique,
        }
    }
}

impl Orbit {
    /// Number of periods after which a small disturbance is a thousandth.
    pub fn settling_periods(&self) -> f64 {
        if self.multiplier > 0.0 { (1e-3f64.ln() / self.multiplier.ln()).max(0.0) } else { 0.0 }
    }

    /// Returns one steady period as a problem.
    pub fn period(&self, problem: &Problem) -> Problem {
        let period_s = 1.0 / problem.waveform.frequency_hz();
        Problem { start: self.start, window_s: (0.0, period_s), duration_s: period_s, ..problem.clone() }
    }

    /// Finds the steady state of a problem; its start is the first guess, its window has no effect.
    ///
    /// # Errors
    /// If there is none, or if it is unstable or not unique.
    pub(crate) fn new(problem: &Problem, runs: &dyn Runs) -> Result<Orbit, Unsteady> {
        if !problem.waveform.is_periodic() || !problem.load_steps.is_empty() {
            return Err(Unsteady::Aperiodic);
        }
        if matches!(problem.law, Law::Lugre { .. }) && stable_steps(problem) > MAX_STABLE_STEPS {
            return Err(Unsteady::TooStiff);
        }
        let map = Map::new(problem, runs).map_err(|_| Unsteady::NotFound)?;
        let fixed = shooting::find(&map, map.start())?;
        // The same by half the step shows the error of the map, which many periods amplify.
        let finer = Map { setting: (2 * map.setting.0, map.setting.1), ..map.clone() };
        let (after, _) = finer.advance(&fixed.at).ok_or(Unsteady::NotFound)?;
        let shift = newton_step(&fixed.derivative, &difference(&after, &fixed.at)).ok_or(Unsteady::NotUnique)?;
        let at_finer: Vec<f64> = fixed.at.iter().zip(shift).map(|(at, shift)| at + shift).collect();
        let (_, mean_finer) = finer.advance(&at_finer).ok_or(Unsteady::NotFound)?;
        let error = (mean_finer - fixed.mean).abs();
        let (residual, multiplier) = (fixed.residual, fixed.multiplier);
        Ok(Orbit { start: map.state(&at_finer), residual, multiplier, error, method: finer.method, setting: finer.setting })
    }
}

/// Map of the state over one period.
#[derive(Clone)]
struct Map<'a> {
    runs: &'a dyn Runs,
    period: Problem,
    method: Method,
    setting: (u32, Option<u32>),
    /// Displacement, m, velocity, m/s, and bristle force over Fc that count as one.
    scale: [f64; 3],
    /// `true` for each part of the state that is free: a given motion has no own state, Coulomb's
    /// law no bristles.
    free: [bool; 3],
}

impl<'a> Map<'a> {
    fn new(problem: &Problem, runs: &'a dyn Runs) -> Result<Self, SolveError> {
        let period_s = 1.0 / problem.waveform.frequency_hz();
        let period = Problem { window_s: (0.0, period_s), duration_s: period_s, ..problem.clone() };
        let numerics = Numerics {
            tolerance: RECORD_TOLERANCE,
            tolerance_of: ToleranceOf::Record,
            energies: false,
            steady: false,
            ..Numerics::default()
        };
        let solution = by_method(&period, &numerics, runs, None::<&mut fn(&State)>)?;
        // At its resonance, an undamped oscillator has no steady vibration without friction.
        let peak = || solution.tally.map_or(0.0, |tally| tally.peak_velocity_m_per_s);
        let vibration = Some(problem.vibration_m_per_s()).filter(|speed| speed.is_finite()).unwrap_or_else(peak);
        let speed = vibration.max(problem.sliding_m_per_s.abs()).max(f64::MIN_POSITIVE);
        let moves = problem.motion != Motion::Kinematic;
        Ok(Map {
            runs,
            method: solution.method,
            setting: (solution.steps_per_period.unwrap_or(1), solution.order),
            scale: [speed * period_s / std::f64::consts::TAU, speed, 1.0],
            free: [moves, moves, problem.law != Law::Coulomb],
            period,
        })
    }

    /// Returns a state; its friction is the force in the bristles.
    fn state(&self, at: &[f64]) -> State {
        let [x_m, v_m_per_s, f] = std::array::from_fn(|i| at[i] * self.scale[i]);
        State { time_s: 0.0, x_m, v_m_per_s, force_n: f * self.period.coulomb_n }
    }

    /// Returns the start of the problem, the first guess.
    fn start(&self) -> Vec<f64> {
        let start = self.period.start;
        let start = [start.x_m, start.v_m_per_s, start.force_n / self.period.coulomb_n];
        (0..3).map(|i| if self.free[i] { start[i] / self.scale[i] } else { 0.0 }).collect()
    }
}

impl shooting::Map for Map<'_> {
    fn is_free(&self, part: usize) -> bool {
        self.free[part]
    }

    fn advance(&self, at: &[f64]) -> Option<(Vec<f64>, f64)> {
        let problem = Problem { start: self.state(at), ..self.period.clone() };
        let tally = self.runs.run(&problem, self.method, self.setting, false).ok()?;
        let last = tally.last;
        let after = [last.x_m, last.v_m_per_s, bristles_n(&problem, &last)? / problem.coulomb_n];
        let after: Vec<f64> = (0..3).map(|i| if self.free[i] { after[i] / self.scale[i] } else { at[i] }).collect();
        let mean = tally.totals.friction_n_s / (tally.coulomb_n * tally.time_s);
        after.iter().all(|part| part.is_finite()).then_some((after, mean))
    }
}

/// Returns the force in the bristles of a state, N: for LuGre's law,
/// `F = Kt z + sigma1 (V - |V| Kt z / (Kt G)) + sigma2 V`. `None` if the whole friction hardly
/// depends on it.
fn bristles_n(problem: &Problem, state: &State) -> Option<f64> {
    let Law::Lugre { static_ratio, stribeck_m_per_s, sigma1, sigma2, .. } = problem.law else { return Some(state.force_n) };
    let slip = problem.sliding_m_per_s + problem.sign.factor() * state.v_m_per_s;
    let level_n = level(static_ratio, stribeck_m_per_s, slip) * problem.coulomb_n;
    let share = 1.0 - sigma1 * slip.abs() / level_n;
    (share.abs() > 1.0 / MAX_BRISTLE_GAIN).then(|| (state.force_n - (sigma1 + sigma2) * slip) / share)
}

#[cfg(test)]
mod tests;
