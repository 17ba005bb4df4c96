//! Passivity of friction: the energy that it takes, stores and returns.
//!
//! With the slip V as input, Dahl's bristles store `F^2 / (2 Kt)` and dissipate: the work of
//! friction is never below the change of the stored energy. The same holds for LuGre's bristles if
//! `sigma2 >= sigma1 (Fs/Fc - 1)` (Barabanov and Ortega 2000; with `|z| <= Fs / Kt` and
//! `G >= Fc / Kt`, `sigma1 z' V + sigma2 V^2 >= (sigma2 - sigma1 (Fs/Fc - 1)) V^2`). Otherwise a
//! bristle bent by slow slip can return more energy than it stores. F V itself may be negative,
//! because bent bristles release energy.

use super::*;
use crate::table_4_1::table_4_1;
use crate::{Shape, Sign, Waveform};

const STIFFNESS: f64 = 56e3;

fn lugre(sigma1: f64, sigma2: f64) -> Law {
    Law::Lugre { stiffness_n_per_m: STIFFNESS, static_ratio: 1.5, stribeck_m_per_s: 0.01, sigma1, sigma2 }
}

/// Returns the force in the bristles in a state, N.
fn bristles_n(problem: &Problem, state: &State) -> f64 {
    let Law::Lugre { sigma1, sigma2, static_ratio, stribeck_m_per_s, .. } = problem.law else { return state.force_n };
    let slip = problem.sliding_m_per_s + problem.sign.factor() * state.v_m_per_s;
    let level = rates::level(static_ratio, stribeck_m_per_s, slip) * problem.coulomb_n;
    // F = Kt z + sigma1 (V - |V| Kt z / level) + sigma2 V
    (state.force_n - (sigma1 + sigma2) * slip) / (1.0 - sigma1 * slip.abs() / level)
}

/// Returns the minimum over the run of the energy that friction has taken from oscillator and belt,
/// minus the increase of the energy stored in its bristles, J. The second value is the largest
/// energy taken, J, for comparison.
///
/// The oscillator moves against the belt with `Vt + x'`, independent of the slip in the equations.
fn taken(problem: &Problem, steps: u32) -> (f64, f64) {
    let stored = |state: &State| bristles_n(problem, state).powi(2) / (2.0 * STIFFNESS);
    let power = |state: &State| state.force_n * (problem.sliding_m_per_s + state.v_m_per_s);
    let mut last = State { ..problem.start };
    let (mut sum, mut first, mut least, mut most) = (0.0, None, f64::INFINITY, 0.0f64);
    rk4_events::run(problem, steps, &mut |state| {
        // The corners of F lie at the reversals, which are reported, so the trapezoidal rule is of
        // second order.
        if let Some(first) = first {
            sum += 0.5 * (state.time_s - last.time_s) * (power(state) + power(&last));
            least = least.min(sum - (stored(state) - first));
            most = most.max(sum.abs());
        } else {
            first = Some(stored(state));
        }
        last = *state;
    })
    .unwrap();
    (least, most)
}

/// Returns `true` if friction took energy and returned none, within the error of the sum.
fn takes_energy(problem: &Problem) -> bool {
    let (least, most) = taken(problem, 500);
    println!("{:?}: least {least:e} of {most:e} J", problem.sign);
    least >= -2e-4 * most
}

/// Returns an oscillator released on a belt at rest.
fn let_go(law: Law, sign: Sign) -> Problem {
    let mut problem = Problem { law, sign, sliding_m_per_s: 0.0, ..table_4_1(0.5, 40.0) };
    problem.waveform = Waveform::new(Shape::Still, 384.0, 60e3, problem.duration_s);
    problem.start.v_m_per_s = 0.05;
    problem
}

#[test]
fn friction_is_passive_except_with_the_literal_sign() {
    for law in [Law::Dahl { stiffness_n_per_m: STIFFNESS }, lugre(0.0, 0.0), lugre(0.05, 0.025)] {
        assert!(takes_energy(&let_go(law, Sign::Passive)), "{law:?}");
        assert!(!takes_energy(&let_go(law, Sign::Literal)), "{law:?}");
        // Driven, on a slow belt.
        assert!(takes_energy(&Problem { law, ..table_4_1(0.1, 40.0) }), "{law:?}");
        assert!(!takes_energy(&Problem { law, sign: Sign::Literal, ..table_4_1(0.1, 40.0) }), "{law:?}");
    }
}

