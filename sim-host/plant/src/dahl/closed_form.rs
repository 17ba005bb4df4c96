//! Stepped contact against the closed forms of the crate `contact`, an independent implementation.

use contact::closed::ClosedForm;
use contact::table_4_1::table_4_1;
use contact::tally::Ratios;
use contact::{Law, Motion, Problem, Shape, Sign, Waveform};

use super::Dahl;

/// Returns the thesis's contact with the vibration given.
fn kinematic(shape: Shape, xi: f64, periods: f64) -> Problem {
    let mut problem = table_4_1(xi, periods);
    let vibration = problem.vibration_m_per_s();
    problem.motion = Motion::Kinematic;
    problem.waveform = Waveform::new(shape, vibration, 60e3, problem.duration_s);
    problem
}

const SHAPES: [Shape; 4] = [Shape::Sine, Shape::Square, Shape::Sawtooth, Shape::Triangle];

/// Steps this contact exactly in slip, with 1000 steps a piece over 20 periods. Returns the ratios
/// of the last period.
fn stepped(problem: &Problem) -> [f64; 3] {
    let Law::Dahl { stiffness_n_per_m } = problem.law else { return [f64::NAN; 3] };
    let mut contact = Dahl::new(stiffness_n_per_m, problem.coulomb_n);
    let (mut friction, mut moving, mut time) = (0.0, 0.0, 0.0);
    let pieces = if matches!(problem.waveform.shape(), Shape::Sine | Shape::Sawtooth) { 1 } else { 2 };
    for index in 0..20 * pieces {
        let piece = problem.waveform.piece(index);
        let step = piece.length_s / 1000.0;
        for n in 0..1000 {
            let vibration = |part: f64| piece.forcing.value((f64::from(n) + part) * step);
            let [x0, xm, x1] = [0.0, 0.5, 1.0].map(vibration);
            let [v0, vm, v1] = [x0, xm, x1].map(|x| problem.sliding_m_per_s + problem.sign.factor() * x);
            // Simpson's rule, exact for a line.
            let mean = contact.slip(v0, v1, step / 6.0 * (v0 + 4.0 * vm + v1), step);
            if index >= 19 * pieces {
                (friction, time) = (friction + mean * step, time + step);
                moving += mean * xm * step;
            }
        }
    }
    let (friction, input) =
        (friction / (problem.coulomb_n * time), moving / (problem.coulomb_n * problem.sliding_m_per_s * time));
    [friction, friction + problem.sign.factor() * input, input]
}

#[test]
fn stepping_agrees() {
    let mut worst = 0.0f64;
    for shape in SHAPES {
        for sign in [Sign::Passive, Sign::Literal] {
            for xi in [-0.4, 0.05, 0.5, 0.9, 1.0, 1.3] {
                let mut problem = kinematic(shape, xi, 20.0);
                problem.sign = sign;
                let Ratios { friction, power, input, energy_residual, .. } = ClosedForm::new(&problem).unwrap().ratios();
                for (got, expected) in stepped(&problem).into_iter().zip([Some(friction), power, input]) {
                    let off = (got - expected.unwrap()).abs() * xi.abs().min(1.0);
                    worst = worst.max(off);
                    assert!(off < 2e-7, "{shape:?} {sign:?} {xi}: {got} {expected:?}");
                }
                assert!((energy_residual.unwrap() * xi).abs() < 2e-15, "{shape:?} {sign:?} {xi}: {energy_residual:?}");
            }
        }
    }
    println!("worst {worst:e}");
}
