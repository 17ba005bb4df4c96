//! Taylor series of high order with located reversals: the reference solution in this repository,
//! and the method for tight tolerances.
//!
//! Between reversals of the slip velocity the problem is analytic, so each coefficient of its
//! `series` follows from the preceding ones (Barrio 2005; Jorba and Zou 2005). For Dahl friction:
//!
//! ```text
//! x' = v,   m v' = u(t) - c v - Ks x - Fc f,   f' = (Kt / Fc) (V - s V f),   V = Vt + sign v,   s = sgn V
//! ```
//!
//! A reversal is the first root of the polynomial V. There the sign changes, V is exactly zero, and
//! a new series begins. All integrals are those of the polynomials.

mod series;

use self::series::{Begin, Series};
use super::polynomial::{first_reversal, integral, product, value};
use crate::SolveError;
use crate::forcing::Forcing;
use crate::problem::{Law, Motion, Problem};
use crate::tally::{Meter, State, Tally};
use crate::timeline::{Stretch, Timeline};

const METHOD: &str = "taylor";

/// Available orders of the series.
pub const ORDERS: [u32; 7] = [8, 12, 16, 20, 24, 28, 32];
/// Largest number of series per step, on average over a stretch.
const MAX_PARTS_PER_STEP: u64 = 5_000;
/// Time difference below which two moments count as the same, as a fraction of a step.
const SAME_MOMENT_STEPS: f64 = 1e-13;
/// Number of time units that are tried, each shorter than the one before, until all coefficients
/// are finite.
const MAX_UNITS: usize = 8;
/// Ratio of two successive time units.
const UNIT_RATIO: f64 = 1e-3;
/// Square root of the accuracy to which a reversal is located, as a fraction of a step.
const LOCATION_TOLERANCE: f64 = 1e-8;
/// Distance of friction from its bound, over Fc, below which it is set to the bound. Otherwise it
/// would stay close to it in short steps; at the bound itself the series ends after the first term.
const SATURATION_DISTANCE: f64 = 1e-15;
/// The same distance as a fraction of the accuracy of the series; the larger one applies.
const SATURATION_ERROR_FRACTION: f64 = 0.1;

/// Runs a problem of Dahl or LuGre friction; `watch` receives the state after every step.
pub fn run(problem: &Problem, steps_per_period: u32, order: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
    of_order(problem, (steps_per_period, order), true, watch)
}

/// Runs a problem without the energies of forcing, damper, mass and spring, which saves up to three
/// products of series per part.
pub fn run_plain(
    problem: &Problem,
    steps_per_period: u32,
    order: u32,
    watch: &mut dyn FnMut(&State),
) -> Result<Tally, SolveError> {
    of_order(problem, (steps_per_period, order), false, watch)
}

fn of_order(
    problem: &Problem,
    (steps, order): (u32, u32),
    accounted: bool,
    watch: &mut dyn FnMut(&State),
) -> Result<Tally, SolveError> {
    match order {
        8 => Run::<9>::new(problem, accounted)?.all(steps, watch),
        12 => Run::<13>::new(problem, accounted)?.all(steps, watch),
        16 => Run::<17>::new(problem, accounted)?.all(steps, watch),
        20 => Run::<21>::new(problem, accounted)?.all(steps, watch),
        24 => Run::<25>::new(problem, accounted)?.all(steps, watch),
        28 => Run::<29>::new(problem, accounted)?.all(steps, watch),
        32 => Run::<33>::new(problem, accounted)?.all(steps, watch),
        _ => Err(SolveError::Unsuited { method: METHOD, reason: format!("order {order} is not one of {ORDERS:?}") }),
    }
}

struct Run<'a, const N: usize> {
    problem: &'a Problem,
    coulomb_n: f64,
    /// Displacement, m.
    x: f64,
    /// Velocity, m/s.
    v: f64,
    /// Force in the bristles over Fc.
    bristle: f64,
    /// Friction over Fc.
    f: f64,
    /// `true` if friction is the force in the bristles alone.
    of_bristles: bool,
    /// Sign of the slip velocity.
    sense: f64,
    meter: Meter,
}

