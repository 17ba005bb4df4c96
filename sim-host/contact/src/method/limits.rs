//! Agreement of the stepping methods: equivalent laws, symmetry, and limiting cases.

use super::*;
use crate::table_4_1::table_4_1;
use crate::tally::Ratios;
use crate::{Shape, Waveform};

/// Entry point of a method.
type Run = fn(&Problem, u32, &mut dyn FnMut(&State)) -> Result<Tally, SolveError>;

const RUNS: [(&str, Run); 3] = [
    ("rk4", |problem, n, mut watch| rk4::run(problem, n, &mut watch)),
    ("rk4-events", |problem, n, mut watch| rk4_events::run(problem, n, &mut watch)),
    ("midpoint", |problem, n, mut watch| midpoint::run(problem, n, &mut watch)),
];

fn lugre(static_ratio: f64, sigma1: f64, sigma2: f64) -> Law {
    Law::Lugre { stiffness_n_per_m: 56e3, static_ratio, stribeck_m_per_s: 0.01, sigma1, sigma2 }
}

fn states(problem: &Problem, n: u32, run: Run) -> (Vec<State>, Tally) {
    let mut seen = Vec::new();
    let tally = run(problem, n, &mut |state| seen.push(*state)).unwrap();
    (seen, tally)
}

/// Returns a kinematic contact in its steady state, over whole periods.
fn steady(law: Law) -> Problem {
    Problem { motion: Motion::Kinematic, law, ..kinematic(0.5, 60.0) }
}

fn kinematic(velocity_ratio: f64, periods: f64) -> Problem {
    let problem = table_4_1(velocity_ratio, periods);
    let waveform = Waveform::new(Shape::Sine, problem.vibration_m_per_s(), 60e3, problem.duration_s);
    Problem { motion: Motion::Kinematic, waveform, ..problem }
}

#[test]
fn steady_dahl_is_the_closed_form() {
    // Friction and power ratio computed in 40 digits by another program, at kappa = 0.404521.
    let references = [(0.1, 0.148749778, 0.471150), (0.5, 0.674948667, 0.721106), (0.9, 0.975847159, 0.979423)];
    for (velocity_ratio, friction, power) in references {
        for (name, run) in &RUNS[1..] {
            let problem = kinematic(velocity_ratio, 60.0);
            let ratios = Ratios::of(&problem, &states(&problem, 256, *run).1);
            println!("{name} {velocity_ratio}: {:.9} {:.6}", ratios.friction, ratios.power.unwrap());
            assert!((ratios.friction - friction).abs() < 1e-9 && (ratios.power.unwrap() - power).abs() < 6e-7);
        }
    }
}

#[test]
fn lugre_without_stribeck_and_damping_is_dahl() {
    for (name, run) in RUNS {
        let dahl = table_4_1(0.5, 20.0);
        let lugre = Problem { law: lugre(1.0, 0.0, 0.0), ..dahl.clone() };
        let ((one, tally), (other, other_tally)) = (states(&dahl, 100, run), states(&lugre, 100, run));
        assert_eq!((tally.steps, tally.reversals), (other_tally.steps, other_tally.reversals));
        for (a, b) in one.iter().zip(&other) {
            assert!((a.force_n - b.force_n).abs() < 1e-14 * dahl.coulomb_n && a.x_m == b.x_m, "{name} {a:?} {b:?}");
        }
    }
}

#[test]
fn viscous_friction_adds_the_mean_slip() {
    for (name, run) in RUNS {
        let mean = |sigma2: f64| {
            let problem = steady(lugre(1.5, 0.0, sigma2));
            Ratios::of(&problem, &states(&problem, 100, run).1).friction
        };
        let problem = steady(lugre(1.5, 0.0, 0.0));
        let added = mean(0.3) - mean(0.0) - 0.3 * problem.sliding_m_per_s / problem.coulomb_n;
        println!("{name} {added:e}");
        // rk4-events integrates the slip itself in uneven steps.
        assert!(added.abs() < if name == "rk4-events" { 2e-10 } else { 1e-13 });
    }
}

