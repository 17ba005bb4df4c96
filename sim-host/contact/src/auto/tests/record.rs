//! A tolerance of the whole record: met at every reported moment, or reported as not met.

use super::*;
use crate::Record;

fn of_record(tolerance: f64) -> Numerics {
    Numerics { tolerance, tolerance_of: ToleranceOf::Record, energies: false, ..Numerics::default() }
}

/// Returns the solution, and the distance of its record from a high-order series at the same
/// moments.
fn shown(problem: &Problem, numerics: &Numerics) -> (Solution, f64) {
    let mut record = Record::default();
    let solution = solve(problem, numerics, &mut |state| record.add(state)).unwrap();
    let mut truth = Record::default();
    let steps = solution.steps_per_period.unwrap();
    if problem.law == Law::Coulomb {
        crate::coulomb::run(problem, 4 * steps, &mut |state| truth.add(state)).unwrap();
    } else {
        taylor::run_plain(problem, steps, 32, &mut |state| truth.add(state)).unwrap();
    }
    let off = record.distance(&truth, problem);
    (solution, off)
}

/// Returns Table 4.1, bristles that ring, and LuGre bristles with a peak and with damping.
fn contacts() -> [Problem; 4] {
    let lugre = |sigma1| Law::Lugre { stiffness_n_per_m: 56e3, static_ratio: 1.5, stribeck_m_per_s: 0.01, sigma1, sigma2: 0.0 };
    let rings = table_4_1(0.5, 60.0);
    [
        table_4_1(0.5, 200.0),
        Problem { law: Law::Dahl { stiffness_n_per_m: 5e8 }, coulomb_n: 1e3 * rings.coulomb_n, ..rings.clone() },
        Problem { law: lugre(0.0), ..rings.clone() },
        Problem { law: lugre(1.0), ..rings },
    ]
}

#[test]
fn every_moment_is_within_the_tolerance() {
    for problem in contacts() {
        for tolerance in [1e-3, 1e-5, 1e-7, 1e-9] {
            let (solution, off) = shown(&problem, &of_record(tolerance));
            let estimate = solution.record_error_estimate.unwrap();
            assert!(solution.tolerance_met && off <= estimate && estimate <= tolerance, "{off:e}, {solution:?}");
            // An error within the tolerance at every moment is also within it on average.
            assert!(solution.error_estimate.unwrap() <= estimate, "{solution:?}");
        }
    }
}

/// The error of the mean is a fifth of that of the record, so a coarser run meets its tolerance.
#[test]
fn an_accurate_mean_may_have_a_poor_record() {
    let problem = table_4_1(0.5, 200.0);
    let of_mean = Numerics { tolerance: 1e-4, energies: false, ..Numerics::default() };
    let (solution, off) = shown(&problem, &of_mean);
    assert!(solution.tolerance_met && solution.record_error_estimate.is_none(), "{solution:?}");
    let truth = Ratios::of(&problem, &taylor::run(&problem, 24, 28, &mut |_| ()).unwrap()).friction;
    assert!(off > 5.0 * (solution.ratios.friction - truth).abs(), "{off:e}, {solution:?}");
    let of_record = solve_unwatched(&problem, &of_record(1e-5), &|| ()).unwrap();
    assert!(of_record.tolerance_met && of_record.ratios.friction != solution.ratios.friction, "{of_record:?}");
}

