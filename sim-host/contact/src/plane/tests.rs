#![expect(clippy::excessive_precision, reason = "values as printed by 40-digit arithmetic")]

use super::*;
use crate::closed;
use crate::problem::Sign;
use crate::table_4_1::table_4_1;
use crate::{State, Waveform, taylor};
use std::f64::consts::TAU;

const HZ: f64 = 60e3;
const VIBRATION: f64 = 0.05;

/// Returns a problem with a given sine of 60 kHz and 50 mm/s over 40 periods, of which the last 20
/// are the window.
fn problem(law: Law, velocity_ratio: f64) -> Problem {
    let duration_s = 40.0 / HZ;
    Problem {
        motion: Motion::Kinematic,
        law,
        coulomb_n: 2.0,
        sliding_m_per_s: velocity_ratio * VIBRATION,
        sign: Sign::Passive,
        waveform: Waveform::new(Shape::Sine, VIBRATION, HZ, duration_s),
        start: State::default(),
        load_steps: Vec::new(),
        window_s: (0.5 * duration_s, duration_s),
        duration_s,
    }
}

/// Returns Dahl's law with the vibration amplitude in bristle lengths.
fn dahl(kappa: f64) -> Law {
    Law::Dahl { stiffness_n_per_m: kappa * TAU * HZ * 2.0 / VIBRATION }
}

fn lugre(kappa: f64, sigma1: f64, stribeck: f64) -> Law {
    let stiffness_n_per_m = kappa * TAU * HZ * 2.0 / VIBRATION;
    Law::Lugre { stiffness_n_per_m, static_ratio: 1.6, stribeck_m_per_s: stribeck * VIBRATION, sigma1, sigma2: 0.3 }
}

fn solved(problem: &Problem, angle_deg: f64) -> PlaneSolution {
    let numerics = Numerics { tolerance: 1e-9, ..Numerics::default() };
    let solved = solve(problem, Direction::from_degrees(angle_deg), &numerics, (&|| (), None), false);
    solved.unwrap_or_else(|error| panic!("{angle_deg}: {error}"))
}

fn ratio(problem: &Problem, angle_deg: f64) -> f64 {
    let solution = solved(problem, angle_deg).solution;
    assert!(solution.tolerance_met, "{:?}", solution.warnings);
    solution.ratios.friction
}

/// Velocity ratio, angle, friction ratio, power ratio, mean square across. Computed with mpmath 1.3
/// in 40 digits: the means of `(z + c cos t) / w`, `w / z` and `(s cos t / w)^2` with
/// `w = sqrt((cos t + z c)^2 + (z s)^2)` over 0 to pi, by quad() between points that approach the
/// smallest w in powers of ten.
const BY_QUADRATURE: [(f64, f64, f64, f64, f64); 22] = [
    (1e-6, 90.0, 9.677_769_587_161_479e-6, 636_619.772_372_579_383, 0.999_999),
    (0.05, 90.0, 0.139_417_046_453_395_144, 12.810_077_266_004_253_4, 0.950_062_383_056_107_766),
    (0.1, 90.0, 0.234_415_654_230_913_207, 6.499_417_362_813_596_96, 0.900_496_280_979_001_086),
    (0.217, 90.0, 0.399_539_923_719_803_968, 3.168_691_793_915_118_23, 0.787_935_518_378_990_025),
    (0.389, 90.0, 0.565_510_367_605_567_122, 1.983_494_123_925_669_7, 0.637_463_791_716_049_692),
    (0.5, 90.0, 0.642_637_681_773_124_473, 1.677_609_971_862_197_75, 0.552_786_404_500_042_061),
    (1.0, 90.0, 0.834_626_841_674_073_186, 1.216_006_723_424_979_78, 0.292_893_218_813_452_476),
    (2.0, 90.0, 0.945_006_330_929_758_054, 1.059_839_380_187_648_28, 0.105_572_809_000_084_121),
    (1e6, 90.0, 0.999_999_999_999_75, 1.000_000_000_000_25, 4.999_999_999_996_25e-13),
    (0.5, 45.0, 0.552_199_933_322_442_889, 1.588_522_993_872_576_94, 0.457_451_476_555_366_372),
    (0.5, 10.0, 0.365_404_742_047_086_804, 1.453_281_356_470_063_54, 0.121_115_047_304_665_177),
    (0.5, 80.0, 0.638_299_132_262_352_428, 1.672_944_710_567_897_56, 0.548_983_796_615_413_694),
    (0.9, 30.0, 0.779_018_109_813_777_269, 1.133_013_323_896_948_84, 0.292_136_539_793_646_207),
    (1.0, 1.0, 0.950_753_599_997_785_203, 1.001_136_764_206_145_38, 0.064_606_643_334_785_994_2),
    (1.0, 45.0, 0.827_941_383_877_727_713, 1.148_642_359_291_950_61, 0.272_455_069_718_886_329),
    (1.2, 5.0, 0.988_799_479_577_587_638, 1.002_971_299_898_463_39, 0.021_802_785_598_907_624_3),
    (0.5, 0.001, 0.333_333_334_863_745_075, 1.435_991_124_867_775_81, 0.000_010_076_967_741_822_542_3),
    (1e-6, 0.001, 6.366_197_772_464_232e-7, 636_619.772_367_899_653, 3.220_707_122_642_107_8e-10),
    (0.5, 1e-6, 0.333_333_333_333_335_766, 1.435_991_124_176_918_51, 1.007_666_343_925_195_32e-8),
    (1e6, 45.0, 0.999_999_999_999_875, 1.000_000_000_000_125, 2.500_000_000_001_875e-13),
    (1e-6, 89.999, 9.677_769_584_504_35e-6, 636_619.772_372_579_383, 0.999_998_999_695_383_342),
    (3.0, 60.0, 0.978_952_587_526_632_49, 1.020_919_099_324_794_84, 0.041_376_135_918_853_086_5),
];

