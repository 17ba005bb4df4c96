//! The settings of a method in order of cost, as the rungs of a ladder; each rung has about a
//! quarter of the error of the one before.
//!
//! | method | rungs (order/steps per period) | error of a rung over that of the one before |
//! |---|---|---|
//! | linexp, frozen | 4/4 4/6 6/6 6/8 6/12 10/8 10/12 10/16 10/24 ...; more for a stiff contact | 1/4 ... 1/100 |
//! | rk4-events | steps times 1.5 | 1.5^-4 = 1/5 |
//! | midpoint | steps times 2 | 1/4 with bristle damping, 1/16 without |
//! | taylor | order 8, 12, 16 ... 32, with steps that end by their last terms; at a given order, steps times 1.5 | 1e-2 or less |
//!
//! Stability bounds the step of a Runge-Kutta method, `|rate| h < 2.785`: the first rung follows
//! from the fastest rate of the contact, which [`stable_steps`] computes.

use std::f64::consts::TAU;

use crate::method::{Method, taylor};
use crate::problem::{Law, Motion, Problem};

/// Expected ratio of the errors of two successive rungs.
pub const CONTRACTION: f64 = 0.25;
/// Smallest ratio of the errors of two successive rungs that is counted on.
const BEST_CONTRACTION: f64 = 0.03;
/// Smallest ratio of the errors of two successive orders of the Taylor series.
const BEST_ORDER_CONTRACTION: f64 = 1e-2;
/// Largest number of steps per period that is tried, unless stability requires more.
const MAX_STEPS_PER_PERIOD: u32 = 1 << 14;
/// Largest number of steps per period of linexp, which reaches round-off at this number.
const MAX_STEPS_PER_PERIOD_LINEXP: f64 = 2048.0;
/// Largest number of steps of one run of linexp, if fewer can be expected to suffice.
const MAX_RUN_STEPS_LINEXP: f64 = 1e7;
/// Steps per period of the Taylor series: so few that they do not limit its own steps.
const SERIES_STEPS_PER_PERIOD: f64 = 4.0;
/// Largest number of steps of one run that stability may require.
const MAX_RUN_STEPS: f64 = 1e8;
/// Largest change of the slip in a step, in Stribeck velocities.
const LARGEST_CHANGE_STRIBECK: f64 = 6.0;
/// Stability limit of the classical Runge-Kutta method on the negative real axis: largest rate
/// times step.
const STABILITY_LIMIT: f64 = 2.785;

/// Value of kappa in the thesis's contact, for which the start of the search is chosen.
const THESIS_KAPPA: f64 = 0.4;
/// Number of rungs by which the search starts higher for each halving of the bristles' length.
const RUNGS_PER_OCTAVE: f64 = 0.75;
/// Largest such number.
const MAX_RUNGS_FOR_BRISTLES: f64 = 3.0;

/// Steps per period and order of a run.
pub type Setting = (u32, Option<u32>);

/// Settings of a method for one problem.
#[derive(Clone, Copy, Debug)]
pub struct Ladder {
    method: Method,
    first_steps: f64,
    order: Option<u32>,
    /// `true` if the order depends on the rung.
    climbs: bool,
    /// `true` if the rungs are orders of the series, all with the same number of steps.
    by_order: bool,
    finest: u32,
    /// Number of rungs by which the shortness of the bristles moves the start up.
    rungs_for_bristles: f64,
}