impl<'a, const N: usize> Run<'a, N> {
    fn new(problem: &'a Problem, accounted: bool) -> Result<Self, SolveError> {
        if problem.law == Law::Coulomb {
            let reason = "it only integrates friction with bristles; use linexp for Coulomb friction".into();
            return Err(SolveError::Unsuited { method: METHOD, reason });
        }
        let State { x_m, v_m_per_s, force_n, .. } = problem.start;
        let coulomb_n = problem.coulomb_n;
        let meter = Meter::new(accounted);
        let bristle = force_n / coulomb_n;
        let of_bristles = matches!(problem.law, Law::Dahl { .. });
        Ok(Run { problem, coulomb_n, x: x_m, v: v_m_per_s, bristle, f: bristle, of_bristles, sense: 0.0, meter })
    }

    fn all(mut self, steps_per_period: u32, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
        let mut state = self.state(0.0);
        let mut series = Series::new();
        for stretch in Timeline::new(self.problem) {
            if let Some(force) = stretch.load {
                self.bristle *= self.coulomb_n / force;
                self.f *= self.coulomb_n / force;
                self.coulomb_n = force;
            }
            self.face(&mut series, &stretch.forcing, stretch.length_s);
            self.meter.at(&stretch, &state, self.coulomb_n);
            state = self.go(&mut series, &stretch, stretch.steps(steps_per_period), watch)?;
        }
        Ok(self.meter.finish(&state, self.coulomb_n))
    }

    fn state(&self, time_s: f64) -> State {
        State { time_s, x_m: self.x, v_m_per_s: self.v, force_n: self.coulomb_n * self.f }
    }

    /// Integrates a stretch by series that are at most one step long. A series that begins at a
    /// reversal may continue past the end of its step; the state at that end is then evaluated from
    /// it.
    fn go(
        &mut self,
        series: &mut Series<N>,
        stretch: &Stretch,
        steps: u32,
        watch: &mut dyn FnMut(&State),
    ) -> Result<State, SolveError> {
        let h = stretch.length_s / f64::from(steps);
        let same_s = SAME_MOMENT_STEPS * h;
        let end_s = |step: u32| if step == steps { stretch.length_s } else { f64::from(step) * h };
        let saturated = SATURATION_DISTANCE.max(SATURATION_ERROR_FRACTION * Series::<N>::largest_last_term());
        let coulomb_n = self.coulomb_n;
        let mut seen = |meter: &mut Meter, state: &State| {
            meter.step(state, state.force_n / coulomb_n);
            watch(state);
        };
        let (mut at_s, mut step, mut flips, mut parts) = (0.0, 1, 0, 0u64);
        let mut state = self.state(stretch.start_s);
        while step <= steps {
            if self.of_bristles && (self.bristle - self.sense).abs() <= saturated {
                self.bristle = self.sense;
            }
            let left_s = stretch.length_s - at_s;
            let unit_s = if left_s > h + same_s { h } else { left_s };
            self.expand(series, &stretch.forcing, at_s, unit_s);
            series.shorten(&self.problem.law);
            parts += 1;
            if parts > MAX_PARTS_PER_STEP * u64::from(steps) {
                let reason = "the contact is too stiff: the series would need thousands of parts per step; use linexp".into();
                return Err(SolveError::Unsuited { method: METHOD, reason });
            }
            let mut reversal = first_reversal(&series.slip, self.sense, LOCATION_TOLERANCE);
            flips = if reversal == Some(0.0) { flips + 1 } else { 0 };
            if flips > 1 {
                // A velocity that only touches zero has a sign, but does not reverse.
                let sense = value(&series.slip, 0.5).signum();
                (self.sense, reversal) = (sense, None);
                self.expand(series, &stretch.forcing, at_s, unit_s);
                series.shorten(&self.problem.law);
            }
            let begin_s = at_s;
            let whole = reversal.is_none() && series.unit_s == unit_s;
            at_s = if whole && unit_s == left_s { stretch.length_s } else { at_s + reversal.unwrap_or(1.0) * series.unit_s };
            while step <= steps && end_s(step) < at_s - same_s {
                state = self.inside(series, (end_s(step) - begin_s) / series.unit_s, stretch.start_s + end_s(step));
                seen(&mut self.meter, &state);
                step += 1;
            }
            self.advance(series, reversal.unwrap_or(1.0));
            if reversal.is_some() {
                self.sense = -self.sense;
                self.meter.tally.reversals += 1;
                if self.problem.motion != Motion::Kinematic {
                    self.v = -self.problem.sign.factor() * self.problem.sliding_m_per_s;
                }
            }
            if step <= steps && end_s(step) <= at_s + same_s {
                state = self.state(stretch.start_s + end_s(step));
                if !(self.x.is_finite() && self.v.is_finite() && self.f.is_finite()) {
                    return Err(SolveError::Diverged { method: METHOD, time_s: state.time_s });
                }
                seen(&mut self.meter, &state);
                step += 1;
            }
        }
        Ok(state)
    }

