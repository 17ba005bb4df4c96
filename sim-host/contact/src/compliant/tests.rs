//! Comparison of the arcs with fifty-digit values, with time steps, and with every limit.
#![expect(clippy::excessive_precision, reason = "values as printed by 50-digit arithmetic")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::stepped;
use super::{CompliantProblem, CompliantSolution, Press, friction_ratio, period, popov_ratio, solve};
use crate::SolveError;

/// Returns a contact of 10 N, with its amplitude in indentations and its speed over the critical
/// one.
fn contact(indentations: f64, speed: f64, load_is_held: bool) -> CompliantProblem {
    let (mu, normal_n, normal_n_per_m, tangential_n_per_m, frequency_hz) = (0.3, 10.0, 1e7, 8e6, 20e3);
    let amplitude_m = indentations * normal_n / normal_n_per_m;
    let press = if load_is_held { Press::Load(normal_n) } else { Press::Indentation(normal_n / normal_n_per_m) };
    let sliding_m_per_s = speed * mu * normal_n_per_m * TAU * frequency_hz * amplitude_m / tangential_n_per_m;
    CompliantProblem { mu, press, normal_n_per_m, tangential_n_per_m, amplitude_m, frequency_hz, sliding_m_per_s }
}

fn solved(problem: &CompliantProblem) -> CompliantSolution {
    solve(problem).unwrap_or_else(|error| panic!("{error}"))
}

fn reason(problem: &CompliantProblem) -> String {
    match solve(problem) {
        Err(SolveError::Unsuited { reason, .. }) => reason,
        other => panic!("{other:?}"),
    }
}

/// Amplitude in indentations, speed, `true` if the load is held, friction ratio, and fraction of
/// the period that sticks. Computed from the model's equations in fifty digits (mpmath), with
/// bisection for every root and the cancelling form of the loss, `1 - loss / mean`.
const FIFTY_DIGITS: &[(f64, f64, bool, f64, f64)] = &[
    (0.5, 0.4, false, 0.850_557_462_685_483_9, 0.589_117_125_050_979),
    (1.0, 1e-6, true, 3.139_229_881_047_187_9e-6, 0.999_435_810_121_376),
    (1.0, 0.5, false, 0.798_547_796_666_331_3, 0.524_129_558_415_464_6),
    (3.0, 0.6, false, 1.265_009_661_841_160_8, 0.344_972_822_852_052_5),
    (3.0, 0.6, true, 0.865_142_717_066_484_8, 0.271_656_318_295_071_84),
    (3.0, 1e-6, false, 3.485_985_511_839_229e-6, 0.608_172_802_905_185_3),
    (3.0, 1e-6, true, 2.446_346_103_454_543e-6, 0.509_475_341_476_007_5),
    (1e3, 0.1, false, 71.446_167_980_917_48, 0.454_258_779_809_539),
    (1e3, 0.1, true, 0.855_129_192_934_528_8, 0.035_386_985_221_434_684),
    (1e9, 1e-4, false, 78_531.963_243_355_92, 0.499_950_005_316_956),
    (1e9, 1e-4, true, 0.135_407_266_381_637_26, 0.000_640_537_297_130_152_9),
    (1.000_000_000_001, 0.3, false, 0.579_358_147_400_328_5, 0.655_931_128_643_844_1),
    (1.000_000_000_001, 0.3, true, 0.579_358_147_400_328_5, 0.655_931_128_643_844_1),
    (0.9, 0.999_999, false, 0.999_999_999_999_355_4, 0.000_675_237_338_413_166_1),
    (1.0, 0.999_999_999_9, true, 1.0, 6.752_372_650_626_473e-6),
];

/// Largest rounding of the 2^18 additions of the reference.
const SUM_ROUND_OFF: f64 = (1 << 18) as f64 * f64::EPSILON;

