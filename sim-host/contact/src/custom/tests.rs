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
        assert!(residual.abs() < 1e-8 * own.ratios.input.unwrap().abs().max(1.0), "{residual:e} {problem:?}");
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

/// A law without states, whose force is far sharper than the motion, against the trapezoidal rule,
/// which is exact to round-off for a smooth periodic function.
#[test]
fn a_sharp_force_without_states_is_resolved() {
    let (problem, numerics) = problems().remove(1);
    let speed = problem.waveform.amplitude();
    for sharpness in [1e-1, 1e-2, 1e-3] {
        let parameters = [("vs", sharpness * speed)];
        let own = solve_own(&problem, &source(&[], "Fc*tanh(v/vs)", &parameters), &numerics);
        let turns = 1_000_000;
        let slip =
            |turn: i32| problem.sliding_m_per_s + speed * (std::f64::consts::TAU * f64::from(turn) / f64::from(turns)).cos();
        let exact = (0..turns).map(|turn| (slip(turn) / (sharpness * speed)).tanh()).sum::<f64>() / f64::from(turns);
        let off = (own.ratios.friction - exact).abs();
        assert!(off <= own.error_estimate.unwrap() + 1e-12 && own.tolerance_met, "{sharpness}: {off:e} {own:?}");
    }
}

/// Stribeck terms that are narrow in a period: without a state, and in LuGre's law.
#[test]
fn narrow_terms_are_resolved() {
    let (mut problem, numerics) = problems().remove(1);
    problem.sliding_m_per_s = 0.3 * problem.waveform.amplitude();
    for tolerance in [1e-3, 1e-7] {
        let numerics = Numerics { tolerance, ..numerics };
        let text = "Fc*sign(v)*(1 + 0.5*exp(-(v/vs)^2))";
        let own = solve_own(&problem, &source(&[], text, &[("vs", 0.01)]), &numerics);
        let slip = |turn: f64| problem.sliding_m_per_s + problem.waveform.amplitude() * (std::f64::consts::TAU * turn).cos();
        let zero = (-0.3f64).acos() / std::f64::consts::TAU;
        let mean = |from: f64, to: f64| {
            let force = |turn: f64| slip(turn).signum() * (1.0 + 0.5 * (-(slip(turn) / 0.01).powi(2)).exp());
            let count = 1_000_000;
            let middle = |k: i32| from + (to - from) * (f64::from(k) + 0.5) / f64::from(count);
            (0..count).map(|k| force(middle(k))).sum::<f64>() * (to - from) / f64::from(count)
        };
        let exact = mean(0.0, zero) + mean(zero, 1.0 - zero) + mean(1.0 - zero, 1.0);
        let off = (own.ratios.friction - exact).abs();
        assert!(off <= own.error_estimate.unwrap() + 1e-9 && own.tolerance_met, "{tolerance:e}: {off:e} {own:?}");
        let parameters = [("k", 0.056e6), ("vs", 1e-4)];
        let text = "v - k*abs(v)*z/(Fc*(1 + 0.4*exp(-(v/vs)^2)))";
        let lugre = source(&[("z", text)], "k*z + 0.02*dz + 0.05*v", &parameters);
        let law =
            Law::Lugre { stiffness_n_per_m: 0.056e6, static_ratio: 1.4, stribeck_m_per_s: 1e-4, sigma1: 0.02, sigma2: 0.05 };
        let own = solve_own(&problem, &lugre, &numerics);
        let exact = solve_unwatched(&Problem { law, ..problem.clone() }, &Numerics { tolerance: 1e-11, ..numerics }, &|| ());
        let exact = exact.unwrap();
        let off = (own.ratios.friction - exact.ratios.friction).abs();
        let stated = own.error_estimate.unwrap() + exact.error_estimate.unwrap();
        assert!(off <= stated && own.tolerance_met, "{tolerance:e}: {off:e} {stated:e} {own:?}");
    }
}

/// A switch for a hundredth of a period: `v` below `-c` between two turns.
#[test]
fn a_short_switch_is_found() {
    let (mut problem, numerics) = problems().remove(1);
    problem.sliding_m_per_s = 0.0;
    let amplitude = problem.waveform.amplitude();
    let limit = amplitude * (std::f64::consts::PI * 0.01).cos();
    let own = solve_own(&problem, &source(&[], "Fc*(2 + sign(-v - c))", &[("c", limit)]), &numerics);
    // 3 Fc for a hundredth of the time, Fc otherwise
    assert!((own.ratios.friction - 1.02).abs() < 1e-9, "{own:?}");
}

/// Roots and powers of the slip's absolute value have no derivative at a reversal.
#[test]
fn roots_of_the_slip_are_allowed() {
    for (problem, numerics) in problems() {
        for force in
            ["Fc*sign(v) + abs(v)^1.5", "f*(1 + 0.3*exp(-(abs(v)/0.02)^0.5))", "f + 0.1*cbrt(v)*abs(v)", "f*sqrt(1 + abs(v))"]
        {
            let law = source(&[("f", "k*v*(1 - f/Fc*sign(v))")], force, &[("k", 0.056e6)]);
            let numerics = Numerics { tolerance: 1e-5, ..numerics };
            let own = solve(&problem, &Expression::new(&law).unwrap(), &numerics, (&|| (), None), None);
            let sticks = force.starts_with("Fc") && problem.motion != Motion::Kinematic;
            assert!(own.as_ref().is_ok_and(|own| own.tolerance_met) || sticks, "{force}: {own:?} {problem:?}");
        }
    }
}