impl Ladder {
    /// Creates the ladder of a method. A given order applies to all rungs.
    pub fn new(method: Method, problem: &Problem, order: Option<u32>) -> Self {
        let has_order = method.order().is_some() && problem.law != Law::Coulomb;
        let by_order = method == Method::Taylor && order.is_none();
        let climbs = has_order && order.is_none() && method != Method::Taylor;
        let periods = (problem.duration_s * problem.waveform.frequency_hz()).max(1.0);
        let (first_steps, finest) = match method {
            Method::Linexp if problem.law == Law::Coulomb => (16.0, MAX_STEPS_PER_PERIOD),
            Method::Linexp | Method::Frozen => {
                let first = 4.0 * contact_over_fastest(problem).max(1.0);
                let fastest = (problem.motion.fastest_hz() / problem.waveform.frequency_hz()).max(1.0);
                let afforded = MAX_RUN_STEPS_LINEXP / (periods * fastest);
                (first, afforded.min(MAX_STEPS_PER_PERIOD_LINEXP).max(32.0 * first).min(f64::from(MAX_STEPS_PER_PERIOD)) as u32)
            }
            Method::Rk4Events => {
                let stable = stable_steps(problem).max(stribeck_steps(problem));
                (stable.max(24.0), MAX_STEPS_PER_PERIOD.max((16.0 * stable).min(MAX_RUN_STEPS / periods) as u32))
            }
            Method::Midpoint => (stribeck_steps(problem).max(32.0), MAX_STEPS_PER_PERIOD),
            Method::Taylor if by_order => (SERIES_STEPS_PER_PERIOD, MAX_STEPS_PER_PERIOD),
            _ => (f64::from(method.steps(problem.kappa()).unwrap_or(1)), MAX_STEPS_PER_PERIOD),
        };
        let rungs_for_bristles = (RUNGS_PER_OCTAVE * (problem.kappa() / THESIS_KAPPA).log2()).clamp(0.0, MAX_RUNGS_FOR_BRISTLES);
        let order = order.or(method.order()).filter(|_| has_order);
        Ladder { method, first_steps, order, climbs, by_order, finest, rungs_for_bristles }
    }

    /// Returns the lower rungs only: if these do not suffice, a pilot does not pay off.
    pub fn lower(self) -> Self {
        let finest = (128.0 * self.first_steps).min(f64::from(self.finest)) as u32;
        Ladder { finest, ..self }
    }

    /// Returns steps and order of a rung; `None` above the finest.
    pub fn setting(&self, rung: usize) -> Option<Setting> {
        if self.by_order {
            return taylor::ORDERS.get(rung).map(|&order| (self.first_steps as u32, Some(order)));
        }
        let by_half = |first: f64, rung: usize| {
            let doubled = first * f64::from(rung as u32 / 2).exp2();
            (if rung.is_multiple_of(2) { doubled } else { 1.5 * doubled }).ceil()
        };
        let steps = match (self.climbs, rung) {
            _ if self.method == Method::Midpoint => self.first_steps * f64::from(rung as u32).exp2(),
            (true, 0 | 1) => by_half(self.first_steps, rung),
            (true, 2..=4) => by_half(self.first_steps, rung - 1),
            (true, _) => by_half(2.0 * self.first_steps, rung - 5),
            (false, _) => by_half(self.first_steps, rung),
        };
        let order = match (self.climbs, rung) {
            (true, 0 | 1) => Some(4),
            (true, 2..=4) => Some(6),
            (true, _) => Some(10),
            (false, _) => self.order,
        };
        (steps <= f64::from(self.finest)).then_some((steps as u32, order))
    }

    /// Returns the distance in rungs of two runs that are compared.
    pub fn apart(&self) -> usize {
        if self.by_order { 1 } else { 2 }
    }

    /// Returns the smallest ratio of the errors of two successive rungs, from which the number of
    /// rungs to skip follows.
    pub fn stride(&self) -> f64 {
        if self.by_order { BEST_ORDER_CONTRACTION } else { BEST_CONTRACTION }
    }

    /// Returns the rung of a setting.
    pub fn position(&self, setting: Setting) -> usize {
        (0..).map_while(|rung| self.setting(rung)).position(|on| on == setting).unwrap_or(0)
    }

    /// Returns the rung at which the search begins: slightly too coarse for the tolerance in a
    /// contact like the thesis's.
    pub fn start(&self, tolerance: f64) -> usize {
        let decades = -tolerance.log10();
        match self.method {
            Method::Linexp | Method::Frozen if self.climbs => ((decades - 4.7) * 0.8 + self.rungs_for_bristles).max(0.0) as usize,
            Method::Taylor if self.by_order => ((decades - 4.0) * 0.4).clamp(0.0, 3.0) as usize,
            Method::Rk4Events => ((decades - 5.0) * 1.2).max(0.0) as usize,
            Method::Midpoint => ((decades - 4.0) * 1.2).max(0.0) as usize,
            _ => 0,
        }
    }
}

