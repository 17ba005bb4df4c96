//! Built-in laws that are written as expressions give the results of the built-in methods; a law
//! with jumps agrees with its closed form; mistakes in texts are named.

use super::*;
use crate::table_4_1::table_4_1;
use crate::{Law, Motion, Shape, Waveform, solve_unwatched};

fn source(rates: &[(&str, &str)], force: &str, parameters: &[(&str, f64)]) -> Source {
    let texts = |pairs: &[(&str, &str)]| pairs.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect();
    Source {
        mu: 0.1,
        rates: texts(rates),
        force: force.to_owned(),
        parameters: parameters.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
        ..Source::default()
    }
}

fn dahl(stiffness_n_per_m: f64) -> Source {
    source(&[("f", "k*v*(1 - f/Fc*sign(v))")], "f", &[("k", stiffness_n_per_m)])
}

fn lugre() -> (Source, Law) {
    let parameters = [("k", 0.056e6), ("ratio", 1.4), ("vs", 0.02), ("s1", 0.02), ("s2", 0.05)];
    let rate = "v - k*abs(v)*z/(Fc*(1 + (ratio - 1)*exp(-(v/vs)^2)))";
    let law = Law::Lugre { stiffness_n_per_m: 0.056e6, static_ratio: 1.4, stribeck_m_per_s: 0.02, sigma1: 0.02, sigma2: 0.05 };
    (source(&[("z", rate)], "k*z + s1*dz + s2*v", &parameters), law)
}

/// Returns problems of both motions and several waveforms, in a window and in the steady state.
fn problems() -> Vec<(Problem, Numerics)> {
    let mut problems = Vec::new();
    for shape in [Shape::Sine, Shape::Square, Shape::Triangle] {
        for kinematic in [true, false] {
            for steady in [true, false] {
                let mut problem = table_4_1(0.5, 12.0);
                if let Motion::Sdof { mass_kg, stiffness_n_per_m, damping_n_s_per_m } = &mut problem.motion {
                    *damping_n_s_per_m = 0.02 * (*mass_kg * *stiffness_n_per_m).sqrt();
                }
                let peak = if kinematic { problem.vibration_m_per_s() } else { problem.waveform.amplitude() };
                problem.waveform = Waveform::new(shape, peak, problem.waveform.frequency_hz(), problem.duration_s);
                problem.motion = if kinematic { Motion::Kinematic } else { problem.motion };
                problems.push((problem, Numerics { steady, tolerance: 1e-8, ..Numerics::default() }));
            }
        }
    }
    problems
}

fn solve_own(problem: &Problem, source: &Source, numerics: &Numerics) -> Solution {
    let law = Expression::new(source).unwrap();
    solve(problem, &law, numerics, (&|| (), None), None).unwrap_or_else(|error| panic!("{error} {problem:?}"))
}

fn agree(law: Law, source: &Source) {
    for (problem, numerics) in problems() {
        let problem = Problem { law, ..problem };
        let native = solve_unwatched(&problem, &numerics, &|| ()).unwrap();
        let own = solve_own(&problem, source, &numerics);
        let off = (own.ratios.friction - native.ratios.friction).abs();
        let stated = own.error_estimate.unwrap() + native.error_estimate.unwrap();
        assert!(off <= stated + 1e-9 && own.tolerance_met, "{off:e}, stated {stated:e}: {own:?} {problem:?}");
        assert_eq!(own.orbit.is_some(), numerics.steady, "{:?}", own.warnings);
        let residual = own.ratios.energy_residual.unwrap();
        assert!(residual.abs() < 1e-8, "{residual:e} {problem:?}");
        for (own, native) in [(own.ratios.power, native.ratios.power), (own.ratios.input, native.ratios.input)] {
            let (Some(own), Some(native)) = (own, native) else { continue };
            assert!((own - native).abs() < 1e-6 * native.abs().max(1.0), "{own} {native} {problem:?}");
        }
    }
}

#[test]
fn dahl_as_an_expression_is_dahl() {
    for stiffness_n_per_m in [0.056e6, 5e6] {
        agree(Law::Dahl { stiffness_n_per_m }, &dahl(stiffness_n_per_m));
    }
}

#[test]
fn lugre_as_an_expression_is_lugre() {
    let (source, law) = lugre();
    agree(law, &source);
}