#[test]
fn coulomb_friction_of_a_sine_is_exact_at_any_angle() {
    for (z, angle, friction, power, square) in BY_QUADRATURE {
        let means = coulomb::means(Shape::Sine, z, Direction::from_degrees(angle)).unwrap();
        let got = [means.friction, means.power.unwrap(), means.transverse_square];
        for (got, truth) in got.into_iter().zip([friction, power, square]) {
            assert!((got / truth - 1.0).abs() < 8e-15, "{z} {angle}: {got:e} {truth:e}");
        }
    }
}

/// Law of Littmann, Storck and Wallaschek to four digits, as quoted.
#[test]
fn the_transverse_law_at_some_velocity_ratios() {
    for (z, r) in [(0.05, 0.1394), (0.1, 0.2344), (0.217, 0.3995), (0.389, 0.5655), (0.5, 0.6426), (1.0, 0.8346), (2.0, 0.9450)] {
        assert!((coulomb::friction_ratio(z, 90.0) - r).abs() < 5.1e-5, "{z}");
    }
    assert_eq!(coulomb::friction_ratio(0.3, 0.0), closed::coulomb_friction_ratio(0.3));
    assert_eq!(coulomb::friction_ratio(-0.3, 70.0), -coulomb::friction_ratio(0.3, 70.0));
}

/// Means of every shape from sums over very many moments; a kink or a jump causes only a small
/// error.
#[test]
fn coulomb_friction_of_every_shape_agrees_with_sums() {
    const MANY: u32 = 400_000;
    for shape in [Shape::Sine, Shape::Square, Shape::Triangle, Shape::Sawtooth, Shape::Still] {
        let waveform = Waveform::new(shape, 1.0, 1.0, 1.0);
        for z in [0.03, 0.4, 0.97, 1.6, 2.5, 40.0] {
            for angle in [0.0, 0.5, 20.0, 45.0, 71.0, 90.0] {
                let direction = Direction::from_degrees(angle);
                let (mut friction, mut slip, mut square) = (0.0, 0.0, 0.0);
                for index in 0..MANY {
                    let u = waveform.value((f64::from(index) + 0.5) / f64::from(MANY));
                    let (along, across) = (z + direction.along * u, direction.across * u);
                    let size = along.hypot(across);
                    friction += along / size / f64::from(MANY);
                    slip += size / z / f64::from(MANY);
                    square += (across / size).powi(2) / f64::from(MANY);
                }
                let means = coulomb::means(shape, z, direction).unwrap();
                let off = (means.friction - friction).abs().max((means.transverse_square - square).abs());
                assert!(
                    off < 1e-5 && (means.power.unwrap() / slip - 1.0).abs() < 1e-9,
                    "{shape:?} {z} {angle}: {means:?} {off:e}"
                );
            }
        }
    }
    assert!(coulomb::means(Shape::Random { hold_s: 1.0, seed: 1 }, 0.5, Direction::from_degrees(90.0)).is_none());
}