/// Maxwell-slip elements that all turn at once.
#[test]
fn many_elements_turn_at_once() {
    let (problem, numerics) = problems().remove(0);
    let names: Vec<String> = (0..20).map(|k| format!("f{k}")).collect();
    let mut law = source(&[], &names.join("+"), &[("k", 5e5)]);
    for name in &names {
        let limit = "Fc/20";
        law.rates.insert(name.clone(), format!("k*v*(1 - on_{name})/20"));
        law.relays.insert(format!("on_{name}"), (format!("{name}*sign(v) - {limit}"), format!("-v*{name}")));
    }
    let many = solve_own(&problem, &law, &numerics);
    let mut one = source(&[("f", "k*v*(1 - slips)")], "f", &[("k", 5e5)]);
    one.relays.insert("slips".to_owned(), ("f*sign(v) - Fc".to_owned(), "-v*f".to_owned()));
    let one = solve_own(&problem, &one, &numerics);
    assert!((many.ratios.friction - one.ratios.friction).abs() < 1e-8, "{} {}", many.ratios.friction, one.ratios.friction);
}

#[test]
fn a_long_sum_is_no_burden() {
    let (problem, numerics) = problems().remove(1);
    let terms: Vec<String> = (1..=2000).map(|k| format!("{k}e-9*Fc*v")).collect();
    let small = std::thread::Builder::new().stack_size(256 << 10);
    let law = move || solve_own(&problem, &source(&[], &format!("Fc + {}", terms.join(" + ")), &[]), &numerics);
    assert!(small.spawn(law).unwrap().join().unwrap().ratios.friction > 1.0);
}

#[test]
fn a_law_that_is_not_a_number_is_an_error() {
    let (problem, numerics) = problems().remove(1);
    for force in ["1/0", "ln(-1)", "sqrt(v)", "exp(1e6*v)", "Fc*sign(ln(v))"] {
        let law = Expression::new(&source(&[], force, &[])).unwrap();
        let error = solve(&problem, &law, &numerics, (&|| (), None), None).unwrap_err();
        assert!(error.to_string().contains("not a finite number") || error.to_string().contains("diverged"), "{force}: {error}");
    }
}

#[test]
fn relays_that_contradict_are_named() {
    let (problem, numerics) = problems().remove(1);
    let mut law = source(&[], "Fc*a", &[]);
    law.relays.insert("a".to_owned(), ("1".to_owned(), "1".to_owned()));
    let error = solve(&problem, &Expression::new(&law).unwrap(), &numerics, (&|| (), None), None).unwrap_err();
    assert!(error.to_string().contains("above zero at once"), "{error}");
}

#[test]
fn an_observer_changes_nothing() {
    for (problem, numerics) in problems() {
        let law = Expression::new(&lugre().0).unwrap();
        let run = |watch: Option<&mut dyn FnMut(&State)>| solve(&problem, &law, &numerics, (&|| (), None), watch).unwrap();
        assert_eq!(run(None), run(Some(&mut |_| ())));
    }
}

#[test]
fn friction_at_rest_has_no_direction() {
    let (mut problem, numerics) = problems().remove(1);
    problem.waveform = Waveform::new(Shape::Still, 0.0, problem.waveform.frequency_hz(), problem.duration_s);
    problem.sliding_m_per_s = 0.0;
    assert_eq!(solve_own(&problem, &source(&[], "Fc*sign(v)", &[]), &numerics).ratios.friction, 0.0);
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
            let stated = own.error_estimate.unwrap() + tight.error_estimate.unwrap();
            assert!(off <= stated && own.tolerance_met, "{tolerance:e}: {off:e} {own:?}");
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
        let parameters: &[(&str, f64)] = if text.contains("expo") { &[("e1", 2.0), ("E0", 3.0), ("expo", 5.0)] } else { &[] };
        let source = source(&[], text, parameters);
        let own = solve_own(&problems().remove(1).0, &source, &Numerics::default());
        let force = own.ratios.friction * problems().remove(1).0.coulomb_n;
        assert!((force - expected).abs() < 1e-12 * expected.abs().max(1.0), "{text}: {force}");
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
    says(source(&[("z", "v")], "z*dz", &[("dz", 1.0)]), "parameter.dz", "two things");
    says(source(&[("z", "v")], "z", &[("exp", 1.0)]), "parameter.exp", "already means");
    says(source(&[("z", "v")], "z", &[("1k", 1.0)]), "parameter.1k", "not a name");
    says(source(&[], "v", &[("k", 1.0)]), "parameter.k", "not used");
    says(source(&[], "exp 2", &[]), "force", "write `exp(…)`");
    says(source(&[], "1e-400*v", &[]), "force", "is not a number");
    let nested = format!("{}v{}", "(".repeat(100), ")".repeat(100));
    says(source(&[], &nested, &[]), "force", "levels");
    let mut law = source(&[("z", "v")], "z", &[]);
    law.start.insert("y".into(), 1.0);
    says(law, "start.y", "no rate");
}
