//! Comparison with exact solutions: Kumar and Hutchings's mean, Coulomb's decay, Den Hartog's
//! forced vibration, and stiff Dahl friction.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::table_4_1::table_4_1;
use crate::tally::Ratios;
use crate::{Shape, Waveform, closed, rk4};

fn coulomb(mut problem: Problem) -> Problem {
    problem.law = Law::Coulomb;
    problem
}

/// Returns an oscillator of 1 N/m and 1 kg under a force at a frequency ratio, without sliding.
fn unit_oscillator(force: f64, frequency_ratio: f64, coulomb_n: f64, periods: f64) -> Problem {
    let hz = frequency_ratio / TAU;
    Problem {
        motion: Motion::Sdof { mass_kg: 1.0, stiffness_n_per_m: 1.0, damping_n_s_per_m: 0.0 },
        law: Law::Coulomb,
        coulomb_n,
        sliding_m_per_s: 0.0,
        sign: Sign::Passive,
        waveform: Waveform::new(Shape::Sine, force, hz, periods / hz),
        start: State::default(),
        load_steps: Vec::new(),
        window_s: (0.0, periods / hz),
        duration_s: periods / hz,
    }
}

fn ratios(problem: &Problem, steps: u32) -> (Ratios, Tally) {
    let tally = run(problem, steps, &mut |_| ()).unwrap();
    (Ratios::of(problem, &tally), tally)
}

/// A given motion is steady at once: compared with the closed form for every shape, from small to
/// large velocity ratios.
#[test]
fn a_given_motion_has_the_closed_form() {
    let mut worst = 0.0f64;
    for shape in [Shape::Sine, Shape::Square, Shape::Sawtooth, Shape::Triangle] {
        for sign in [Sign::Passive, Sign::Literal] {
            for xi in [-0.7, 1e-3, 0.3, 0.999_999, 1.0, 1.2] {
                let mut problem = coulomb(table_4_1(xi, 10.0));
                problem.waveform = Waveform::new(shape, problem.vibration_m_per_s(), 60e3, problem.duration_s);
                (problem.motion, problem.sign) = (Motion::Kinematic, sign);
                let exact = closed::ClosedForm::new(&problem).unwrap().ratios();
                let (got, _) = ratios(&problem, 11);
                // If the slip only touches zero, its round-off of 1e-16 shifts the event by 1e-8 of
                // a period.
                let near = if xi == 1.0 { 1e-8 } else { 1e-12 };
                for (got, exact) in
                    [(Some(got.friction), Some(exact.friction)), (got.power, exact.power), (got.input, exact.input)]
                {
                    let off = (got.unwrap() - exact.unwrap()).abs() * xi.abs().min(1.0);
                    worst = worst.max(off);
                    assert!(off < near, "{shape:?} {sign:?} {xi}: {got:?} {exact:?}");
                }
            }
        }
    }
    println!("worst {worst:e}");
}

/// Without sliding and with a multiple of four steps, every reversal falls on the end of a step.
#[test]
fn reversals_are_counted_once() {
    for steps in [8, 11, 12, 16] {
        let mut problem = coulomb(table_4_1(0.5, 10.0));
        problem.waveform = Waveform::new(Shape::Sine, 0.05, 60e3, problem.duration_s);
        (problem.motion, problem.sliding_m_per_s) = (Motion::Kinematic, 0.0);
        problem.window_s.0 = 0.0;
        let (got, tally) = ratios(&problem, steps);
        assert_eq!(tally.reversals, 20, "{steps}");
        assert!(got.friction.abs() < 1e-10, "{steps}: {got:?}");
    }
}