/// With energies, beyond the window, and with given steps: the estimate applies to the reported
/// record, or to a coarser one.
#[test]
fn the_estimate_covers_the_reported_record() {
    let short = table_4_1(0.5, 60.0);
    let long = Problem { window_s: (0.0, 0.1 * short.duration_s), ..short.clone() };
    let energies = Numerics { energies: true, ..of_record(1e-6) };
    for (problem, numerics) in [(&short, energies), (&long, energies), (&long, of_record(1e-6))] {
        let (solution, off) = shown(problem, &numerics);
        assert!(solution.tolerance_met && off <= solution.record_error_estimate.unwrap(), "{off:e}, {solution:?}");
    }
    let methods =
        [(Method::Linexp, 16), (Method::Taylor, 6), (Method::Rk4Events, 64), (Method::Midpoint, 64), (Method::Rk4, 200)];
    for (method, steps) in methods {
        let numerics = Numerics { method, steps_per_period: Some(steps), ..of_record(1e-6) };
        let (solution, off) = shown(&short, &numerics);
        let estimate = solution.record_error_estimate.unwrap();
        assert_eq!(solution.steps_per_period, Some(steps));
        // Two runs of order two: the finer one still has a quarter of the error.
        assert!(off <= 1.5 * estimate && estimate < 100.0 * off.max(1e-13), "{method:?}: {off:e}, {solution:?}");
        assert_eq!(solution.tolerance_met, estimate <= 1e-6, "{solution:?}");
    }
}

#[test]
fn coulomb_friction_has_a_record_too() {
    let problem = with(|problem| problem.law = Law::Coulomb);
    let (solution, off) = shown(&problem, &of_record(1e-8));
    assert!(solution.tolerance_met && off <= solution.record_error_estimate.unwrap(), "{off:e}, {solution:?}");
    // Rigid bristles are solved as Coulomb friction: after a reversal friction has the opposite
    // sign for a moment.
    let rigid = with(|problem| problem.coulomb_n *= 1e-60);
    let solution = solve(&rigid, &of_record(1e-3), &mut |_| ()).unwrap();
    assert!(!solution.tolerance_met && solution.record_error_estimate.unwrap() >= 1.0, "{solution:?}");
    assert!(solution.warnings.iter().any(|warning| warning.contains("not met")), "{solution:?}");
}

/// Mass near its resonance, held by damped bristles. Its error grows from round-off by a factor of
/// ten every few periods.
#[test]
fn a_diverging_record_is_reported() {
    let problem = with(|problem| {
        let hz = problem.waveform.frequency_hz();
        problem.motion = Motion::Sdof { mass_kg: 0.02, stiffness_n_per_m: 2.184_002_8e9, damping_n_s_per_m: 0.0 };
        problem.law = Law::Lugre {
            stiffness_n_per_m: 121_223.84,
            static_ratio: 2.085,
            stribeck_m_per_s: 0.193_66,
            sigma1: 45_203.5,
            sigma2: 0.0,
        };
        (problem.coulomb_n, problem.sliding_m_per_s) = (2.296_3e-3, 0.017_105);
        problem.duration_s = 60.0 / hz;
        problem.window_s = (0.0, problem.duration_s);
    });
    let solution = solve(&problem, &of_record(1e-9), &mut |_| ()).unwrap();
    assert!(!solution.tolerance_met && solution.record_error_estimate.unwrap() > 1e-9, "{solution:?}");
    assert!(solution.warnings[0].contains("record"), "{solution:?}");
}

#[test]
fn a_closed_form_has_no_record() {
    let kinematic = with(|problem| {
        let hz = problem.waveform.frequency_hz();
        problem.waveform = Waveform::new(Shape::Sine, problem.vibration_m_per_s(), hz, problem.duration_s);
        problem.motion = Motion::Kinematic;
    });
    let (solution, off) = shown(&kinematic, &of_record(1e-7));
    assert!(solution.method == Method::Taylor && off <= solution.record_error_estimate.unwrap(), "{off:e}, {solution:?}");
    assert!(closed_form(&kinematic, &of_record(1e-7)).is_none());
    let closed = Numerics { method: Method::Closed, ..of_record(1e-7) };
    assert!(matches!(solve(&kinematic, &closed, &mut |_| ()), Err(SolveError::Unsuited { .. })));
}

/// Each of many problems has its own record.
#[test]
fn many_are_solved_as_single_problems() {
    let problems = contacts();
    let many = solve_many(&problems, &of_record(1e-6), &|| ());
    for (problem, solution) in problems.iter().zip(many) {
        assert_eq!(solution.unwrap(), solve_unwatched(problem, &of_record(1e-6), &|| ()).unwrap());
    }
}