#[test]
fn agrees_with_fifty_digits() {
    for &(indentations, speed, load_is_held, ratio, stick) in FIFTY_DIGITS {
        let got = friction_ratio(indentations, speed, load_is_held);
        let solution = solved(&contact(indentations, speed, load_is_held));
        let off = (got / ratio - 1.0).abs();
        println!("A {indentations} s {speed} {load_is_held}: {got} off {off:.1e}, stick {}", solution.stick_share);
        assert!(off < 1e-14, "{indentations} {speed} {load_is_held}: {got} {ratio}");
        // The contact's own numbers are already rounded.
        let full = solution.friction_ratio.unwrap();
        assert!((full / ratio - 1.0).abs() < 3e-14 && (full - ratio).abs() < 3.0 * solution.error_estimate, "{full} {ratio}");
        // Near the critical speed the stick share is the root of the distance of the speed from it;
        // the speed is rounded to one part in 1e16.
        let rounded = if speed > 0.99 { 1e-16 / (1.0 - speed) } else { 1e-14 };
        assert!((solution.stick_share / stick - 1.0).abs() < 3.0 * rounded, "{} {stick}", solution.stick_share);
    }
}

/// The reference does not use arcs; its own runs give the uncertainty of its mean.
#[test]
fn agrees_with_steps_of_time() {
    for indentations in [1e-3, 0.3, 0.9, 1.0, 1.0 + 1e-12, 1.2, 3.0, 3.2, 10.0, 1e3] {
        for speed in [1e-6, 0.05, 0.3, 0.6, 0.95, 0.999, 1.0, 1.001, 30.0] {
            for load_is_held in [false, true] {
                let problem = contact(indentations, speed, load_is_held);
                let (got, steps) = (solved(&problem), stepped::solve(&problem, 1 << 17));
                let off = (got.coefficient_ratio - steps.coefficient_ratio).abs();
                let case = format!("A {indentations} s {speed} {load_is_held}: off {off:.1e}, {got:?} {steps:?}");
                assert!(steps.unknown < 1e-6 && off <= steps.unknown + SUM_ROUND_OFF, "{case}");
                assert!((got.stick_share - steps.stick_share).abs() < 1e-3, "{case}");
                assert!((got.friction_n - steps.friction_n).abs() < 1e-5 * problem.mu * got.mean_normal_n, "{case}");
            }
        }
    }
}

/// From a relaxed spring: the period number `settle_periods` is steady, and the preceding ones are
/// not.
#[test]
fn a_run_from_rest_comes_to_the_steady_state() {
    let problem = contact(0.05, 0.2, false);
    let steps = 1 << 16;
    let (limit, loaded_n) = (
        |step: u32| {
            let place = 1e-6 + problem.amplitude_m * (TAU * f64::from(step) / f64::from(steps)).cos();
            problem.mu * problem.normal_n_per_m * place
        },
        problem.tangential_n_per_m * problem.sliding_m_per_s / (problem.frequency_hz * f64::from(steps)),
    );
    let mut force_n: f64 = 0.0;
    let means: Vec<f64> = (0..20)
        .map(|_| {
            let mut sum = 0.0;
            for step in 0..steps {
                force_n = (force_n + loaded_n).min(limit(step + 1));
                sum += force_n;
            }
            sum / f64::from(steps)
        })
        .collect();
    let solution = solved(&problem);
    let settled = solution.settle_periods as usize;
    assert_eq!(settled, 17);
    println!("{means:?}");
    assert!((means[settled] / solution.friction_n - 1.0).abs() < 1e-8, "{} {}", means[settled], solution.friction_n);
    assert!(means[settled - 3] < 0.999 * solution.friction_n);
}

/// The error of the paper's approximation is at most 0.0144 A, and zero at both ends.
#[test]
fn the_closed_form_of_the_paper_is_close() {
    let mut worst = 0.0f64;
    for indentations in [0.1, 0.5, 1.0] {
        for step in 0..=1000 {
            let speed = 1e-3 * f64::from(step);
            let off = friction_ratio(indentations, speed, true) - popov_ratio(indentations, speed).unwrap();
            worst = worst.max(off.abs() / indentations);
        }
        assert!((friction_ratio(indentations, 0.0, true) - popov_ratio(indentations, 0.0).unwrap()).abs() < 1e-15);
    }
    println!("worst {worst}");
    assert!((worst - 0.0144).abs() < 1e-4, "{worst}");
    assert_eq!(popov_ratio(1.0 + 1e-12, 0.5), None);
}