/// Exact solution: each half swing loses 2 Fc / Ks of amplitude, until the spring force is below
/// Fc.
#[test]
fn free_swings_shrink_by_equal_steps_and_stop() {
    let mut problem = unit_oscillator(0.0, 1.0, 0.1, 10.0);
    problem.start.x_m = 1.05;
    let mut last = State::default();
    let mut turns = Vec::new();
    let (got, tally) = {
        let tally = run(&problem, 64, &mut |state| {
            if state.time_s % PI < 1e-9 || state.time_s % PI > PI - 1e-9 {
                turns.push(state.x_m);
            }
            last = *state;
        });
        let tally = tally.unwrap();
        (Ratios::of(&problem, &tally), tally)
    };
    // 1.05, -0.85, 0.65, -0.45, 0.25, -0.05: there the spring force of 0.05 N is below 0.1 N.
    for (half, x) in turns.iter().take(5).enumerate() {
        let exact = (1.05 - 0.2 * (half + 1) as f64) * if half % 2 == 0 { -1.0 } else { 1.0 };
        assert!((x - exact).abs() < 1e-14, "{half}: {x} {exact}");
    }
    assert!((last.x_m + 0.05).abs() < 1e-14 && last.v_m_per_s == 0.0 && (last.force_n - 0.05).abs() < 1e-14, "{last:?}");
    assert_eq!(tally.reversals, 5);
    // All the energy went into friction: Fc times the path length.
    assert!((tally.totals.friction_work_j - 0.5 * (1.05 * 1.05 - 0.05 * 0.05)).abs() < 1e-14, "{got:?} {tally:?}");
}

/// Den Hartog 1931: amplitude of the steady vibration with Coulomb friction, without stops,
/// `X / (F0 / Ks) = sqrt(V^2 - (Fc / F0)^2 U^2)`, V = 1 / (1 - b^2), U = sin(pi / b) / (b (1 +
/// cos(pi / b))).
#[test]
fn forced_vibration_has_den_hartogs_amplitude() {
    for (b, share) in [(0.7f64, 0.2f64), (1.3, 0.4), (2.2, 0.2)] {
        let mut problem = unit_oscillator(1.0, b, share, 4000.0);
        problem.window_s.0 = 0.99 * problem.duration_s;
        let v = 1.0 / (1.0 - b * b);
        let u = (PI / b).sin() / (b * (1.0 + (PI / b).cos()));
        let exact = (v * v - share * share * u * u).sqrt();
        // Friction dissipates 4 Fc X per period.
        let tally = run(&problem, 16, &mut |_| ()).unwrap();
        let got = tally.totals.friction_work_j / (4.0 * share * tally.time_s * problem.waveform.frequency_hz());
        println!("{b} {share}: {got} {exact} {:e} {}", got / exact - 1.0, tally.reversals);
        assert!((got / exact - 1.0).abs() < 1e-11, "{b} {share}: {got} {exact}");
    }
}

#[test]
fn a_small_force_never_moves_the_block() {
    let problem = unit_oscillator(0.099, 0.37, 0.1, 50.0);
    let tally = run(&problem, 16, &mut |state| {
        assert_eq!((state.x_m, state.v_m_per_s), (0.0, 0.0));
        let needed = problem.waveform.value(state.time_s);
        assert!((state.force_n - needed).abs() < 1e-12);
    });
    assert_eq!(tally.unwrap().reversals, 0);
}

/// The block moves with the belt until the spring pulls with Fc: x = -Vt t to -Fc / Ks; then
/// exactly a cosine about -Fc / Ks.
#[test]
fn the_belt_carries_the_block_until_the_spring_holds_it() {
    let mut problem = unit_oscillator(0.0, 1.0, 0.2, 3.0);
    problem.sliding_m_per_s = 0.05;
    problem.start.v_m_per_s = -0.05;
    let mut worst = 0.0f64;
    let tally = run(&problem, 50, &mut |state| {
        let t = state.time_s;
        let x = if t <= 4.0 { -0.05 * t } else { -0.2 - 0.05 * (t - 4.0).sin() };
        let force = if t <= 4.0 { 0.05 * t } else { 0.2 };
        // One full swing later, at t = 4 + 2 pi, V only touches zero.
        if t < 10.2 {
            worst = worst.max((state.x_m - x).abs()).max((state.force_n - force).abs());
        }
    });
    println!("worst {worst:e}, {tally:?}");
    assert!(worst < 1e-14, "{worst:e}");
}