    /// Finds the sign of the slip when it does not follow from the preceding motion: at the start,
    /// and if a given velocity jumps.
    fn face(&mut self, series: &mut Series<N>, forcing: &Forcing, length_s: f64) {
        let kinematic = self.problem.motion == Motion::Kinematic;
        if self.sense != 0.0 && !kinematic {
            return;
        }
        self.expand(series, forcing, 0.0, 1e-3 * length_s);
        // A slip that is zero to round-off takes the sign of its first non-zero derivative.
        let size = self.problem.sliding_m_per_s.abs() + series.v.iter().map(|c| c.abs()).fold(0.0, f64::max);
        let first = series.slip.iter().find(|c| c.abs() > 1e-12 * size);
        self.sense = first.map_or(1.0, |c| c.signum());
    }

    /// Computes the series from the present state, in units of `unit_s` seconds or shorter.
    fn expand(&self, series: &mut Series<N>, forcing: &Forcing, at_s: f64, unit_s: f64) {
        let begin = Begin { x: self.x, v: self.v, bristle: self.bristle, sense: self.sense, coulomb_n: self.coulomb_n };
        let units = std::iter::successors(Some(unit_s), |unit_s| Some(unit_s * UNIT_RATIO)).take(MAX_UNITS);
        for unit_s in units {
            series.expand(self.problem, &begin, forcing.taylor_in(at_s, unit_s), unit_s);
            if series.is_finite() {
                return;
            }
        }
    }

    /// Returns the state at the fraction `s` of the series' step.
    fn inside(&self, series: &Series<N>, s: f64, time_s: f64) -> State {
        let f = value(series.friction(&self.problem.law), s);
        let (x_m, v_m_per_s) = (value(&series.x, s), value(&series.v, s));
        State { time_s, x_m, v_m_per_s, force_n: self.coulomb_n * f }
    }

    /// Advances to the fraction `s` of the series' step.
    fn advance(&mut self, series: &Series<N>, s: f64) {
        let (x, v, bristle) = (value(&series.x, s), value(&series.v, s), value(&series.bristle, s));
        // Only the window counts.
        if self.meter.is_open() {
            let h = series.unit_s;
            let totals = &mut self.meter.totals;
            totals.friction_n_s += h * self.coulomb_n * integral(series.friction(&self.problem.law), s);
            totals.friction_work_j += match self.problem.law {
                // Dahl's law `f' = (Kt / Fc) (V - s f V)` gives the integral of `f V` from the slip
                // and the change of f, without quadrature.
                Law::Dahl { stiffness_n_per_m } => {
                    let slip_m = h * s * self.problem.sliding_m_per_s + self.problem.sign.factor() * (x - self.x);
                    let stretched_m = (bristle - self.bristle) * self.coulomb_n / stiffness_n_per_m;
                    self.coulomb_n * self.sense * (slip_m - stretched_m)
                }
                _ => h * self.coulomb_n * integral(&product(&series.slip, &series.f), s),
            };
            (totals.felt_n_s, totals.felt_work_j) = (totals.friction_n_s, totals.friction_work_j);
            if self.meter.tally.accounted {
                self.add_energies(series, s);
            }
        }
        (self.x, self.v, self.bristle) = (x, v, bristle);
        self.f = if self.of_bristles { bristle } else { value(&series.f, s) };
    }