/// The derivative of |w| with respect to z is the friction along the sliding: `d(z phi)/dz = r`.
#[test]
fn friction_is_the_slope_of_the_slip() {
    for angle in [0.3, 20.0, 50.0, 90.0] {
        for z in [0.2, 0.8, 1.3] {
            let slip = |z: f64| z * coulomb::means(Shape::Sine, z, Direction::from_degrees(angle)).unwrap().power.unwrap();
            let step = 1e-4;
            let (one, two) = (slip(z + step) - slip(z - step), slip(z + 2.0 * step) - slip(z - 2.0 * step));
            let slope = (8.0 * one - two) / (12.0 * step);
            assert!((slope - coulomb::friction_ratio(z, angle)).abs() < 1e-10, "{angle} {z}");
        }
    }
}

#[test]
fn along_the_sliding_it_is_dahl_s_law_in_closed_form() {
    for kappa in [0.3, 0.405, 5.0, 300.0, 1e6, 1e10] {
        for z in [1e-6, 0.05, 0.5, 0.9999, 1.0] {
            let solution = solved(&problem(dahl(kappa), z), 0.0).solution;
            // The window begins after 20 periods.
            let start_left = closed::forget(z, kappa).powi(20);
            assert!(start_left < 1e-9);
            let off = solution.ratios.friction - closed::friction_ratio(z, kappa);
            let power = solution.ratios.power.unwrap() / closed::power_ratio(z, kappa).unwrap() - 1.0;
            assert!(
                off.abs() < 1e-13 + start_left && power.abs() < 1e-12 + 2.0 * start_left / z,
                "{kappa} {z}: {off:e} {power:e}"
            );
            assert!(solution.error_estimate.unwrap() < 1e-11, "{kappa} {z}: {solution:?}");
        }
    }
}

#[test]
fn along_the_sliding_it_is_lugre_s_law_by_the_series() {
    for (kappa, sigma1, stribeck) in [(0.4, 0.0, 0.3), (3.0, 5.0, 0.1), (20.0, 0.5, 2.0)] {
        let problem = problem(lugre(kappa, sigma1, stribeck), 0.35);
        let series = taylor::run_plain(&problem, 12, 28, &mut |_| ()).unwrap();
        let off = ratio(&problem, 0.0) - Ratios::of(&problem, &series).friction;
        assert!(off.abs() < 1e-12, "{kappa} {sigma1}: {off:e}");
    }
}

/// Fourth-order Runge-Kutta, with step boundaries at all given moments.
fn by_runge_kutta(problem: &Problem, angle_deg: f64, steps: u32) -> [f64; 3] {
    let direction = Direction::from_degrees(angle_deg);
    let (mut force, mut sums, mut time_s) = ([problem.start.force_n, 0.0], [0.0; 3], 0.0);
    let mut load = problem.coulomb_n;
    let mut moments: Vec<f64> = (0..=steps).map(|step| problem.duration_s * f64::from(step) / f64::from(steps)).collect();
    moments.extend([problem.window_s.0, problem.window_s.1]);
    moments.extend(problem.load_steps.iter().map(|step| step.0));
    moments.sort_by(f64::total_cmp);
    for end_s in moments {
        let h = end_s - time_s;
        let rate = |at_s: f64, force: [f64; 2]| {
            let u = problem.waveform.value(at_s);
            let slip = [problem.sliding_m_per_s + direction.along * u, direction.across * u];
            let speed = slip[0].hypot(slip[1]);
            let (kt, limit, sigma1, sigma2) = match problem.law {
                Law::Dahl { stiffness_n_per_m } => (stiffness_n_per_m, load, 0.0, 0.0),
                Law::Lugre { stiffness_n_per_m, static_ratio, stribeck_m_per_s, sigma1, sigma2 } => {
                    let stribeck = (-(speed / stribeck_m_per_s).powi(2)).exp();
                    (stiffness_n_per_m, load * (1.0 + (static_ratio - 1.0) * stribeck), sigma1, sigma2)
                }
                Law::Coulomb => unreachable!(),
            };
            let rate = [0, 1].map(|axis| kt * (slip[axis] - speed * force[axis] / limit));
            let friction = [0, 1].map(|axis| force[axis] + sigma1 / kt * rate[axis] + sigma2 * slip[axis]);
            let power = friction[0] * slip[0] + friction[1] * slip[1];
            [rate[0], rate[1], friction[0], power, friction[1] * friction[1]]
        };
        let late = |by: f64, slope: [f64; 5]| [0, 1].map(|axis| force[axis] + by * slope[axis]);
        // At a jump the step ends before it.
        let before = end_s - 1e-9 * h;
        let one = rate(time_s + 1e-9 * h, force);
        let two = rate(time_s + 0.5 * h, late(0.5 * h, one));
        let three = rate(time_s + 0.5 * h, late(0.5 * h, two));
        let four = rate(before, late(h, three));
        let mean: [f64; 5] = std::array::from_fn(|k| (one[k] + 2.0 * two[k] + 2.0 * three[k] + four[k]) / 6.0);
        force = late(h, mean);
        if end_s > problem.window_s.0 + 1e-12 * problem.duration_s && end_s <= problem.window_s.1 {
            for (sum, mean) in sums.iter_mut().zip(&mean[2..]) {
                *sum += h * mean;
            }
        }
        time_s = end_s;
        load = problem.load_steps.iter().rfind(|step| step.0 <= time_s).map_or(problem.coulomb_n, |step| step.1);
    }
    let length_s = problem.window_s.1 - problem.window_s.0;
    [sums[0] / (load * length_s), sums[1] / (load * problem.sliding_m_per_s * length_s), (sums[2] / length_s).sqrt()]
}

