//! Order of convergence of the stepping methods.

use super::*;
use crate::table_4_1::table_4_1;
use crate::tally::Ratios;
use crate::{Shape, Waveform};

/// Entry point of a method.
type Run = fn(&Problem, u32, &mut dyn FnMut(&State)) -> Result<Tally, SolveError>;

const RK4: Run = |problem, n, mut watch| rk4::run(problem, n, &mut watch);
const EVENTS: Run = |problem, n, mut watch| rk4_events::run(problem, n, &mut watch);
const MIDPOINT: Run = |problem, n, mut watch| midpoint::run(problem, n, &mut watch);

/// Returns the states at the quarter periods of a 60 kHz forcing within the window, and the
/// friction ratio.
fn quarters(problem: &Problem, n: u32, run: Run) -> (Vec<State>, f64) {
    let mut seen = Vec::new();
    let tally = run(problem, n, &mut |state| {
        let quarter = state.time_s * 240e3;
        if state.time_s > problem.window_s.0 - 1e-10 && (quarter - quarter.round()).abs() < 1e-7 {
            seen.push(*state);
        }
    })
    .unwrap();
    (seen, Ratios::of(problem, &tally).friction)
}

/// Returns the largest error over the largest value.
fn error(one: &[State], reference: &[State], get: fn(&State) -> f64) -> f64 {
    assert_eq!(one.len(), reference.len());
    let largest = reference.iter().map(|state| get(state).abs()).fold(0.0, f64::max);
    one.iter().zip(reference).map(|(a, b)| (get(a) - get(b)).abs()).fold(0.0, f64::max) / largest
}

