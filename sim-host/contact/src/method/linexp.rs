//! The default: exact linear flow of the motion, friction exact in slip, the two coupled at Gauss-Legendre nodes.
//!
//! Friction is a weak perturbation of the motion (5e-5 of the forcing at Table 4.1), and Dahl friction depends on the slip alone:
//! between reversals `f = s + (f0 - s) exp(-(Kt / Fc) s z)`, whatever the motion in time. So a step needs
//!
//! ```text
//! z at the nodes     by the exact flow of the oscillator, less the answers to earlier kicks
//! f at the nodes     by the exponential of z
//! kicks on v         weight times friction at each node: the convolution of friction with the flow, by Gauss-Legendre quadrature
//! ```
//!
//! Nothing in it is limited by the contact's stiffness: |f| <= 1 by construction. A step with a reversal, or one that is stiff, takes
//! the exact step, which ends a part at the reversal; so the order holds: 2 with one node, 4 with two, 6
//! with three. (Structure: Laskar and Robutel 2001, perturbed Hamiltonians; here with a dissipative perturbation.)
//!
//! The flows of whole periods are made once: a step costs a few multiplications and one exponential a node, one more at its end.

mod abreast;
mod decay;
mod energy_sums;
mod exact_step;
mod fast_step;
mod quadrature;
mod simd_nodes;
mod substep;

pub use abreast::{is_for_lanes, run_abreast};
use exact_step::Exact;
use fast_step::{Table, fast_step};
use quadrature::Nodes;
use simd_nodes::Places;

use crate::SolveError;
use crate::problem::{Law, Problem};
use crate::tally::{State, Tally};
use crate::timeline::{Stretch, Timeline};

const METHOD: &str = "linexp";
/// Orders of the method that can be chosen.
pub const ORDERS: [u32; 3] = [2, 4, 6];

/// What a run computes besides the motion and the friction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Options {
    /// Compute motion and friction only.
    #[default]
    Plain,
    /// Add up what forcing and damper do; every step of the window is an exact step.
    EnergySums,
    /// Leave out what friction does to the motion: the frozen two-frequency motion, with friction on top.
    Frozen,
}

/// Runs a problem of Dahl friction; `watch` sees the state after every step.
pub fn run(
    problem: &Problem,
    steps_per_period: u32,
    order: u32,
    options: Options,
    watch: &mut impl FnMut(&State),
) -> Result<Tally, SolveError> {
    let Law::Dahl { stiffness_n_per_m: kt } = problem.law else {
        let method = if options == Options::Frozen { "frozen" } else { METHOD };
        let reason = "it needs friction that is a function of the slip alone, as Dahl's is".into();
        return Err(SolveError::Unsuited { method, reason });
    };
    let n = steps_per_period;
    match (order, options == Options::EnergySums) {
        (2, false) => Run::<1, PLAIN>::new(problem, kt, n, options).all(watch),
        (2, true) => Run::<1, WITH_SUMS>::new(problem, kt, n, options).all(watch),
        (4, false) => Run::<2, PLAIN>::new(problem, kt, n, options).all(watch),
        (4, true) => Run::<2, WITH_SUMS>::new(problem, kt, n, options).all(watch),
        (6, false) => Run::<3, PLAIN>::new(problem, kt, n, options).all(watch),
        (6, true) => Run::<3, WITH_SUMS>::new(problem, kt, n, options).all(watch),
        _ => Err(SolveError::Unsuited { method: METHOD, reason: format!("order {order} is none of {ORDERS:?}") }),
    }
}

/// Coefficients of the motion within a part. In steps of a radian 12 are good to 1e-10 of the amplitude; energies, of which friction's
/// is a small part, need them to round-off.
const PLAIN: usize = 12;
const WITH_SUMS: usize = 20;

struct Run<'a, const K: usize, const N: usize>
where
    Nodes<K>: Places,
{
    problem: &'a Problem,
    exact_step: Exact<K, N>,
    steps_per_period: u32,
    with_sums: bool,
    tables: Vec<Option<Table<K, N>>>,
}