#[test]
fn bristle_damping_adds_the_change_of_deflection() {
    let sigma1 = 10.0;
    for (name, run, tolerance) in [(RUNS[0].0, RUNS[0].1, 1e-3), (RUNS[1].0, RUNS[1].1, 1e-6), (RUNS[2].0, RUNS[2].1, 1e-14)] {
        // From rest and over a fraction of a period.
        let problem = |sigma1: f64| Problem { window_s: (0.0, 2.3 / 60e3), ..steady(lugre(1.5, sigma1, 0.0)) };
        let (without, with) = (problem(0.0), problem(sigma1));
        let (plain, damped) = (states(&without, 200, run).1, states(&with, 200, run).1);
        let bent_m = (plain.last.force_n - plain.first.force_n) / 56e3;
        let expected = sigma1 * bent_m / (plain.time_s * without.coulomb_n);
        let added = Ratios::of(&with, &damped).friction - Ratios::of(&without, &plain).friction;
        println!("{name} {expected} {:e}", added - expected);
        assert!(expected.abs() > 1.0 && (added - expected).abs() < tolerance * expected.abs());
    }
}

#[test]
fn the_mirrored_problem_has_the_mirrored_friction() {
    for shape in [Shape::Sine, Shape::Sawtooth, Shape::Random { hold_s: 2.3e-6, seed: 5 }] {
        for (name, run) in RUNS {
            let mut problem = Problem { law: lugre(1.5, 0.05, 0.05), ..table_4_1(0.5, 10.0) };
            (problem.start.v_m_per_s, problem.start.force_n) = (0.01, 0.004);
            let mirrored = |factor: f64| {
                let mut problem = Problem { sliding_m_per_s: factor * problem.sliding_m_per_s, ..problem.clone() };
                problem.waveform = Waveform::new(shape, factor * 384.0, 60e3, problem.duration_s);
                problem.start.v_m_per_s *= factor;
                problem.start.force_n *= factor;
                states(&problem, 64, run)
            };
            let ((one, tally), (other, other_tally)) = (mirrored(1.0), mirrored(-1.0));
            for (a, b) in one.iter().zip(&other) {
                assert_eq!((a.x_m, a.v_m_per_s, a.force_n), (-b.x_m, -b.v_m_per_s, -b.force_n), "{name}");
            }
            let (a, b) = (tally.totals, other_tally.totals);
            assert_eq!((a.friction_n_s, a.friction_work_j, a.input_j), (-b.friction_n_s, b.friction_work_j, b.input_j), "{name}");
            assert_eq!(tally.reversals, other_tally.reversals);
        }
    }
}

#[test]
fn a_lighter_load_lets_friction_decay_to_its_bound() {
    for (name, run) in RUNS {
        let mut problem = table_4_1(0.5, 200.0);
        let coulomb_n = 0.2 * problem.coulomb_n;
        problem.load_steps = vec![(100.0 / 60e3, coulomb_n)];
        problem.window_s.0 = 150.0 / 60e3;
        let (seen, tally) = states(&problem, 200, run);
        let after: Vec<f64> = seen.iter().filter(|s| s.time_s > 100.0 / 60e3).map(|s| s.force_n.abs() / coulomb_n).collect();
        println!("{name}: {} -> {}", after[0], after[after.len() - 1]);
        assert!(after[0] > 2.0);
        assert!(after.windows(2).all(|pair| pair[1] <= pair[0] || pair[1] <= 1.0), "{name}");
        assert!(after[after.len() / 2..].iter().all(|ratio| *ratio <= 1.0), "{name}");
        // Mean from a Taylor series in another program.
        let friction = Ratios::of(&problem, &tally).friction;
        println!("{name}: {friction:.9}");
        assert!((friction - 0.500253255).abs() < if name == "rk4" { 2e-6 } else { 5e-9 });
    }
}

