//! Friction logs with known contacts: the import finds the model and its parameters.

use sonoglide_import::friction::{Friction, Log, Model, Options, fit};

/// Returns samples of a run: time, displacement, velocity.
fn run(points: usize, amplitude_m: f64) -> Vec<(f64, f64, f64)> {
    let at = |n: usize| {
        let t = n as f64 / points as f64;
        // Several amplitudes, so that the log contains both presliding and sliding.
        let (a, w) = (amplitude_m * (0.15 + t), std::f64::consts::TAU * 6.0);
        (t, a * (w * t).sin(), a * w * (w * t).cos())
    };
    (0..points).map(at).collect()
}

/// Returns reproducible noise of this size, N.
fn noise(n: usize, size: f64) -> f64 {
    let part = |k: f64| (n as f64 * k + 0.3).sin() * 43_758.545;
    size * 1.7 * ((part(12.989).fract()) + (part(78.233).fract()))
}

fn log_of(samples: &[(f64, f64, f64)], force: &[f64], on: impl Fn(f64) -> bool) -> Friction {
    let line = |((t, x, v), f): (&(f64, f64, f64), &f64)| format!("{t},{x:e},{v:e},{f:e},{}\n", u8::from(on(*t)));
    let lines: String = samples.iter().zip(force).map(line).collect();
    let text = format!("t [s],x [m],v [m/s],F [N],on\n{lines}");
    fit("made", Log::parse(&text, &Options { normal_n: Some(2.0), ..Options::default() }).unwrap()).unwrap()
}

/// Returns the vibration that a scene needs.
fn drive() -> Options {
    Options { frequency_hz: Some(40e3), tip_m_per_s: Some(0.2), ..Options::default() }
}

fn value(found: &Friction, name: &str) -> (f64, f64) {
    let (_, value, sd) = found.chosen().parameters.iter().find(|(own, ..)| own == name).unwrap();
    (*value, sd.unwrap_or(f64::INFINITY))
}

fn dahl(samples: &[(f64, f64, f64)], fc: f64, kt: f64) -> Vec<f64> {
    let mut force = 0.0;
    let slips = std::iter::once(0.0).chain(samples.windows(2).map(|pair| pair[1].1 - pair[0].1));
    let step = |slip: f64| {
        let limit = fc * slip.signum();
        force = limit + (force - limit) * (-kt * slip.abs() / fc).exp();
        force
    };
    slips.map(step).collect()
}

#[test]
fn a_dahl_contact_is_identified_with_its_stiffness() {
    let samples = run(1500, 20e-6);
    // As measured, with the sign of the motion, and with a tare of half the friction.
    for (sign, offset) in [(1.0, 0.0), (-1.0, 0.0), (1.0, 0.3), (-1.0, -0.3)] {
        let measured = |(n, force): (usize, &f64)| sign * (force + offset + noise(n, 0.005));
        let force: Vec<f64> = dahl(&samples, 0.6, 2e5).iter().enumerate().map(measured).collect();
        let found = log_of(&samples, &force, |_| false);
        assert_eq!(found.chosen().model, Model::Dahl, "{:?}", found.models);
        for (name, truth, most) in [("mu", 0.3, 0.006), ("stiffness_n_per_m", 2e5, 4e3), ("offset_n", offset, 0.003)] {
            let (value, sd) = value(&found, name);
            assert!((value - truth).abs() < 3.5 * sd && sd < most, "{sign} {offset} {name}: {value} {sd}");
        }
        let is_named = |text: &str| found.warnings.iter().any(|warning| warning.contains(text));
        assert_eq!((is_named("its sign was turned"), is_named("has an offset of")), (sign < 0.0, offset != 0.0));
        let text = found.scene("made.csv", &drive()).unwrap();
        assert!(scene::load::load_text("contact", &text, &[]).is_ok(), "{text}");
    }
}

/// The deviation of the stiffness covers the error of a rounded displacement, whose fits are too
/// soft.
#[test]
fn a_rounded_displacement_leaves_the_stiffness_within_its_deviation() {
    let samples = run(3000, 20e-6);
    let force: Vec<f64> = dahl(&samples, 0.6, 2e5).iter().enumerate().map(|(n, force)| force + noise(n, 0.005)).collect();
    for step_m in [0.0, 4e-7, 1e-6, 2e-6] {
        let rounded = |x: f64| if step_m == 0.0 { x } else { step_m * (x / step_m).round() };
        let line = |((t, x, _), f): (&(f64, f64, f64), &f64)| format!("{t},{:e},{f:e}\n", rounded(*x));
        let lines: String = samples.iter().zip(&force).map(line).collect();
        let options = Options { normal_n: Some(2.0), ..Options::default() };
        let found = fit("made", Log::parse(format!("t [s],x [m],F [N]\n{lines}"), &options).unwrap()).unwrap();
        let dahl = found.models.iter().find(|fitted| fitted.model == Model::Dahl).unwrap();
        let (_, stiffness, sd) = dahl.parameters.iter().find(|(name, ..)| name == "stiffness_n_per_m").unwrap();
        let sd = sd.unwrap();
        assert!((stiffness - 2e5).abs() < 2.5 * sd && sd < 4e4, "{step_m}: {stiffness} {sd}");
    }
}

