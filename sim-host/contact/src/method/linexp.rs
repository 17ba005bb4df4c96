//! The default method. The linear motion is solved exactly over a step, the friction law exactly as
//! a function of slip; they are coupled at Gauss-Legendre nodes.
//!
//! Friction is a weak perturbation of the motion (5e-5 of the forcing in Table 4.1), and Dahl
//! friction depends on the slip alone. Between reversals `f = s + (f0 - s) exp(-(Kt / Fc) s z)`,
//! independent of the motion in time. So a step needs
//!
//! ```text
//! z at the nodes     from the exact flow of the oscillator, minus its response to friction
//! f at the nodes     by the exponential of z
//! response           at the nodes: of the polynomial through f at all nodes; at the end of the step: of kicks on v, weight times f
//! ```
//!
//! z and f at the nodes are computed from each other twice (collocation, as in a Gauss-Legendre
//! Runge-Kutta method). The effect of friction on its own slip within a step is so small that this
//! suffices; where it is not, the exact step computes it four times. Kicks at the nodes of the
//! quadrature give its effect at the end of the step to the order of the quadrature.
//!
//! The method is not limited by the stiffness of the contact: |f| <= 1 by construction. A step that
//! contains a reversal, or that is stiff, is an exact step, which is split at the reversal. So the
//! order is preserved: 2 with one node, 4 with two, 6 with three, 10 with five. (Structure: Laskar
//! and Robutel 2001, perturbed Hamiltonians; here with a dissipative perturbation.)
//!
//! The flows of whole periods are computed once. A step then costs a few multiplications and one
//! exponential per node, and one more at its end.

mod batched;
mod decay;
mod energy_sums;
mod exact_step;
mod fast_step;
mod feedback;
mod quadrature;
mod simd_nodes;
mod substep;

pub use batched::{can_be_batched, run_batched};
use exact_step::Exact;
use fast_step::{Table, fast_step};
use quadrature::Nodes;
use simd_nodes::Places;

use crate::SolveError;
use crate::problem::{Law, Problem};
use crate::tally::{State, Tally};
use crate::timeline::{Stretch, Timeline};

const METHOD: &str = "linexp";
/// Available orders of the method.
pub const ORDERS: [u32; 4] = [2, 4, 6, 10];

/// Extent of a run in addition to motion and friction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Options {
    /// Compute motion and friction only.
    #[default]
    Plain,
    /// Add up the energies of forcing and damper; every step in the window is then an exact step.
    EnergySums,
    /// Neglect the effect of friction on the motion: the frozen two-frequency motion, with friction
    /// on top.
    Frozen,
}

/// Runs a problem of Dahl friction; `watch` receives the state after every step.
pub fn run(
    problem: &Problem,
    steps_per_period: u32,
    order: u32,
    options: Options,
    watch: &mut dyn FnMut(&State),
) -> Result<Tally, SolveError> {
    let Law::Dahl { stiffness_n_per_m: kt } = problem.law else {
        let method = if options == Options::Frozen { "frozen" } else { METHOD };
        let reason = "it requires friction that depends on the slip alone, as Dahl's law does".into();
        return Err(SolveError::Unsuited { method, reason });
    };
    let n = steps_per_period;
    match (order, options == Options::EnergySums) {
        (2, false) => Run::<1, PLAIN_TERMS>::new(problem, kt, n, options).all(watch),
        (2, true) => Run::<1, ENERGY_TERMS>::new(problem, kt, n, options).all(watch),
        (4, false) => Run::<2, PLAIN_TERMS>::new(problem, kt, n, options).all(watch),
        (4, true) => Run::<2, ENERGY_TERMS>::new(problem, kt, n, options).all(watch),
        (6, false) => Run::<3, PLAIN_TERMS>::new(problem, kt, n, options).all(watch),
        (6, true) => Run::<3, ENERGY_TERMS>::new(problem, kt, n, options).all(watch),
        (10, false) => Run::<5, LONG_TERMS>::new(problem, kt, n, options).all(watch),
        (10, true) => Run::<5, ENERGY_TERMS>::new(problem, kt, n, options).all(watch),
        _ => Err(SolveError::Unsuited { method: METHOD, reason: format!("order {order} is not one of {ORDERS:?}") }),
    }
}