/// Returns the smallest number of steps per period at which classical Runge-Kutta is stable.
///
/// Three rates limit it: slip in bristle lengths, bristle damping on the mass, and mass on contact
/// stiffness. The friction `sigma1 z'` has the slope `sigma1 (1 - s f / g)` in the slip velocity,
/// up to `2 sigma1`.
pub fn stable_steps(problem: &Problem) -> f64 {
    let omega = TAU * problem.waveform.frequency_hz();
    let speed = problem.vibration_m_per_s().min(1e6) + problem.sliding_m_per_s.abs() + problem.start.v_m_per_s.abs();
    let (kt, sigma1, sigma2) = match problem.law {
        Law::Coulomb => return 1.0,
        Law::Dahl { stiffness_n_per_m } => (stiffness_n_per_m, 0.0, 0.0),
        Law::Lugre { stiffness_n_per_m, sigma1, sigma2, .. } => (stiffness_n_per_m, sigma1, sigma2),
    };
    let least_n = problem.load_steps.iter().map(|&(_, force)| force).fold(problem.coulomb_n, f64::min);
    let bristle = kt * speed / least_n;
    let (damping, spring) = match problem.motion {
        Motion::Kinematic => (0.0, 0.0),
        Motion::Sdof { mass_kg, .. } => ((2.0 * sigma1 + sigma2) / mass_kg, (2.0 * kt / mass_kg).sqrt()),
    };
    TAU / omega * bristle.max(damping).max(spring) / STABILITY_LIMIT
}

/// Returns the frequency of the mass on the contact stiffness, over the highest frequency of
/// forcing and oscillator, by which steps are counted. Settings that ignore it may share a common
/// error.
fn contact_over_fastest(problem: &Problem) -> f64 {
    match (problem.law, problem.motion) {
        (Law::Dahl { stiffness_n_per_m }, Motion::Sdof { mass_kg, .. }) => {
            let fastest_hz = problem.motion.fastest_hz().max(problem.waveform.frequency_hz());
            (stiffness_n_per_m / mass_kg).sqrt() / (TAU * fastest_hz)
        }
        _ => 1.0,
    }
}

/// Returns the smallest number of steps per period that does not skip the Stribeck peak: within a
/// step the slip changes by less than six Stribeck velocities. Otherwise two runs may agree because
/// both miss the peak.
fn stribeck_steps(problem: &Problem) -> f64 {
    let Law::Lugre { static_ratio, stribeck_m_per_s, .. } = problem.law else { return 1.0 };
    let vibration = problem.vibration_m_per_s().min(1e6);
    let reverses = problem.sliding_m_per_s.abs() < vibration + 3.0 * stribeck_m_per_s;
    if static_ratio == 1.0 || !reverses {
        1.0
    } else {
        (TAU * vibration / (LARGEST_CHANGE_STRIBECK * stribeck_m_per_s)).min(f64::from(MAX_STEPS_PER_PERIOD) / 8.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table_4_1::standard;

    #[test]
    fn every_rung_costs_more_than_the_one_before() {
        for method in [Method::Linexp, Method::Rk4Events, Method::Midpoint] {
            let ladder = Ladder::new(method, &standard(), None);
            let rungs: Vec<Setting> = (0..).map_while(|rung| ladder.setting(rung)).collect();
            assert!(rungs.len() >= 9 && rungs[rungs.len() - 1].0 > ladder.finest / 2, "{method:?}: {rungs:?}");
            for pair in rungs.windows(2) {
                assert!(pair[0].0 * pair[0].1.unwrap_or(1) < pair[1].0 * pair[1].1.unwrap_or(1), "{method:?}: {pair:?}");
                assert!(pair[1].0 <= 2 * pair[0].0, "{method:?}: {pair:?}");
            }
        }
    }

    #[test]
    fn the_series_climbs_by_order_or_by_steps() {
        let rungs = |order| {
            let ladder = Ladder::new(Method::Taylor, &standard(), order);
            (0..).map_while(|rung| ladder.setting(rung)).collect::<Vec<Setting>>()
        };
        assert_eq!(rungs(None), taylor::ORDERS.map(|order| (4, Some(order))));
        assert_eq!(rungs(Some(20))[..3], [6, 9, 12].map(|steps| (steps, Some(20))));
    }

    #[test]
    fn a_given_order_applies_to_all_rungs() {
        let ladder = Ladder::new(Method::Linexp, &standard(), Some(2));
        assert_eq!((0..3).map(|rung| ladder.setting(rung)).collect::<Option<Vec<_>>>().unwrap(), [4, 6, 8].map(|n| (n, Some(2))));
    }
}
