//! Properties that hold for every velocity ratio and every kappa, tested on random ones.
//!
//! The slack is round-off: the possible difference of two results, each with an error of 1e-15.

use proptest::prelude::*;

use super::super::table_4_1::table_4_1;
use super::super::tally::Ratios;
use super::super::{Law, Motion, Problem, Shape, Sign, Waveform, coulomb, hertz};
use super::*;

const SLACK: f64 = 3e-15;

/// Generates velocity ratios with reversals, some of them close to zero or one.
fn xi() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 0.0..1.0f64,
        1 => (-12.0..0.0f64).prop_map(|e| 10f64.powf(e)),
        1 => (-14.0..0.0f64).prop_map(|e| 1.0 - 10f64.powf(e)),
    ]
    .prop_filter("between zero and one", |xi| *xi > 0.0 && *xi < 1.0)
}

fn kappa() -> impl Strategy<Value = f64> {
    (-12.0..12.0f64).prop_map(|exponent| 10f64.powf(exponent))
}

fn shape() -> impl Strategy<Value = Shape> {
    prop_oneof![Just(Shape::Sine), Just(Shape::Square), Just(Shape::Sawtooth), Just(Shape::Triangle)]
}

fn sign() -> impl Strategy<Value = Sign> {
    prop_oneof![Just(Sign::Passive), Just(Sign::Literal)]
}

/// Returns the thesis's contact with a prescribed vibration, at a kappa.
fn kinematic(shape: Shape, sign: Sign, xi: f64, kappa: f64) -> Problem {
    let mut problem = table_4_1(xi, 4.0);
    let vibration = problem.vibration_m_per_s();
    let stiffness_n_per_m = 0.056e6 * kappa / problem.kappa();
    problem.law = Law::Dahl { stiffness_n_per_m };
    (problem.motion, problem.sign) = (Motion::Kinematic, sign);
    problem.waveform = Waveform::new(shape, vibration, 60e3, problem.duration_s);
    problem
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn friction_falls_with_kappa(xi in xi(), one in kappa(), other in kappa()) {
        let (softer, stiffer) = (one.min(other), one.max(other));
        prop_assert!(friction_ratio(xi, stiffer) <= friction_ratio(xi, softer) + SLACK);
        prop_assert!(power_ratio(xi, stiffer).unwrap() >= power_ratio(xi, softer).unwrap() * (1.0 - SLACK));
    }

    #[test]
    fn friction_rises_with_sliding(kappa in kappa(), one in xi(), other in xi()) {
        let (slower, faster) = (one.min(other), one.max(other));
        prop_assert!(friction_ratio(faster, kappa) >= friction_ratio(slower, kappa) - SLACK);
    }

    #[test]
    fn ratios_lie_between_their_limits(xi in xi(), kappa in kappa()) {
        let (friction, power) = (friction_ratio(xi, kappa), power_ratio(xi, kappa).unwrap());
        prop_assert!(friction <= limit_ratio(xi) + SLACK && friction >= coulomb_friction_ratio(xi) - SLACK);
        prop_assert!(power >= limit_ratio(xi) * (1.0 - SLACK) && power <= coulomb_power_ratio(xi).unwrap() * (1.0 + SLACK));
        // Friction is passive, so the vibration's input is not negative.
        prop_assert!(input_ratio(xi, kappa).unwrap() * xi > -SLACK);
    }

    #[test]
    fn backward_sliding_mirrors_forward_sliding(xi in xi(), kappa in kappa(), phase in -3.0..3.0f64) {
        prop_assert_eq!(friction_ratio(-xi, kappa), -friction_ratio(xi, kappa));
        prop_assert_eq!(power_ratio(-xi, kappa), power_ratio(xi, kappa));
        prop_assert_eq!(Steady::new(-xi, kappa).force(phase), -Steady::new(xi, kappa).force(phase + 0.5));
    }

    #[test]
    fn friction_never_exceeds_coulomb(xi in xi(), kappa in kappa(), phase in -3.0..3.0f64) {
        prop_assert!(Steady::new(xi, kappa).force(phase).abs() <= 1.0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_shape_is_bounded_and_closes(shape in shape(), sign in sign(), xi in 0.01..1.5f64, kappa in kappa()) {
        let problem = kinematic(shape, sign, xi, kappa);
        let mut most = 0.0f64;
        let closed = ClosedForm::new(&problem).unwrap();
        closed.show(&problem, &mut |state| most = most.max(state.force_n.abs()));
        let ratios = closed.ratios();
        prop_assert!(most <= problem.coulomb_n * (1.0 + SLACK), "{}", most);
        prop_assert!((ratios.energy_residual.unwrap() * xi).abs() < SLACK, "{:?}", closed);
        prop_assert!(ratios.friction.abs() <= 1.0 + SLACK && closed.forget_per_period <= 1.0);
        let coulomb = ClosedForm::new(&Problem { law: Law::Coulomb, ..problem }).unwrap();
        prop_assert!(ratios.power.unwrap() <= coulomb.ratios().power.unwrap() * (1.0 + SLACK) + SLACK);
    }

    #[test]
    fn coulomb_friction_only_dissipates(shape in shape(), xi in 0.0..1.5f64, share in 1e-5..0.9f64, damping in 0.0..0.1f64) {
        let mut problem = table_4_1(xi, 6.0);
        problem.law = Law::Coulomb;
        problem.coulomb_n = 384.0 * share;
        problem.window_s.0 = 0.0;
        problem.waveform = Waveform::new(shape, 384.0, 60e3, problem.duration_s);
        if let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = &mut problem.motion {
            *damping_n_s_per_m = 2.0 * damping * (*mass_kg * *stiffness_n_per_m).sqrt();
        }
        let mut passive = true;
        let tally = coulomb::run(&problem, 16, &mut |state| {
            let slip = problem.sliding_m_per_s + state.v_m_per_s;
            passive &= state.force_n * slip >= -1e-12 && state.force_n.abs() <= problem.coulomb_n * (1.0 + 1e-12);
        }).unwrap();
        prop_assert!(passive && tally.totals.friction_work_j >= 0.0);
        if xi > 0.01 {
            let ratios = Ratios::of(&problem, &tally);
            let scale = ratios.power.unwrap().abs() + ratios.input.unwrap().abs() + ratios.stored.unwrap().abs();
            prop_assert!(ratios.energy_residual.unwrap().abs() < 1e-13 * scale.max(1.0), "{:?}", ratios);
        }
    }

    #[test]
    fn vibration_across_lowers_friction(shape in shape(), one in -4.0..4.0f64, more in 0.0..2.0f64) {
        let at = |ratio: f64| {
            let problem = hertz::HertzProblem { normal_n: 1.0, stiffness_n_per_m15: 1.0, amplitude_m: ratio, shape };
            hertz::solve(&problem).unwrap()
        };
        let (weak, strong) = (at(10f64.powf(one)), at(10f64.powf(one + more)));
        prop_assert!(weak.friction_ratio <= 1.0 && strong.friction_ratio <= weak.friction_ratio + 1e-14);
        prop_assert!(strong.friction_ratio > 0.0 && (0.0..=1.0).contains(&strong.contact_share));
    }
}