#[test]
fn friction_that_falls_with_velocity_is_stribeck() {
    // Each step of the slip is much longer than the presliding.
    let samples = run(800, 0.05);
    let steady = |v: f64| v.signum() * (0.4 + 0.2 * (-(v / 0.3).powi(2)).exp()) + 0.02 * v;
    let force: Vec<f64> = samples.iter().enumerate().map(|(n, (.., v))| steady(*v) + noise(n, 0.004)).collect();
    let found = log_of(&samples, &force, |_| false);
    assert!(matches!(found.chosen().model, Model::Stribeck | Model::Lugre), "{:?}", found.chosen());
    let (mu, sd) = value(&found, "mu");
    assert!((mu - 0.2).abs() < 4.0 * sd + 0.002, "{mu} {sd}");
}

#[test]
fn steady_sliding_is_coulomb() {
    let samples: Vec<_> = (0..600).map(|n| (f64::from(n) * 0.01, f64::from(n) * 1e-3, 0.1)).collect();
    let on = |t: f64| (2.0..4.0).contains(&t);
    let force: Vec<f64> =
        samples.iter().enumerate().map(|(n, (t, ..))| if on(*t) { 0.2 } else { 0.5 } + noise(n, 0.01)).collect();
    let found = log_of(&samples, &force, on);
    assert_eq!(found.chosen().model, Model::Coulomb, "{:?}", found.models);
    // No frequency and no tip velocity are invented.
    assert_eq!(found.scene("made.csv", &Options::default()), Err("`--frequency-hz` and `--tip-m-per-s`".into()));
}

#[test]
fn successively_sliding_springs_fit_the_maxwell_model() {
    let samples = run(1500, 20e-6);
    let mut parts = [(0.0, 1e5, 1e-6), (0.0, 3e4, 8e-6)];
    let slips = std::iter::once(0.0).chain(samples.windows(2).map(|pair| pair[1].1 - pair[0].1));
    let force: Vec<f64> = slips
        .enumerate()
        .map(|(n, slip)| {
            let part = |(at, k, limit): &mut (f64, f64, f64)| {
                *at = (*at + slip).clamp(-*limit, *limit);
                *at * *k
            };
            parts.iter_mut().map(part).sum::<f64>() + noise(n, 0.002)
        })
        .collect();
    let found = log_of(&samples, &force, |_| false);
    let maxwell = found.models.iter().find(|model| model.model == Model::Maxwell).unwrap();
    assert!(maxwell.rms_n < found.chosen().rms_n, "{} {}", maxwell.rms_n, found.chosen().rms_n);
    // A model with a parameter at its bound explains the springs better, but no scene can have it.
    assert!(found.models.iter().any(|model| !model.is_within_bounds && model.rms_n < found.chosen().rms_n));
    let text = found.scene("made.csv", &drive()).unwrap();
    assert!(scene::load::load_text("contact", &text, &[]).is_ok(), "{text}");
}

#[test]
fn many_samples_have_the_contact_of_few_with_the_uncertainty_of_many() {
    // Few strokes over the whole log, and many of which means would show nothing.
    for strokes in [6.0, 3000.0] {
        let [few, many] = [1_500, 300_000].map(|rows| {
            // The slip of a stroke is the same in both logs.
            let (strokes, rows) = (if rows == 1_500 { 6.0 } else { strokes }, rows as f64);
            let x = |n: f64| 20e-6 * (0.15 + n / rows) * (std::f64::consts::TAU * strokes * n / rows).sin();
            let samples: Vec<_> = (0..rows as usize).map(|n| (n as f64, x(n as f64), x(n as f64) - x(n as f64 - 1.0))).collect();
            let force = dahl(&samples, 0.6, 2e5).into_iter().enumerate().map(|(n, force)| force + noise(n, 0.005)).collect();
            let slip_m = std::iter::once(0.0).chain(samples.windows(2).map(|pair| pair[1].1 - pair[0].1)).collect();
            let velocity_m_per_s = samples.iter().map(|(.., v)| *v).collect();
            let on = vec![false; samples.len()];
            let log = Log { slip_m, velocity_m_per_s, force_n: force, normal_n: 2.0, on, ..Log::default() };
            fit("rows", log).unwrap()
        });
        assert_eq!((many.chosen().model, many.chosen().force_n.len()), (Model::Dahl, 300_000), "{:?}", many.models);
        for (name, truth) in [("mu", 0.3), ("stiffness_n_per_m", 2e5)] {
            let ((value_few, sd_few), (value, sd)) = (value(&few, name), value(&many, name));
            assert!((value - truth).abs() < 4.0 * sd && sd < 0.3 * sd_few, "{strokes} {name}: {value} {sd} {sd_few}");
            assert!((value - value_few).abs() < 4.0 * sd_few, "{strokes} {name}: {value} {value_few}");
        }
    }
}