#[test]
fn without_sliding_exactly_two_reversals_per_period() {
    // Kinematic: exact for odd and even numbers of steps, so that reversals fall on steps and
    // between them.
    for n in [15, 16, 64, 101] {
        for (name, run) in &RUNS[1..] {
            let problem = Problem { sliding_m_per_s: 0.0, ..kinematic(0.5, 100.0) };
            let (_, tally) = states(&problem, n, *run);
            assert_eq!(tally.reversals, 200, "{name} {n}");
        }
    }
    // From rest, with the oscillator: the same number for every step size, and the friction of a
    // fine one.
    let problem = Problem { sliding_m_per_s: 0.0, ..table_4_1(0.5, 200.0) };
    let (_, fine) = states(&problem, 2048, RUNS[1].1);
    for (name, run) in &RUNS[1..] {
        let (_, tally) = states(&problem, 64, *run);
        let (a, b) = (Ratios::of(&problem, &tally).friction, Ratios::of(&problem, &fine).friction);
        println!("{name}: {} {} {a:e} {:e}", tally.reversals, fine.reversals, a - b);
        assert!(tally.reversals == fine.reversals && (a - b).abs() < 3e-7);
    }
}

#[test]
fn a_slip_that_only_just_reverses_is_not_missed() {
    for velocity_ratio in [0.9, 1.0, 1.1, 1.2] {
        let problem = table_4_1(velocity_ratio, 200.0);
        let (_, fine) = states(&problem, 4096, RUNS[1].1);
        let (_, thesis) = states(&problem, 4096, RUNS[0].1);
        let reference = Ratios::of(&problem, &fine).friction;
        assert!((Ratios::of(&problem, &thesis).friction - reference).abs() < 1e-8);
        for n in [40, 64, 100, 333] {
            let (_, tally) = states(&problem, n, RUNS[1].1);
            let error = Ratios::of(&problem, &tally).friction - reference;
            println!("{velocity_ratio} {n}: {} of {}, {error:e}", tally.reversals, fine.reversals);
            assert_eq!(tally.reversals, fine.reversals);
            assert!(error.abs() < 1e-6 * (40.0 / f64::from(n)).powi(4) + 1e-12);
        }
    }
}

#[test]
fn midpoint_is_bounded_at_any_stiffness_and_damping() {
    for stiffness_n_per_m in [56e6, 56e9, 56e12, 56e15] {
        for n in [16, 100, 1000] {
            let law = Law::Lugre { stiffness_n_per_m, static_ratio: 1.5, stribeck_m_per_s: 0.01, sigma1: 0.0, sigma2: 0.0 };
            let problem = Problem { law, ..table_4_1(0.5, 20.0) };
            let tally = midpoint::run(&problem, n, &mut |_| ()).unwrap();
            assert!(tally.peak_force_ratio <= 1.5 && tally.peak_velocity_m_per_s < 0.07, "{tally:?}");
        }
    }
    // sigma1 h / m from 3 to 3e6: the classical method diverges; here the bristles hold the mass.
    for sigma1 in [1e7, 1e10, 1e13] {
        let problem = Problem { law: lugre(1.5, sigma1, 0.0), ..table_4_1(0.5, 20.0) };
        assert!(matches!(rk4_events::run(&problem, 100, &mut |_| ()), Err(SolveError::Diverged { .. })));
        let tally = midpoint::run(&problem, 100, &mut |_| ()).unwrap();
        println!("{sigma1:e}: {:e} {:e}", tally.peak_velocity_m_per_s, tally.peak_displacement_m);
        assert!(tally.peak_velocity_m_per_s <= 1.01 * problem.sliding_m_per_s, "{tally:?}");
    }
}

#[test]
fn a_dahl_contact_near_coulomb_friction() {
    // Ten thousand times the stiffness of Table 4.1; the classical method needs 20000 steps to
    // remain stable.
    let problem = Problem { law: Law::Dahl { stiffness_n_per_m: 560e6 }, ..table_4_1(0.5, 20.0) };
    let friction = |tally: Tally| Ratios::of(&problem, &tally).friction;
    let reference = friction(states(&problem, 20_000, RUNS[1].1).1);
    for (n, bound) in [(200, 2e-4), (1000, 5e-8), (5000, 1e-9)] {
        let tally = states(&problem, n, RUNS[2].1).1;
        println!("{n}: {:e}, peak {}", friction(tally) - reference, tally.peak_force_ratio);
        assert!((friction(tally) - reference).abs() < bound && tally.peak_force_ratio <= 1.0);
    }
}