/// For the Dahl contact of Table 4.1 at high stiffness, r = r_Coulomb + const / Kt. Two
/// stiffnesses, solved by Runge-Kutta, give the limit; the remaining error falls with the root of 1
/// / Kt.
#[test]
fn stiff_dahl_friction_tends_to_coulomb() {
    for xi in [0.2, 0.5] {
        let mut problem = table_4_1(xi, 21.0);
        // The window avoids reversals, because it would cut through their layers of thickness 1 /
        // kappa.
        problem.window_s = (10.25 / 60e3, 20.25 / 60e3);
        let (exact, _) = ratios(&coulomb(problem.clone()), 16);
        let dahl = |factor: f64| {
            let mut problem = problem.clone();
            problem.law = Law::Dahl { stiffness_n_per_m: 0.056e6 * factor };
            let tally = rk4::run(&problem, 8000, &mut |_| ()).unwrap();
            Ratios::of(&problem, &tally)
        };
        let (soft, stiff) = (dahl(1e3), dahl(2e3));
        let limit = 2.0 * stiff.friction - soft.friction;
        println!("{xi}: {} {} limit {limit}, exact {}", soft.friction, stiff.friction, exact.friction);
        assert!((limit - exact.friction).abs() < 3e-5, "{limit} {}", exact.friction);
        assert!((soft.friction - exact.friction).abs() < 1e-3);
    }
}

#[test]
fn energy_closes_and_steps_do_not_matter() {
    let problem = coulomb(table_4_1(0.5, 200.0));
    let (fine, tally) = ratios(&problem, 97);
    let (coarse, _) = ratios(&problem, 8);
    println!("{coarse:?} {} {}", tally.reversals, fine.friction - coarse.friction);
    for got in [fine, coarse] {
        assert!(got.energy_residual.unwrap().abs() < 2e-12, "{got:?}");
    }
    assert!((fine.friction - coarse.friction).abs() < 1e-12 && (fine.power.unwrap() - coarse.power.unwrap()).abs() < 1e-12);
    assert_eq!(tally.reversals, 400);
}

/// At resonance without damping x' grows as F0 t / (2 m).
#[test]
fn resonance_is_not_a_special_case() {
    let mut problem = unit_oscillator(1.0, 1.0, 0.0, 100.0);
    let mut last = State::default();
    run(&problem, 16, &mut |state| last = *state).unwrap();
    let t = last.time_s;
    // x = (t / 2) sin t
    assert!((last.v_m_per_s - 0.5 * (t.sin() + t * t.cos())).abs() < 1e-9 * t, "{last:?}");
    // With Coulomb friction below pi / 4 F0 it still grows, by F0 / 2 - 2 Fc / pi per second.
    problem.coulomb_n = 0.3;
    run(&problem, 16, &mut |state| last = *state).unwrap();
    let slope = last.v_m_per_s / last.time_s;
    assert!((slope - (0.5 - 0.6 / PI)).abs() < 2e-3, "{slope}");
}

#[test]
fn literal_sign_gains_energy_and_refuses_rest() {
    let mut problem = coulomb(table_4_1(0.5, 200.0));
    problem.sign = Sign::Literal;
    let (got, _) = ratios(&problem, 16);
    assert!(got.energy_residual.unwrap().abs() < 1e-10 && got.power.unwrap() > 0.0, "{got:?}");
    let mut rest = unit_oscillator(0.05, 0.4, 0.1, 1.0);
    rest.sign = Sign::Literal;
    assert!(matches!(run(&rest, 16, &mut |_| ()), Err(SolveError::Unsuited { .. })));
    assert!(matches!(run(&table_4_1(0.5, 1.0), 16, &mut |_| ()), Err(SolveError::Unsuited { .. })));
}