/// Entry point of a method with a fixed number of steps.
type Run = fn(&Problem, &mut dyn FnMut(&State)) -> Result<Tally, SolveError>;

#[test]
fn a_free_oscillator_decays_or_grows_with_the_literal_sign() {
    let grown = |run: Run, sign: Sign| {
        let problem = let_go(lugre(0.0, 0.0), sign);
        let Motion::Sdof { mass_kg: m, stiffness_n_per_m: k, .. } = problem.motion else { panic!() };
        let energy = |s: &State| 0.5 * (m * s.v_m_per_s.powi(2) + k * s.x_m.powi(2) + s.force_n.powi(2) / STIFFNESS);
        let mut last = problem.start;
        run(&problem, &mut |state| {
            assert!(sign == Sign::Literal || energy(state) <= energy(&last) * (1.0 + 1e-8), "{state:?}");
            last = *state;
        })
        .unwrap();
        energy(&last) / energy(&problem.start) - 1.0
    };
    let runs: [Run; 2] = [
        |problem, mut watch| rk4_events::run(problem, 400, &mut watch),
        |problem, mut watch| midpoint::run(problem, 400, &mut watch),
    ];
    for run in runs {
        let (passive, literal) = (grown(run, Sign::Passive), grown(run, Sign::Literal));
        println!("{passive:e} {literal:e}");
        assert!(passive < -1e-4 && literal > 1e-4);
    }
}

#[test]
fn large_sigma1_returns_more_energy_than_is_stored() {
    // Bristles bent to Fs, then a constant fast slip V. With u = Kt V t / Fc, f = 1 + e^-u / 2, the
    // work is (Fc^2 / Kt) (u + (1 - e^-u) / 2) + (Fc / Kt) V (sigma2 u - sigma1 (1 - e^-u) / 2),
    // here with sigma1 V = 20 Fc, up to u = 1.
    let (coulomb, slip) = (0.01962, 1.0);
    let sigma1 = 20.0 * coulomb / slip;
    let fallen = 1.0 - (-1.0f64).exp();
    for (sigma2, passive) in [(0.0, false), (0.5 * sigma1, true)] {
        let mut problem = Problem { motion: Motion::Kinematic, law: lugre(sigma1, sigma2), ..table_4_1(0.5, 1.0) };
        problem.sliding_m_per_s = slip;
        problem.start.force_n = 1.5 * coulomb;
        problem.duration_s = coulomb / (STIFFNESS * slip);
        problem.window_s = (0.0, problem.duration_s);
        problem.waveform = Waveform::new(Shape::Still, 0.0, 60e3, problem.duration_s);
        let unit = coulomb * coulomb / STIFFNESS;
        let expected = unit * (1.0 + 0.5 * fallen + slip / coulomb * (sigma2 - 0.5 * sigma1 * fallen));
        let held = 0.5 * 1.5 * 1.5 * unit;
        for (tally, tolerance) in [
            (rk4_events::run(&problem, 4_000, &mut |_| ()).unwrap(), 5e-10),
            (midpoint::run(&problem, 4_000, &mut |_| ()).unwrap(), 5e-10),
        ] {
            let work = tally.totals.friction_work_j;
            println!("{} steps: work {work:e} J, off by {:e}, held {held:e} J", tally.steps, work / expected - 1.0);
            assert!((work / expected - 1.0).abs() < tolerance);
            assert_eq!(work >= -held, passive);
        }
    }
}

#[test]
fn bent_bristles_release_energy() {
    let mut least = 0.0f64;
    let problem = Problem { law: lugre(0.0, 0.0), ..table_4_1(0.5, 20.0) };
    rk4_events::run(&problem, 200, &mut |state| {
        least = least.min(state.force_n * (problem.sliding_m_per_s + state.v_m_per_s));
    })
    .unwrap();
    println!("{least:e} W");
    // A large part of Fc Vv. The released power can exceed Fc Vv only by the factor Fs / Fc.
    let most = problem.coulomb_n * problem.vibration_m_per_s();
    assert!(least < -0.3 * most && least > -1.5 * most);
}
