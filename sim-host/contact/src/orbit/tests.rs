//! The steady state equals the end of long runs and the closed form; where there is none, the
//! reason is named.

use super::*;
use crate::table_4_1::table_4_1;
use crate::{Shape, Sign, Waveform, closed::ClosedForm, solve_unwatched};

/// Returns Table 4.1 with a damping ratio of the oscillator.
fn damped(ratio: f64) -> Problem {
    let mut problem = table_4_1(0.5, 200.0);
    if let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = &mut problem.motion {
        *damping_n_s_per_m = 2.0 * ratio * (*mass_kg * *stiffness_n_per_m).sqrt();
    }
    problem
}

fn lugre() -> Law {
    Law::Lugre { stiffness_n_per_m: 0.056e6, static_ratio: 1.4, stribeck_m_per_s: 0.02, sigma1: 0.02, sigma2: 0.05 }
}

fn orbit(problem: &Problem) -> Result<Orbit, Unsteady> {
    let pause: &dyn Fn() = &|| ();
    Orbit::new(problem, &pause)
}

/// Returns the mean over a hundred periods after others.
fn after(problem: &Problem, periods: f64) -> f64 {
    let hz = problem.waveform.frequency_hz();
    let long =
        Problem { window_s: (periods / hz, (periods + 100.0) / hz), duration_s: (periods + 100.0) / hz, ..problem.clone() };
    let numerics = Numerics { tolerance: 1e-9, energies: false, ..Numerics::default() };
    solve_unwatched(&long, &numerics, &|| ()).unwrap().ratios.friction
}

#[test]
fn means_are_those_of_long_runs() {
    let steady = Numerics { steady: true, tolerance: 1e-9, ..Numerics::default() };
    for law in [Law::Dahl { stiffness_n_per_m: 0.056e6 }, Law::Dahl { stiffness_n_per_m: 2e6 }, Law::Coulomb, lugre()] {
        for shape in [Shape::Sine, Shape::Square, Shape::Triangle] {
            let mut problem = Problem { law, ..damped(1e-2) };
            problem.waveform =
                Waveform::new(shape, problem.waveform.amplitude(), problem.waveform.frequency_hz(), problem.duration_s);
            let solution = solve_unwatched(&problem, &steady, &|| ()).unwrap();
            let orbit = solution.orbit.unwrap_or_else(|| panic!("{law:?} {shape:?}: {:?}", solution.warnings));
            // Four times a thousandth: the transient from rest is below the bound.
            let expected = after(&problem, (4.0 * orbit.settling_periods()).ceil());
            let error = (solution.ratios.friction - expected).abs();
            assert!(error <= 2e-9 + solution.error_estimate.unwrap(), "{law:?} {shape:?}: {error:e} {solution:?}");
            assert!(orbit.residual < 1e-9 && (0.5..1.0).contains(&orbit.multiplier), "{orbit:?}");
        }
    }
}

#[test]
fn the_multiplier_is_the_decay_of_a_transient() {
    let problem = damped(1e-3);
    let orbit = orbit(&problem).unwrap();
    let mean = solve_unwatched(&orbit.period(&problem), &Numerics::default(), &|| ()).unwrap().ratios.friction;
    let settling = orbit.settling_periods();
    let [early, late] = [0.5, 1.5].map(|part| (after(&problem, (part * settling).round()) - mean).abs());
    // The means scatter, because a hundred periods are not a whole number of beats.
    assert!((1e-4..1e-2).contains(&(late / early)), "{early:e} {late:e} {settling}");
}

#[test]
fn a_given_vibration_has_the_closed_form() {
    for (xi, shape) in [(0.3, Shape::Sine), (0.7, Shape::Triangle), (-0.4, Shape::Sawtooth)] {
        let mut problem = Problem { motion: Motion::Kinematic, ..table_4_1(0.5, 10.0) };
        problem.waveform = Waveform::new(shape, 0.05, 60e3, problem.duration_s);
        problem.sliding_m_per_s = 0.05 * xi;
        let orbit = orbit(&problem).unwrap();
        let found =
            solve_unwatched(&orbit.period(&problem), &Numerics { tolerance: 1e-11, ..Numerics::default() }, &|| ()).unwrap();
        let expected = ClosedForm::new(&problem).unwrap().ratios().friction;
        assert!((found.ratios.friction - expected).abs() < 1e-10, "{xi} {shape:?}: {} {expected}", found.ratios.friction);
    }
}

#[test]
fn problems_without_a_steady_state_are_named() {
    let base = damped(0.0);
    let chirp = Shape::Chirp { start_hz: 50e3, stop_hz: 70e3, sweep_s: 1e-3 };
    let aperiodic = Problem { waveform: Waveform::new(chirp, 384.0, 60e3, base.duration_s), ..base.clone() };
    assert_eq!(orbit(&aperiodic), Err(Unsteady::Aperiodic));
    assert_eq!(orbit(&Problem { load_steps: vec![(1e-3, 0.5)], ..base.clone() }), Err(Unsteady::Aperiodic));
    // Without a reversal friction is constant, and nothing damps the oscillator.
    let fast = Problem { sliding_m_per_s: 2.0 * base.vibration_m_per_s(), ..base.clone() };
    assert_eq!(orbit(&fast), Err(Unsteady::NotUnique));
    let stiff = Law::Lugre { stiffness_n_per_m: 1e12, static_ratio: 1.4, stribeck_m_per_s: 0.02, sigma1: 0.0, sigma2: 0.0 };
    assert_eq!(orbit(&Problem { law: stiff, ..base.clone() }), Err(Unsteady::TooStiff));
    let fed = Problem { sign: Sign::Literal, ..base };
    assert!(matches!(orbit(&fed), Err(Unsteady::Unstable(growth)) if growth > 1.0), "{:?}", orbit(&fed));
    let numerics = Numerics { steady: true, ..Numerics::default() };
    let solution = solve_unwatched(&fed, &numerics, &|| ()).unwrap();
    assert!(solution.orbit.is_none() && solution.warnings[0].contains("unstable"), "{:?}", solution.warnings);
}
