//! Problems solved together have the same solutions as alone.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use super::*;
use crate::table_4_1::table_4_1;
use crate::{Law, Motion, Shape, Waveform, solve_unwatched};

/// Map over the stiffness, with pilots, with two runs of the record, and with the Taylor series as
/// the last resort.
#[test]
fn a_map_equals_its_single_solutions() {
    for (tolerance, periods, energies, count) in [(1e-6, 200.0, false, 100), (1e-11, 40.0, false, 10), (1e-7, 50.0, true, 10)] {
        let numerics = Numerics { tolerance, energies, whole_run: false, ..Numerics::default() };
        let problems: Vec<Problem> = (0..count)
            .map(|i| {
                let stiffness_n_per_m = 1e4 * 1e3f64.powf(f64::from(i % 10) / 9.0);
                let velocity_ratio = 0.05 + 1.2 * f64::from(i) / f64::from(count);
                Problem { law: Law::Dahl { stiffness_n_per_m }, ..table_4_1(velocity_ratio, periods) }
            })
            .collect();
        for (problem, many) in problems.iter().zip(solve_many(&problems, &numerics, &|| ())) {
            assert_eq!(many, solve_unwatched(problem, &numerics, &|| ()), "{problem:?}");
        }
    }
}

/// Problems of every kind together, returned in the given order.
#[test]
fn mixed_problems_equal_single_solutions() {
    let mut problems = vec![table_4_1(0.5, 60.0); 8];
    problems[1].law = Law::Coulomb;
    problems[2].law =
        Law::Lugre { stiffness_n_per_m: 56e3, static_ratio: 1.5, stribeck_m_per_s: 0.01, sigma1: 0.05, sigma2: 0.0 };
    problems[3].motion = Motion::Kinematic;
    problems[3].waveform = Waveform::new(Shape::Sine, problems[0].vibration_m_per_s(), 60e3, problems[0].duration_s);
    problems[4].load_steps = vec![(5e-4, 0.03)];
    problems[5].waveform = Waveform::new(Shape::Random { hold_s: 2e-5, seed: 5 }, 384.0, 60e3, problems[0].duration_s);
    problems[6].coulomb_n *= 1e-18;
    for method in [Method::Auto, Method::Linexp, Method::Frozen, Method::Taylor, Method::Closed] {
        let numerics = Numerics { tolerance: 1e-5, energies: false, method, ..Numerics::default() };
        let many = solve_many(&problems, &numerics, &|| ());
        assert_eq!(many.len(), problems.len());
        for (number, (problem, many)) in problems.iter().zip(many).enumerate() {
            assert_eq!(many, solve_unwatched(problem, &numerics, &|| ()), "{number}, {method:?}");
        }
    }
}

/// The caller can cancel by unwinding from `pause`.
#[test]
fn solving_can_be_cancelled() {
    let numerics = Numerics { energies: false, ..Numerics::default() };
    let problems = vec![table_4_1(0.5, 20_000.0); 16];
    let left = catch_unwind(AssertUnwindSafe(|| solve_many(&problems, &numerics, &|| resume_unwind(Box::new("left")))));
    assert!(left.is_err_and(|cause| cause.is::<&str>()));
}