/// Returns the slope of the line through the logarithms of errors over steps.
fn order(points: &[(u32, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|&(n, e)| (f64::from(n).ln(), -e.ln())).collect();
    let n = logs.len() as f64;
    let (mx, my) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    logs.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / logs.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

/// Returns the errors of F at the quarter periods, and their order.
fn orders(problem: &Problem, run: Run, steps: &[u32], reference: &[State]) -> (Vec<(u32, f64)>, f64) {
    let errors: Vec<(u32, f64)> =
        steps.iter().map(|&n| (n, error(&quarters(problem, n, run).0, reference, |s| s.force_n))).collect();
    let order = order(&errors);
    println!("{errors:?} order {order:.3}");
    (errors, order)
}

fn lugre(stiffness_n_per_m: f64, sigma1: f64) -> Law {
    Law::Lugre { stiffness_n_per_m, static_ratio: 1.5, stribeck_m_per_s: 0.01, sigma1, sigma2: 0.0 }
}

#[test]
fn order_is_two_without_and_four_with_located_reversals() {
    let problem = Problem { window_s: (0.0, 20.0 / 60e3), ..table_4_1(0.5, 20.0) };
    let (reference, _) = quarters(&problem, 8192, EVENTS);
    let steps = [64, 128, 256, 512, 1024, 2048];
    let (naive, naive_order) = orders(&problem, RK4, &steps, &reference);
    let (located, located_order) = orders(&problem, EVENTS, &steps[..5], &reference);
    assert!((1.8..2.2).contains(&naive_order) && (3.9..4.1).contains(&located_order));
    // Errors over Fc that another program found against a Taylor series of order 28.
    let over_coulomb = reference.iter().map(|state| state.force_n.abs()).fold(0.0, f64::max) / problem.coulomb_n;
    let is = |point: (u32, f64), found: f64| (point.1 * over_coulomb / found - 1.0).abs() < 0.03;
    assert!(is(naive[0], 1.96e-4) && is(naive[1], 4.1e-5) && is(naive[2], 8.2e-6) && is(naive[4], 7.0e-7));
    assert!(is(located[0], 1.6e-7) && is(located[1], 9.8e-9) && is(located[2], 6.2e-10) && is(located[4], 2.4e-12));
}

#[test]
fn midpoint_has_order_four_in_friction_and_two_in_coupling() {
    let weak = Problem { law: lugre(56e3, 0.0), ..table_4_1(0.5, 20.0) };
    let (reference, _) = quarters(&weak, 8192, EVENTS);
    let (errors, found) = orders(&weak, MIDPOINT, &[64, 128, 256], &reference);
    assert!((3.7..4.6).contains(&found) && errors[2].1 < 5e-8);
    let strong = Problem { law: lugre(56e3, 1e5), ..table_4_1(0.5, 20.0) };
    let (reference, _) = quarters(&strong, 16384, EVENTS);
    let (errors, found) = orders(&strong, MIDPOINT, &[128, 256, 512, 1024, 2048], &reference);
    assert!((1.8..2.2).contains(&found) && errors[4].1 < 1.5e-5);
}

#[test]
fn midpoint_solves_a_contact_a_thousand_times_stiffer() {
    let problem = Problem { law: lugre(56e6, 0.0), ..table_4_1(0.5, 20.0) };
    let (_, reference) = quarters(&problem, 40_000, EVENTS);
    for (n, bound) in [(200, 1e-6), (1000, 1e-9), (5000, 1e-11)] {
        assert!(matches!(rk4::run(&problem, n.min(1000), &mut |_| ()), Err(SolveError::Diverged { .. })));
        let (states, ratio) = quarters(&problem, n, MIDPOINT);
        println!("{n}: {:e}", ratio - reference);
        assert!((ratio - reference).abs() < bound);
        assert!(states.iter().all(|state| state.force_n.abs() <= 1.5 * problem.coulomb_n));
    }
}

/// A measured sine approximates the sine: straight lines between 200 samples per period deviate by
/// `(2 pi / 200)^2 / 8`, 1.2e-4, of the amplitude.
#[test]
fn a_measured_sine_gives_the_friction_of_the_sine() {
    let mut problem = Problem { motion: Motion::Kinematic, ..table_4_1(0.5, 40.0) };
    problem.waveform = Waveform::new(Shape::Sine, 2.0 * problem.sliding_m_per_s, 60e3, problem.duration_s);
    let ratio = |problem: &Problem| Ratios::of(problem, &rk4_events::run(problem, 400, &mut |_| ()).unwrap()).friction;
    let truth = ratio(&problem);
    let samples = (0..=8000).map(|n| f64::from(n) / 200.0 / 60e3).map(|time_s| (time_s, problem.waveform.value(time_s)));
    problem.waveform = Waveform::measured(samples.collect::<Vec<_>>(), 60e3);
    assert!((ratio(&problem) / truth - 1.0).abs() < 3e-4, "{} {truth}", ratio(&problem));
}

#[test]
fn located_reversals_keep_order_four_on_every_waveform() {
    let shapes = [
        Shape::Sine,
        Shape::Square,
        Shape::Sawtooth,
        Shape::Triangle,
        Shape::Random { hold_s: 2.3e-6, seed: 5 },
        Shape::Chirp { start_hz: 40e3, stop_hz: 100e3, sweep_s: 120e-6 },
    ];
    for shape in shapes {
        for motion in [Motion::Kinematic, table_4_1(0.5, 1.0).motion] {
            let mut problem = Problem { motion, ..table_4_1(0.5, 10.3) };
            problem.load_steps = vec![(4.7 / 60e3, 0.6 * problem.coulomb_n)];
            let amplitude = if motion == Motion::Kinematic { 2.0 * problem.sliding_m_per_s } else { 384.0 };
            problem.waveform = Waveform::new(shape, amplitude, 60e3, problem.duration_s);
            let end = |n: u32| {
                let mut last = State::default();
                let tally = rk4_events::run(&problem, n, &mut |state| last = *state).unwrap();
                (last.force_n / problem.coulomb_n, Ratios::of(&problem, &tally).friction)
            };
            let (coarse, fine, reference) = (end(48), end(96), end(1536));
            let error = |one: (f64, f64)| (one.0 - reference.0).abs().max((one.1 - reference.1).abs());
            println!("{shape:?} {:?}: {:e} {:e}", motion.natural_hz(), error(coarse), error(fine));
            assert!(error(coarse) < 1.5e-6 && error(coarse) / error(fine) > 11.0);
        }
    }
}