#[test]
fn runge_kutta_agrees_at_any_angle_law_and_window() {
    let duration_s = 40.0 / HZ;
    let shapes = [
        Shape::Sine,
        Shape::Triangle,
        Shape::Square,
        Shape::Chirp { start_hz: 0.5 * HZ, stop_hz: 2.0 * HZ, sweep_s: 0.5 * duration_s },
    ];
    for (index, law) in [dahl(0.4), dahl(4.0), lugre(0.4, 3.0, 0.8), lugre(2.0, 0.0, 0.5)].into_iter().enumerate() {
        for (shape, angle) in shapes.into_iter().zip([90.0, 60.0, 35.0, 80.0]) {
            let mut problem = problem(law, 0.4);
            problem.waveform = Waveform::new(shape, VIBRATION, HZ, duration_s);
            problem.start.force_n = -0.7;
            if index % 2 == 1 {
                problem.window_s = (1.25 / HZ, 33.4 / HZ);
                problem.load_steps = vec![(3.1 / HZ, 5.0), (20.0 / HZ, 1.0)];
            }
            let solved = solved(&problem, angle);
            let (ratios, rms) = (solved.solution.ratios, solved.transverse_rms_n);
            let [friction, power, across] = by_runge_kutta(&problem, angle, 160_000);
            let off = (ratios.friction - friction).abs().max((ratios.power.unwrap() - power).abs()).max((rms - across).abs());
            // With a chirp, Runge-Kutta steps across the kink of its frequency.
            assert!(off < 2e-8, "{law:?} {shape:?} {angle}: {off:e}");
        }
    }
}

#[test]
fn stiff_bristles_are_coulomb_friction() {
    for angle in [1.0, 45.0, 90.0] {
        for z in [0.05, 0.5, 1.0, 3.0] {
            let coulomb = coulomb::friction_ratio(z, angle);
            let off = |kappa: f64| (ratio(&problem(dahl(kappa), z), angle) - coulomb).abs();
            let (soft, stiff) = (off(1e6), off(1e9));
            assert!(stiff < 1e-8 && stiff < 0.1 * soft + 1e-14, "{angle} {z}: {soft:e} {stiff:e}");
            // As accurate as rigid bristles, and beyond.
            assert!(off(1e13) < 1e-11, "{angle} {z}: {:e}", off(1e13));
        }
    }
}

/// With soft bristles, friction varies little about a constant force: the net slip over the mean
/// absolute slip.
#[test]
fn soft_bristles_carry_the_net_slip() {
    for angle in [0.0, 30.0, 90.0] {
        let mut problem = problem(dahl(1e-3), 0.5);
        (problem.duration_s, problem.window_s) = (40_000.0 / HZ, (39_000.0 / HZ, 40_000.0 / HZ));
        let slip = coulomb::means(Shape::Sine, 0.5, Direction::from_degrees(angle)).unwrap().power.unwrap();
        assert!((ratio(&problem, angle) - 1.0 / slip).abs() < 1e-5, "{angle}");
    }
}