    /// Adds the energies of forcing and damper up to the fraction `s`, and those of mass and
    /// spring.
    fn add_energies(&mut self, series: &Series<N>, s: f64) {
        let h = series.unit_s;
        let totals = &mut self.meter.totals;
        match self.problem.motion {
            Motion::Kinematic => {
                totals.input_j += h * self.coulomb_n * integral(&product(series.friction(&self.problem.law), &series.v), s);
            }
            Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } => {
                totals.input_j += h * integral(&product(&series.u, &series.v), s);
                let squares = integral(&product(&series.v, &series.v), s);
                totals.damping_j += h * damping_n_s_per_m * squares;
                totals.kinetic_j_s += 0.5 * mass_kg * h * squares;
                totals.potential_j_s += 0.5 * stiffness_n_per_m * h * integral(&product(&series.x, &series.x), s);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table_4_1::table_4_1;
    use crate::tally::Ratios;
    use crate::{Shape, Waveform, rk4, rk4_events};

    fn ratios(problem: &Problem, steps: u32, order: u32) -> (Ratios, Tally) {
        let tally = run(problem, steps, order, &mut |_| ()).unwrap();
        (Ratios::of(problem, &tally), tally)
    }

    #[test]
    fn table_4_1_to_round_off() {
        let problem = table_4_1(0.5, 200.0);
        let ((coarse, tally), (fine, _)) = (ratios(&problem, 16, 20), ratios(&problem, 24, 32));
        assert!((coarse.friction - fine.friction).abs() < 1e-13 && (coarse.power.unwrap() - fine.power.unwrap()).abs() < 1e-12);
        assert!(fine.energy_residual.unwrap().abs() < 1e-12, "{fine:?}");
        assert_eq!(tally.reversals, 400);
        // The thesis's own solver with its own step, which has an error of 3e-8 here.
        let thesis = Ratios::of(&problem, &rk4::run(&problem, 1000, &mut |_| ()).unwrap());
        assert!((thesis.friction - fine.friction).abs() < 1e-7);
    }

    #[test]
    fn a_plain_run_is_the_same_motion_without_energies() {
        let mut lugre = table_4_1(0.5, 40.0);
        lugre.law =
            Law::Lugre { stiffness_n_per_m: 0.056e6, static_ratio: 1.6, stribeck_m_per_s: 1e-2, sigma1: 1.0, sigma2: 1e-3 };
        for problem in [table_4_1(0.5, 40.0), lugre] {
            let whole = run(&problem, 12, 16, &mut |_| ()).unwrap();
            let plain = run_plain(&problem, 12, 16, &mut |_| ()).unwrap();
            assert!(whole.accounted && !plain.accounted);
            assert_eq!((plain.last, plain.reversals, plain.steps), (whole.last, whole.reversals, whole.steps));
            let [whole, plain] = [whole, plain].map(|tally| Ratios::of(&problem, &tally));
            assert_eq!(plain, Ratios { friction: whole.friction, power: whole.power, ..Ratios::default() });
            assert!(whole.power.is_some() && whole.input.is_some());
        }
    }

    #[test]
    fn errors_have_the_stated_order() {
        let problem = table_4_1(0.5, 40.0);
        let forces = |steps: u32, order| {
            let mut forces = Vec::new();
            let quarter = |state: &State| (4.0 * 60e3 * state.time_s - (4.0 * 60e3 * state.time_s).round()).abs() < 1e-6;
            run(&problem, steps, order, &mut |state| forces.extend(quarter(state).then_some(state.force_n / problem.coulomb_n)))
                .unwrap();
            forces
        };
        let exact = forces(64, 32);
        for (order, coarse, fine) in [(8, 24, 48), (12, 16, 24)] {
            let error = |steps: u32| forces(steps, order).iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let observed = (error(coarse) / error(fine)).log2() / (f64::from(fine) / f64::from(coarse)).log2();
            assert!((observed - f64::from(order)).abs() < 1.5, "order {order}: {observed}");
        }
    }

    /// LuGre friction compared with Runge-Kutta with located reversals, which shares only the
    /// equations with the series.
    #[test]
    fn lugre_friction_agrees_with_runge_kutta() {
        for (stribeck, sigma1, sigma2) in [(1e-2, 0.0, 0.0), (1e-2, 3.0, 1e-3), (1e-3, 0.5, 0.0), (0.1, 0.0, 1e-2)] {
            for kinematic in [false, true] {
                let mut problem = table_4_1(0.5, 20.0);
                problem.law =
                    Law::Lugre { stiffness_n_per_m: 0.056e6, static_ratio: 1.6, stribeck_m_per_s: stribeck, sigma1, sigma2 };
                if kinematic {
                    problem.waveform = Waveform::new(Shape::Sine, problem.vibration_m_per_s(), 60e3, problem.duration_s);
                    problem.motion = Motion::Kinematic;
                }
                let [coarse, fine] = [(16, 24), (24, 32)].map(|(steps, order)| ratios(&problem, steps, order));
                let other = Ratios::of(&problem, &rk4_events::run(&problem, 8000, &mut |_| ()).unwrap());
                let off = [coarse.0.friction, other.friction].map(|friction| (friction - fine.0.friction).abs());
                assert!(off[0] < 5e-13 && off[1] < 1e-12, "{stribeck} {sigma1} {sigma2}, kinematic {kinematic}: {off:?}");
                assert!(fine.0.energy_residual.unwrap().abs() < 1e-11, "{fine:?}");
            }
        }
    }

    #[test]
    fn no_sliding_has_exactly_two_reversals_per_period() {
        let problem = table_4_1(0.0, 400.0);
        let (ratios, tally) = ratios(&problem, 16, 16);
        assert_eq!(tally.reversals, 800);
        assert!(ratios.friction.abs() < 1e-2 && ratios.power.is_none());
    }

    #[test]
    fn grazing_misses_no_reversal() {
        for velocity_ratio in [0.9, 1.0, 1.05] {
            let problem = table_4_1(velocity_ratio, 130.0);
            let counts = [8, 16, 64].map(|steps| ratios(&problem, steps, 20).1.reversals);
            assert!(counts.iter().all(|count| *count == counts[0]), "{velocity_ratio}: {counts:?}");
        }
    }

    #[test]
    fn a_given_velocity_may_touch_zero() {
        for off in [-1e-6, -1e-15, 0.0, 1e-15, 1e-6] {
            let mut problem = table_4_1(1.0, 60.0);
            let vibration = problem.vibration_m_per_s();
            problem.sliding_m_per_s = vibration * (1.0 + off);
            problem.motion = Motion::Kinematic;
            problem.waveform = Waveform::new(Shape::Sine, vibration, 60e3, problem.duration_s);
            let friction = ratios(&problem, 32, 24).0.friction;
            assert!((friction - 1.0).abs() < 1e-6, "{off:e}: {friction}");
        }
    }

    #[test]
    fn jumps_of_the_forcing_lie_between_steps() {
        let mut problem = table_4_1(0.5, 40.0);
        problem.waveform = Waveform::new(Shape::Square, 384.0, 60e3, problem.duration_s);
        let [coarse, fine] = [(12, 16), (32, 28)].map(|(steps, order)| ratios(&problem, steps, order).0);
        assert!((coarse.friction - fine.friction).abs() < 1e-11, "{coarse:?} {fine:?}");
        assert!(fine.energy_residual.unwrap().abs() < 1e-11);
    }
}