/// Number of coefficients of the motion within a part. In steps of one radian, 12 are accurate to
/// 1e-10 of the amplitude.
const PLAIN_TERMS: usize = 12;
/// The same number for order 10.
const LONG_TERMS: usize = 16;
/// The same number for energies, which need the motion to round-off because the energy of friction
/// is a small part of them.
const ENERGY_TERMS: usize = 20;

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

    fn all(mut self, watch: &mut dyn FnMut(&State)) -> Result<Tally, SolveError> {
        let mut state = self.problem.start;
        for stretch in Timeline::new(self.problem) {
            let exact_step = &mut self.exact_step;
            if let Some(force) = stretch.load {
                exact_step.set_coulomb_force(force);
            }
            exact_step.face(&stretch.forcing, stretch.length_s);
            exact_step.meter.at(&stretch, &state, exact_step.coulomb_n);
            // The energies cover only the window.
            exact_step.with_sums = self.with_sums && exact_step.meter.is_open();
            let steps = stretch.steps(self.steps_per_period);
            let h = stretch.length_s / f64::from(steps);
            let table = match stretch.template {
                Some(template) if !exact_step.with_sums && !exact_step.is_stiff(h) => {
                    Some(self.table(template, &stretch, steps, h))
                }
                _ => None,
            };
            // Summed per stretch: a single sum of a million small numbers loses 1e-10 of its value.
            let behind_n_s = std::mem::take(&mut self.exact_step.meter.totals.friction_n_s);
            for step in 0..steps {
                let table = table.and_then(|index| self.tables.get(index)).and_then(Option::as_ref);
                let exact_step = &mut self.exact_step;
                // Fraction of the step that the table covers: all of it, the part up to a reversal,
                // or nothing.
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

    /// Returns the index of the table of a piece, which is computed at its first use.
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

    /// Errors of the mean at 8, 16 and 32 steps against the Taylor series; the bounds are at most
    /// three times the measured errors.
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
    fn energy_account_closes_at_any_step() {
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

    /// Returns a contact by natural over drive frequency, contact stiffness over `m w^2`, friction
    /// over force, and velocity ratio.
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

    /// At the bound, the rate of friction is round-off times the stiffness and must be ignored.
    #[test]
    fn friction_stays_at_its_bound() {
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

    /// Two reversals within a coarse step, with bristles that are rigid compared with it.
    #[test]
    fn a_dip_within_a_coarse_step_is_resolved() {
        for (natural, spring, friction, velocity_ratio) in [(2.142, 0.146, 1e-7, 2.47), (4.618, 3.7e-3, 2e-10, 4.7)] {
            let problem = contact(natural, spring, friction, velocity_ratio, 60.0);
            let truth = truth(&problem).friction;
            for (steps, bound) in [(4, 2e-5), (16, 1e-7)] {
                let error = ratios(&problem, steps, 4, Options::Plain).friction - truth;
                assert!(error.abs() < bound, "{natural}, {steps} steps: {error:e}");
            }
        }
    }

    /// A reversal that falls on the end of a step within round-off is found on one side of it, not
    /// on both.
    #[test]
    fn a_reversal_at_a_steps_end_counts_once() {
        let problem = table_4_1(0.0, 30_000.0);
        for (steps, order) in [(4, 4), (4, 6), (12, 2)] {
            let tally = run(&problem, steps, order, Options::Plain, &mut |_| ()).unwrap();
            assert_eq!(tally.reversals, 60_000, "order {order}, {steps} steps");
        }
    }

    /// Short parts remove less than round-off from the distance of friction to its bound; the run
    /// must still end.
    #[test]
    fn runs_with_short_parts_end() {
        let problem = contact(0.026, 48.0, 1.5e-10, 1.3e-6, 100.0);
        let [coarse, fine] = [84, 1331].map(|steps| ratios(&problem, steps, 6, Options::Plain).friction);
        assert!((coarse - fine).abs() < 5e-11, "{coarse} {fine}");
    }

    #[test]
    fn frozen_error_is_the_coupling() {
        let problem = table_4_1(0.5, 200.0);
        let error = ratios(&problem, 16, 6, Options::Frozen).friction - truth(&problem).friction;
        // Friction over forcing is 5e-5.
        assert!(error.abs() > 1e-6 && error.abs() < 3e-3, "{error:e}");
    }
}