/// A given motion with Coulomb's law jumps at each reversal: mean `1 - 2 acos(Vt / Vv) / pi`.
#[test]
fn a_force_that_jumps_is_located() {
    let (mut problem, numerics) = problems().remove(1);
    let speed = problem.waveform.amplitude();
    for ratio in [0.1, 0.5, 0.9] {
        problem.sliding_m_per_s = ratio * speed;
        let own = solve_own(&problem, &source(&[], "Fc*sign(v)", &[]), &numerics);
        let exact = 1.0 - 2.0 * f64::acos(ratio) / std::f64::consts::PI;
        assert!((own.ratios.friction - exact).abs() < 1e-10, "{} {exact}", own.ratios.friction);
    }
}

/// With a mass, the same law sticks, which needs a state.
#[test]
fn a_law_that_chatters_is_refused() {
    let (mut problem, numerics) = problems().remove(3);
    problem.coulomb_n = 1e3;
    problem.sliding_m_per_s = 0.0;
    let law = Expression::new(&source(&[], "Fc*sign(v)", &[])).unwrap();
    let error = solve(&problem, &law, &numerics, (&|| (), None), None).unwrap_err();
    assert!(error.to_string().contains("no internal state holds the contact"), "{error}");
}

#[test]
fn a_force_that_is_not_finite_is_an_error() {
    let (problem, numerics) = problems().remove(1);
    for force in ["1/0", "ln(-1)", "sqrt(v)", "exp(1e6*v)"] {
        let law = Expression::new(&source(&[], force, &[])).unwrap();
        let error = solve(&problem, &law, &numerics, (&|| (), None), None).unwrap_err();
        assert!(error.to_string().contains("diverged"), "{force}: {error}");
    }
}

/// Switches from `max` and `abs` are those of Dahl's law in another notation.
#[test]
fn kinks_are_located() {
    let (problem, numerics) = problems().remove(3);
    let plain = solve_own(&problem, &dahl(0.056e6), &numerics);
    for rate in ["k*(v - max(v, -v)*f/Fc)", "k*(v - abs(2*v)*f/(2*Fc))", "k*(v + min(v, 0-v)*f/Fc)", "k*(v - abs(v)*f/Fc)"] {
        let other = solve_own(&problem, &source(&[("f", rate)], "f", &[("k", 0.056e6)]), &numerics);
        assert!((plain.ratios.friction - other.ratios.friction).abs() < 1e-10, "{rate}");
    }
}

/// A relay that holds a spring while it sticks: an element of the generalised Maxwell-slip model
/// with a constant limit, whose hysteresis loop over one period is known. `k A = 4 limits`: the
/// loop encloses `4 limit (A - limit / k)`.
#[test]
fn a_relay_is_a_stick_slip_element() {
    let (mut problem, numerics) = problems().remove(1);
    problem.sliding_m_per_s = 0.0;
    let omega = std::f64::consts::TAU * problem.waveform.frequency_hz();
    let amplitude_m = problem.waveform.amplitude() / omega;
    let limit_n = problem.coulomb_n;
    let stiffness = 4.0 * limit_n / amplitude_m;
    let mut law = source(&[("f", "k*v*(1 - slips)")], "f", &[("k", stiffness)]);
    law.relays.insert("slips".to_owned(), ("f*sign(v) - Fc".to_owned(), "-v*f".to_owned()));
    let own = Expression::new(&law).unwrap();
    let solution = solve(&problem, &own, &numerics, (&|| (), None), None).unwrap();
    let tally = solution.tally.unwrap();
    let loops = tally.time_s * problem.waveform.frequency_hz();
    let exact = loops * 4.0 * limit_n * (amplitude_m - limit_n / stiffness);
    assert!((tally.totals.friction_work_j / exact - 1.0).abs() < 1e-8, "{} {exact}", tally.totals.friction_work_j);
}

/// The error that is stated covers the distance to a far tighter tolerance.
#[test]
fn stated_errors_cover_the_truth() {
    let (source, _) = lugre();
    for (problem, numerics) in problems() {
        let tight = solve_own(&problem, &source, &Numerics { tolerance: 1e-11, ..numerics });
        for tolerance in [1e-3, 1e-5, 1e-7, 1e-9] {
            let own = solve_own(&problem, &source, &Numerics { tolerance, ..numerics });
            let off = (own.ratios.friction - tight.ratios.friction).abs();
            assert!(off <= own.error_estimate.unwrap() + 1e-12 && own.tolerance_met, "{tolerance:e}: {off:e} {own:?}");
        }
    }
}