/// Just below the critical speed, the expansion of the arc to fourth order gives the reduction of
/// the friction ratio: `A (9 / (4 pi)) (1 - s)^2`. The paper has the factor `3/4`.
#[test]
fn friction_comes_smoothly_to_the_critical_speed() {
    for short in [1e-3, 1e-5, 1e-7] {
        let loss = 1.0 - friction_ratio(0.7, 1.0 - short, false);
        let law = 0.7 * 9.0 / (4.0 * PI) * short * short;
        assert!((loss - law).abs() < 2.0 * short * law + 1e-15, "{short}: {loss} {law}");
    }
    for beyond in [1.0, 1.0 + 1e-15, 1.0 + 1e-6, 5.0, 1e300, f64::INFINITY] {
        assert_eq!(friction_ratio(0.7, beyond, false), 1.0, "{beyond}");
        assert!((friction_ratio(1.0, beyond, true) - 1.0).abs() < 1e-15);
    }
    let below = solved(&contact(0.7, 1.0 - 1e-15, false));
    assert!((below.friction_ratio.unwrap() - 1.0).abs() < 1e-15 && below.stick_share < 1e-6);
}

#[test]
fn solution_is_continuous_at_contact_loss() {
    for speed in [0.0, 1e-6, 0.3, 0.999_999] {
        for load_is_held in [false, true] {
            let at = |indentations: f64| friction_ratio(indentations, speed, load_is_held);
            let (before, exact, beyond) = (at(1.0 - 1e-12), at(1.0), at(1.0 + 1e-12));
            assert!((before - exact).abs() < 3e-12 && (beyond - exact).abs() < 3e-12, "{speed}: {before} {exact} {beyond}");
        }
    }
    let just = solved(&contact(1.0, 0.3, true));
    assert_eq!((just.contact_share, just.mean_normal_n), (1.0, 10.0));
    assert!(solved(&contact(1.0 + 1e-12, 0.3, true)).contact_share > 1.0 - 1e-6);
}

/// Friction grows with speed, and falls with the amplitude while the load is held.
#[test]
fn the_ratio_is_monotonic() {
    for load_is_held in [false, true] {
        for indentations in [0.2, 1.0, 1.1, 3.0, 3.3, 40.0] {
            let ratios: Vec<f64> = (0..=200).map(|i| friction_ratio(indentations, 0.006 * f64::from(i), load_is_held)).collect();
            assert!(ratios.windows(2).all(|pair| pair[1] >= pair[0]), "{indentations} {load_is_held}");
        }
    }
}

/// Limits of the tangential stiffness: the spring is loaded at once, or never.
#[test]
fn limits_of_the_tangential_stiffness() {
    let with = |tangential_n_per_m: f64| solved(&CompliantProblem { tangential_n_per_m, ..contact(0.5, 0.3, true) });
    assert_eq!(with(1e300).friction_ratio, Some(1.0));
    let soft = with(1e-3);
    assert!((soft.friction_ratio.unwrap() - 0.5).abs() < 1e-4 && soft.stick_share > 0.999, "{soft:?}");
    assert!((with(8e6).critical_m_per_s / with(16e6).critical_m_per_s - 2.0).abs() < 1e-15);
    let bouncing = solved(&CompliantProblem { tangential_n_per_m: 1e-3, ..contact(3.0, 0.3, true) });
    assert!(bouncing.friction_ratio.unwrap() < 1e-8 && bouncing.friction_n > 0.0, "{bouncing:?}");
}

#[test]
fn without_vibration_friction_is_unchanged() {
    for amplitude_m in [0.0, 1e-320] {
        let still = solved(&CompliantProblem { amplitude_m, ..contact(0.5, 0.3, true) });
        assert_eq!((still.friction_ratio, still.friction_n, still.stick_share), (Some(1.0), 3.0, 0.0));
        assert_eq!((still.critical_m_per_s, still.contact_share, still.mean_place_m), (0.0, 1.0, 1e-6));
    }
    assert_eq!(friction_ratio(0.0, 0.3, true), 1.0);
    assert!((friction_ratio(1e-300, 0.3, false) - 1.0).abs() < 1e-15);
    let held = CompliantProblem { sliding_m_per_s: 0.0, ..contact(0.25, 0.0, true) };
    let (held, moving) = (solved(&held), solved(&CompliantProblem { sliding_m_per_s: 1e-12, ..held }));
    assert!((held.friction_ratio.unwrap() - 0.75).abs() < 1e-15 && held.settle_periods.is_infinite(), "{held:?}");
    assert!((moving.friction_ratio.unwrap() - 0.75).abs() < 1e-9);
}