#[test]
fn hard_cases_are_finite_and_between_their_limits() {
    for law in [dahl(1e-8), dahl(1.0), dahl(1e8), lugre(1.0, 0.0, 1e-6), lugre(1e6, 1.0, 1e-3), lugre(1e-3, 1e3, 1e3)] {
        for z in [1e-6, 1.0, 1e6] {
            for angle in [1e-6, 45.0, 89.999] {
                for mu in [2.0, 2e-12] {
                    let (mut problem, scale) = (problem(law, z), mu / 2.0);
                    problem.coulomb_n *= scale;
                    // The same bristles in units of their length.
                    problem.law = match law {
                        Law::Dahl { stiffness_n_per_m } => Law::Dahl { stiffness_n_per_m: scale * stiffness_n_per_m },
                        Law::Lugre { stiffness_n_per_m, static_ratio, stribeck_m_per_s, sigma1, .. } => Law::Lugre {
                            stiffness_n_per_m: scale * stiffness_n_per_m,
                            static_ratio,
                            stribeck_m_per_s,
                            sigma1: scale * sigma1,
                            sigma2: 0.0,
                        },
                        Law::Coulomb => law,
                    };
                    let solved = solved(&problem, angle);
                    let (friction, rms) = (solved.solution.ratios.friction, solved.transverse_rms_n / problem.coulomb_n);
                    assert!(solved.solution.tolerance_met, "{law:?} {z} {angle}: {:?}", solved.solution);
                    let damped = matches!(law, Law::Lugre { sigma1, .. } if sigma1 > 0.0);
                    assert!(friction.is_finite() && friction > 0.0 && rms.is_finite(), "{law:?} {z} {angle}: {friction} {rms}");
                    assert!(damped || (friction < 1.600_001 && rms < 1.600_001), "{law:?} {z} {angle}: {friction} {rms}");
                }
            }
        }
    }
}

/// Many periods cost no more than one, and have the same result as few.
#[test]
fn a_million_periods_cost_one() {
    let mut long = problem(dahl(2.0), 0.3);
    (long.duration_s, long.window_s) = (1e6 / HZ, (10.0 / HZ, 1e6 / HZ));
    let short = problem(dahl(2.0), 0.3);
    let off = ratio(&long, 75.0) - ratio(&short, 75.0);
    assert!(off.abs() < 1e-13, "{off:e}");
}

#[test]
fn the_last_period_is_that_of_the_means() {
    for (law, angle) in [(Law::Coulomb, 60.0), (dahl(3.0), 60.0), (lugre(1.0, 2.0, 0.5), 90.0)] {
        let problem = problem(law, 0.4);
        let direction = Direction::from_degrees(angle);
        let solved = solve(&problem, direction, &Numerics::default(), (&|| (), None), true).unwrap();
        let period = &solved.last_period;
        assert_eq!(period.len(), 257);
        assert!(
            (period[256].time_s - problem.duration_s).abs() < 1e-15
                && (period[256].time_s - period[0].time_s - 1.0 / HZ).abs() < 1e-15
        );
        let mean = |of: &dyn Fn(&Moment) -> f64| period[1..].iter().map(of).sum::<f64>() / 256.0;
        let friction = mean(&|moment| moment.friction_n[0]) / problem.coulomb_n;
        let across = mean(&|moment| moment.friction_n[1].powi(2)).sqrt();
        assert!((friction - solved.solution.ratios.friction).abs() < 1e-9, "{law:?} {friction}");
        assert!((across - solved.transverse_rms_n).abs() < 1e-9, "{law:?} {across}");
        for moment in period {
            let size = moment.friction_n[0].hypot(moment.friction_n[1]);
            assert!(matches!(law, Law::Lugre { .. }) || size < problem.coulomb_n * (1.0 + 1e-12));
            let shown = VIBRATION / (TAU * HZ) * (TAU * HZ * moment.time_s).sin();
            assert!((moment.displacement_m - shown).abs() < 1e-12 * VIBRATION, "{law:?}");
        }
    }
}

#[test]
fn unsupported_problems_are_refused() {
    let refused = |problem: &Problem, numerics: &Numerics| {
        let refused = solve(problem, Direction::from_degrees(90.0), numerics, (&|| (), None), false);
        refused.expect_err("a refusal").to_string()
    };
    let by = |method: Method| Numerics { method, ..Numerics::default() };
    let mut mass = table_4_1(0.5, 20.0);
    assert!(refused(&mass, &by(Method::Auto)).contains("only a given vibration"));
    mass = problem(dahl(1.0), 0.5);
    assert!(refused(&mass, &by(Method::Linexp)).contains("require collocation"));
    assert!(refused(&mass, &Numerics { tolerance_of: ToleranceOf::Record, ..Numerics::default() }).contains("the mean only"));
    let mut coulomb = problem(Law::Coulomb, 0.5);
    assert!(refused(&coulomb, &by(Method::Collocation)).contains("closed form only"));
    coulomb.window_s.0 *= 1.01;
    assert!(refused(&coulomb, &by(Method::Auto)).contains("not a whole number of periods"));
    let along = crate::solve(&problem(dahl(1.0), 0.5), &by(Method::Collocation), &mut |_| ());
    assert!(along.unwrap_err().to_string().contains("at an angle"));
}