#[test]
fn derivatives_equal_differences() {
    let (source, _) = lugre();
    let law = Expression::new(&source).unwrap();
    let value = |z: f64, v: f64| {
        let mut rate = [0.0];
        let at = At { slip_m_per_s: v, sign: v.signum(), coulomb_n: 0.02, states: &[z], switches: &law.switches() };
        let force = law.rates(&at, &mut rate);
        (rate[0], force)
    };
    let (z, v) = (2e-7, -0.013);
    let mut partial = Partial::new(1);
    assert!(law.derivatives(&At { slip_m_per_s: v, sign: -1.0, coulomb_n: 0.02, states: &[z], switches: &[] }, &mut partial));
    let by = |one: (f64, f64), other: (f64, f64), step: f64| ((one.0 - other.0) / step, (one.1 - other.1) / step);
    let of_z = by(value(z + 1e-11, v), value(z - 1e-11, v), 2e-11);
    let of_v = by(value(z, v + 1e-7), value(z, v - 1e-7), 2e-7);
    for (exact, found) in [
        (of_z, (partial.rates_by_states[0], partial.force_by_states[0])),
        (of_v, (partial.rates_by_slip[0], partial.force_by_slip)),
    ] {
        assert!((exact.0 / found.0 - 1.0).abs() < 1e-6 && (exact.1 / found.1 - 1.0).abs() < 1e-6, "{exact:?} {found:?}");
    }
}

/// Priorities are those of mathematics, and numbers have exponents.
#[test]
fn texts_mean_what_they_say() {
    for (text, expected) in [
        ("-2^2", -4.0),
        ("2^-1", 0.5),
        ("2^3^2", 512.0),
        ("8/4/2", 1.0),
        ("8-4-2", 2.0),
        ("1 - -3", 4.0),
        ("2*-3", -6.0),
        ("1.5e-3*2E+3", 3.0),
        (".5 + 1.", 1.5),
        ("exp(-(2)^2) - exp(0-4)", 0.0),
        ("-exp(0)", -1.0),
        ("max(1, 2)*min(3, 4)", 6.0),
        ("abs(-3)*sign(-2)", -3.0),
        ("cos(pi)", -1.0),
        ("ln(exp(1)) + log10(100)", 3.0),
        ("cbrt(-8)", -2.0),
        ("e1*E0 + expo", 11.0),
    ] {
        let source = source(&[], text, &[("e1", 2.0), ("E0", 3.0), ("expo", 5.0)]);
        let own = solve_own(&problems().remove(1).0, &source, &Numerics::default());
        let force = own.ratios.friction * problems().remove(1).0.coulomb_n;
        assert!((force - expected).abs() < 1e-12, "{text}: {force}");
    }
}

#[test]
fn mistakes_are_named() {
    let says = |source: Source, key: &str, words: &str| {
        let error = Expression::new(&source).unwrap_err();
        assert!(error.key == key && error.message.contains(words), "{error:?}, expected {key}: {words}");
    };
    says(source(&[], "", &[]), "force", "it is empty");
    says(source(&[], "q*v", &[]), "force", "`q` is not known; the names here are Fc, N, mu, v");
    says(source(&[], "v*", &[]), "force", "missing at the end");
    says(source(&[], "(v", &[]), "force", "`)` is missing at the end");
    says(source(&[], "v v", &[]), "force", "unexpected `v`");
    says(source(&[], "v)", &[]), "force", "unexpected `)`");
    says(source(&[], "2 v", &[]), "force", "unexpected `v`");
    says(source(&[], "v; v", &[]), "force", "`;` cannot be used");
    says(source(&[], "log(v)", &[]), "force", "`ln` or `log10`");
    says(source(&[], "sgn(v)", &[]), "force", "sign, max, min");
    says(source(&[], "max(v)", &[]), "force", "takes 2 arguments");
    says(source(&[("z", "dz")], "z", &[]), "rate.z", "only in `force`");
    says(source(&[("z", "v")], "z", &[("dz", 1.0)]), "parameter.dz", "two things");
    says(source(&[("z", "v")], "z", &[("exp", 1.0)]), "parameter.exp", "already means");
    says(source(&[("z", "v")], "z", &[("1k", 1.0)]), "parameter.1k", "not a name");
    let nested = format!("{}v{}", "(".repeat(100), ")".repeat(100));
    says(source(&[], &nested, &[]), "force", "levels");
    let mut law = source(&[("z", "v")], "z", &[]);
    law.start.insert("y".into(), 1.0);
    says(law, "start.y", "no rate");
}