/// With the mean load held, the mean position is a gap above `A = pi`, and the critical speed then
/// falls.
#[test]
fn a_mean_gap_lowers_the_critical_speed() {
    let at = |indentations: f64| solved(&contact(indentations, 0.1, true));
    let unit = |indentations: f64| at(indentations).critical_m_per_s / contact(indentations, 1.0, true).sliding_m_per_s;
    assert!(at(0.999 * PI).mean_place_m > 0.0 && at(1.001 * PI).mean_place_m < 0.0);
    assert!((unit(3.0) - 1.0).abs() < 1e-15 && unit(3.2) < 1.0);
    let far = at(1e3);
    let half = PI * far.contact_share;
    assert!((unit(1e3) - half.sin()).abs() < 1e-12 && half < FRAC_PI_2);
    let ratio = |speed: f64| friction_ratio(1e3, speed * half.sin(), true);
    assert!(ratio(0.999) < 1.0 && (ratio(1.001) - 1.0).abs() < 1e-14, "{} {}", ratio(0.999), ratio(1.001));
    // At a constant gap there is no friction without vibration. With vibration the mean friction is
    // positive.
    let gap = CompliantProblem { press: Press::Indentation(-0.5e-6), ..contact(1.0, 0.2, false) };
    let gap = solved(&gap);
    assert!(gap.friction_ratio.is_none() && gap.friction_n > 0.0 && gap.coefficient_ratio < 1.0, "{gap:?}");
}

/// The returned points have the means of the arcs, and each respects the limits.
#[test]
fn the_period_has_the_means_of_the_solution() {
    for (indentations, speed, load_is_held) in [(0.5, 0.4, true), (3.0, 0.6, true), (3.0, 0.6, false), (50.0, 0.1, true)] {
        let problem = contact(indentations, speed, load_is_held);
        let (solution, points) = (solved(&problem), period(&problem).unwrap());
        let area = |value: fn(&super::CompliantPoint) -> f64| -> f64 {
            points
                .windows(2)
                .map(|pair| 0.5 * (pair[1].phase_turns - pair[0].phase_turns) * (value(&pair[0]) + value(&pair[1])))
                .sum()
        };
        assert!((area(|point| point.friction_n) / solution.friction_n - 1.0).abs() < 1e-3);
        assert!((area(|point| point.normal_n) / solution.mean_normal_n - 1.0).abs() < 1e-3);
        let over = |point: &super::CompliantPoint| point.friction_n - problem.mu * point.normal_n;
        assert!(points.iter().all(|point| point.friction_n >= 0.0 && over(point) < 1e-12 * solution.peak_normal_n));
        let sticks: Vec<_> = points.iter().filter(|point| over(point) < -1e-9).collect();
        let share = sticks.len() as f64 / points.len() as f64;
        assert!((share - solution.stick_share).abs() < 0.02, "{share} {}", solution.stick_share);
        assert_eq!((points[0].phase_turns, points.last().unwrap().phase_turns), (0.0, 1.0));
    }
}

#[test]
fn invalid_values_are_refused_by_name() {
    let with = |change: &dyn Fn(&mut CompliantProblem)| {
        let mut problem = contact(0.5, 0.3, true);
        change(&mut problem);
        reason(&problem)
    };
    assert!(with(&|problem| problem.normal_n_per_m = 0.0).contains("normal stiffness is 0"));
    assert!(with(&|problem| problem.tangential_n_per_m = -1.0).contains("tangential stiffness is -1"));
    assert!(with(&|problem| problem.mu = f64::NAN).contains("coefficient of friction is NaN"));
    assert!(with(&|problem| problem.frequency_hz = 0.0).contains("frequency is 0"));
    assert!(with(&|problem| problem.amplitude_m = -1e-9).contains("amplitude is"));
    assert!(with(&|problem| problem.sliding_m_per_s = -1.0).contains("sliding speed is -1"));
    assert!(with(&|problem| problem.press = Press::Load(0.0)).contains("load must be above zero"));
    assert!(with(&|problem| problem.press = Press::Indentation(-0.5e-6)).contains("never touch"));
    assert!(with(&|problem| problem.press = Press::Indentation(f64::INFINITY)).contains("indentation must be a number"));
}