impl<'a, const K: usize, const N: usize> Run<'a, K, N>
where
    Nodes<K>: Places,
{
    fn new(problem: &'a Problem, kt: f64, steps_per_period: u32, options: Options) -> Self {
        let exact_step = Exact::new(problem, kt, steps_per_period, options);
        let with_sums = options == Options::EnergySums;
        Run { problem, exact_step, steps_per_period, with_sums, tables: Vec::new() }
    }

    fn all(mut self, watch: &mut impl FnMut(&State)) -> Result<Tally, SolveError> {
        let mut state = self.problem.start;
        for stretch in Timeline::new(self.problem) {
            let exact_step = &mut self.exact_step;
            if let Some(force) = stretch.load {
                exact_step.set_coulomb_force(force);
            }
            exact_step.face(&stretch.forcing, stretch.length_s);
            exact_step.meter.at(&stretch, &state, exact_step.coulomb_n);
            // The energies are those of the window.
            exact_step.with_sums = self.with_sums && exact_step.meter.is_open();
            let steps = stretch.steps(self.steps_per_period);
            let h = stretch.length_s / f64::from(steps);
            let table = match stretch.template {
                Some(template) if !exact_step.with_sums && !exact_step.is_stiff(h) => {
                    Some(self.table(template, &stretch, steps, h))
                }
                _ => None,
            };
            // Added up stretch by stretch: a million small numbers in one sum leave 1e-10 of it.
            let behind_n_s = std::mem::take(&mut self.exact_step.meter.totals.friction_n_s);
            for step in 0..steps {
                let table = table.and_then(|index| self.tables.get(index)).and_then(Option::as_ref);
                let exact_step = &mut self.exact_step;
                // How much of the step the table can do: all of it, or with one reversal, or nothing.
                let done = match table {
                    Some(table) if fast_step(exact_step, table, step as usize) => 1.0,
                    Some(table) => table.part(exact_step, step as usize).map_or(0.0, |mut part| exact_step.go(&mut part)),
                    None => 0.0,
                };
                if done < 1.0 {
                    exact_step.step(&stretch.forcing, f64::from(step) * h, h, done * h);
                }
                state = exact_step.state(stretch.start_s + f64::from(step + 1) * h);
                exact_step.meter.step(&state, exact_step.f);
                watch(&state);
            }
            self.exact_step.meter.totals.friction_n_s += behind_n_s;
            if !(state.x_m.is_finite() && state.force_n.is_finite()) {
                return Err(SolveError::Diverged { method: METHOD, time_s: state.time_s });
            }
        }
        let exact_step = self.exact_step;
        Ok(exact_step.meter.finish(&state, exact_step.coulomb_n))
    }

    /// The table of a piece, made when it is first met.
    fn table(&mut self, template: usize, stretch: &Stretch, steps: u32, h: f64) -> usize {
        if self.tables.len() <= template {
            self.tables.resize_with(template + 1, || None);
        }
        if self.tables[template].is_none() {
            self.tables[template] = Some(Table::new(&self.exact_step.oscillator, self.problem, stretch, steps, h));
        }
        template
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table_4_1::{DRIVE_HZ, FORCE_N, MASS_KG, table_4_1};
    use crate::tally::Ratios;
    use crate::{Motion, Shape, Sign, Waveform, taylor};

    fn ratios(problem: &Problem, steps: u32, order: u32, options: Options) -> Ratios {
        Ratios::of(problem, &run(problem, steps, order, options, &mut |_| ()).unwrap())
    }

    fn truth(problem: &Problem) -> Ratios {
        Ratios::of(problem, &taylor::run(problem, 24, 28, &mut |_| ()).unwrap())
    }

    /// Errors of the mean at 8, 16 and 32 steps, each at most thrice what was measured; the reference is the Taylor series.
    #[test]
    fn converges_to_the_taylor_series() {
        let problem = table_4_1(0.5, 200.0);
        let truth = truth(&problem);
        for (order, bounds) in [(2, [2e-6, 3e-7, 8e-8]), (4, [6e-7, 1e-8, 2e-10]), (6, [4e-9, 1e-10, 4e-12])] {
            for (steps, bound) in [8, 16, 32].into_iter().zip(bounds) {
                let got = ratios(&problem, steps, order, Options::Plain);
                let (r, phi) = (got.friction - truth.friction, got.power.unwrap() - truth.power.unwrap());
                assert!(r.abs() < bound, "order {order}, {steps} steps: friction ratio off by {r:e}");
                assert!(phi.abs() < 3.0 * bound, "order {order}, {steps} steps: power ratio off by {phi:e}");
            }
        }
    }

    #[test]
    fn every_waveform_agrees_with_the_taylor_series() {
        for shape in [
            Shape::Square,
            Shape::Sawtooth,
            Shape::Triangle,
            Shape::Random { hold_s: 0.1 / 60e3, seed: 7 },
            Shape::Chirp { start_hz: 20e3, stop_hz: 200e3, sweep_s: 0.5e-3 },
        ] {
            for kinematic in [false, true] {
                let mut problem = table_4_1(0.5, 60.0);
                let amplitude = if kinematic { problem.vibration_m_per_s() } else { 384.0 };
                problem.waveform = Waveform::new(shape, amplitude, 60e3, problem.duration_s);
                if kinematic {
                    problem.motion = Motion::Kinematic;
                }
                let (got, truth) = (ratios(&problem, 16, 6, Options::Plain), truth(&problem));
                let error = got.friction - truth.friction;
                assert!(error.abs() < 1e-10, "{shape:?}, kinematic {kinematic}: {error:e}");
            }
        }
    }

    #[test]
    fn the_account_closes_to_round_off_at_any_step() {
        for (sign, damping_n_s_per_m) in [(Sign::Passive, 0.0), (Sign::Literal, 0.0), (Sign::Passive, 40.0)] {
            let mut problem = table_4_1(0.5, 100.0);
            problem.sign = sign;
            problem.motion = Motion::Sdof { mass_kg: 0.02, stiffness_n_per_m: 133e6, damping_n_s_per_m };
            for (steps, order) in [(8, 2), (8, 6), (32, 4)] {
                let residual = ratios(&problem, steps, order, Options::EnergySums).energy_residual.unwrap();
                assert!(residual.abs() < 5e-12, "{sign:?} {damping_n_s_per_m} {steps} {order}: {residual:e}");
            }
        }
    }

    /// Natural over drive frequency, contact spring over `m w^2`, friction over force, velocity ratio.
    fn contact(natural: f64, spring: f64, friction: f64, velocity_ratio: f64, periods: f64) -> Problem {
        let mut problem = table_4_1(0.0, periods);
        let inertia = MASS_KG * (std::f64::consts::TAU * DRIVE_HZ).powi(2);
        problem.motion =
            Motion::Sdof { mass_kg: MASS_KG, stiffness_n_per_m: inertia * natural * natural, damping_n_s_per_m: 0.0 };
        problem.law = Law::Dahl { stiffness_n_per_m: inertia * spring };
        problem.coulomb_n = friction * FORCE_N;
        problem.sliding_m_per_s = velocity_ratio * problem.vibration_m_per_s();
        problem
    }

    /// Rates of friction at its bound are round-off times the stiffness: they count for nothing.
    #[test]
    fn friction_that_has_come_to_its_bound_stays_there() {
        for (natural, spring, friction, velocity_ratio) in [(0.5, 4.3e-3, 2.2e-8, 650.0), (0.03, 8e-3, 2e-10, 640.0)] {
            let mut problem = contact(natural, spring, friction, velocity_ratio, 20.0);
            problem.window_s.0 = 0.0;
            let truth = truth(&problem).friction;
            for steps in [24, 96] {
                let error = ratios(&problem, steps, 6, Options::Plain).friction - truth;
                assert!(error.abs() < 2e-14, "{natural}, {steps} steps: {error:e}");
            }
        }
    }

    /// Two reversals within a coarse step, and bristles that are rigid beside it.
    #[test]
    fn a_dip_within_a_coarse_step_has_its_friction() {
        for (natural, spring, friction, velocity_ratio) in [(2.142, 0.146, 1e-7, 2.47), (4.618, 3.7e-3, 2e-10, 4.7)] {
            let problem = contact(natural, spring, friction, velocity_ratio, 60.0);
            let truth = truth(&problem).friction;
            for (steps, bound) in [(4, 2e-5), (16, 1e-7)] {
                let error = ratios(&problem, steps, 4, Options::Plain).friction - truth;
                assert!(error.abs() < bound, "{natural}, {steps} steps: {error:e}");
            }
        }
    }

    /// A reversal that falls on the end of a step within round-off is found on one side of it or the other, and not on both.
    #[test]
    fn a_reversal_at_a_steps_end_counts_once() {
        let problem = table_4_1(0.0, 30_000.0);
        for (steps, order) in [(4, 4), (4, 6), (12, 2)] {
            let tally = run(&problem, steps, order, Options::Plain, &mut |_| ()).unwrap();
            assert_eq!(tally.reversals, 60_000, "order {order}, {steps} steps");
        }
    }

    /// Short parts take less than round-off from what friction is off its bound: that ends.
    #[test]
    fn short_steps_come_to_an_end() {
        let problem = contact(0.026, 48.0, 1.5e-10, 1.3e-6, 100.0);
        let [coarse, fine] = [84, 1331].map(|steps| ratios(&problem, steps, 6, Options::Plain).friction);
        assert!((coarse - fine).abs() < 5e-11, "{coarse} {fine}");
    }

    #[test]
    fn without_feedback_the_mean_is_off_by_the_coupling() {
        let problem = table_4_1(0.5, 200.0);
        let error = ratios(&problem, 16, 6, Options::Frozen).friction - truth(&problem).friction;
        // Friction over forcing is 5e-5.
        assert!(error.abs() > 1e-6 && error.abs() < 3e-3, "{error:e}");
    }
}
