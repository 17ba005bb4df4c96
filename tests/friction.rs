//! Friction through the whole chain, compared with numbers from other sources.

use scene::load::load;
use sim::instruments::measure;
use sim::metrics::Metrics;
use sim::run::{Watch, run};

/// Runs a scene with these changes.
fn measured(name: &str, short: [&str; 3], changes: &[&str]) -> Metrics {
    let sets: Vec<String> = short.iter().chain(changes).map(|&set| set.to_owned()).collect();
    let scene = load(name, &sets).unwrap_or_else(|error| panic!("{error}")).scene;
    let scene = scene.driven().unwrap();
    measure(&scene, &run(&scene, Watch::default()).unwrap())
}

fn experiment(changes: &[&str]) -> Metrics {
    measured("experiment-1", ["duration_s=0.7", "controller.burst.on_s=[0.4]", "controller.burst.off_s=[0.6]"], changes)
}

/// The reference is a separate study of the coupled equations (ideal source of 3 V, no weight
/// except the load, relocked by the motional phase). Columns: contact stiffness, load, reduction in
/// per cent, amplitude relative to that of the free stack.
#[test]
fn coupled_slider_agrees_with_a_separate_study() {
    for (stiffness, load, reduction, amplitude) in [
        (3e6, 0.5, 85.5, 1.0),
        (1.2e7, 2.0, 85.0, 0.96),
        (6e7, 10.0, 81.9, 0.80),
        (6e6, 10.0, 74.2, 0.93),
        (2e6, 5.0, 72.0, 0.985),
        (2e6, 10.0, 68.2, 0.99),
    ] {
        let metrics = experiment(&[
            "controller.drive.amplitude_v=3.0",
            "amplifier.source_ohm=0.001",
            "rig.slider.self_weight_n=0",
            &format!("rig.slider.load_n={load}"),
            &format!("contact.dahl.stiffness_n_per_m={stiffness}"),
        ]);
        let (got, tip) = (metrics.get("reduction_percent").unwrap(), metrics.get("tip_velocity_m_per_s").unwrap());
        assert!((got - reduction).abs() < 0.3, "Kt {stiffness}, {load} N: {got} % instead of {reduction} %");
        assert!((tip / 0.175 - amplitude).abs() < 0.02, "Kt {stiffness}, {load} N: tip velocity {tip} m/s");
    }
}

/// If the contact hardly loads the stack, the chain must agree with the closed form of steady
/// kinematic Dahl friction.
#[test]
fn light_contact_tends_to_the_closed_form() {
    let metrics = experiment(&["rig.slider.self_weight_n=0.48"]);
    let tip = metrics.get("tip_velocity_m_per_s").unwrap();
    let omega = std::f64::consts::TAU * 40e3;
    let (xi, kappa) = (0.038 / tip, 0.056e6 * tip / (omega * 0.3 * 0.48));
    let ratio = steady_dahl_ratio(xi, kappa);
    let got = metrics.get("friction_ratio").unwrap();
    assert!((got - ratio).abs() < 5e-4, "{got} instead of {ratio}");
}

/// Returns the time mean of `F / Fc` for `V = Vt + Vv cos(omega t)`, `xi = Vt / Vv < 1`,
/// `kappa = Kt Vv / (omega Fc)`: friction at both reversals in closed form, and the mean between
/// them by Simpson's rule.
fn steady_dahl_ratio(xi: f64, kappa: f64) -> f64 {
    let ta = std::f64::consts::PI - xi.acos();
    let forward = 2.0 * (xi * ta + ta.sin());
    let backward = forward - std::f64::consts::TAU * xi;
    let (a, b) = ((-kappa * forward).exp(), (-kappa * backward).exp());
    let f0 = -1.0 + 2.0 * b * (1.0 - a) / (1.0 - a * b);
    let f1 = (1.0 - 2.0 * a + a * b) / (1.0 - a * b);
    let slip = |t: f64, from: f64| (xi * (t - from) + t.sin() - from.sin()).abs();
    let simpson = |from: f64, to: f64, f: &dyn Fn(f64) -> f64| {
        let n = 2000;
        let h = (to - from) / f64::from(n);
        let weight = |k: i32| {
            if k == 0 || k == n {
                1.0
            } else if k % 2 == 1 {
                4.0
            } else {
                2.0
            }
        };
        (0..=n).map(|k| weight(k) * f(from + f64::from(k) * h)).sum::<f64>() * h / 3.0
    };
    let rising = simpson(-ta, ta, &|t| 1.0 + (f0 - 1.0) * (-kappa * slip(t, -ta)).exp());
    let falling = simpson(ta, std::f64::consts::TAU - ta, &|t| -1.0 + (f1 + 1.0) * (-kappa * slip(t, ta)).exp());
    (rising + falling) / std::f64::consts::TAU
}

#[test]
fn reduction_never_rises_with_load_or_speed() {
    let reduction = |load: f64, speed: f64| {
        let (load, speed) = (format!("rig.slider.load_n={load}"), format!("rig.slider.speed_m_per_s={speed}"));
        experiment(&[&load, &speed]).get("reduction_percent").unwrap()
    };
    for speed in [0.038, 0.068] {
        let over_load = [0.0, 1.0, 2.0, 5.0, 10.0].map(|load| reduction(load, speed));
        assert!(over_load.windows(2).all(|pair| pair[1] <= pair[0] + 0.02), "{speed} m/s: {over_load:?}");
    }
    assert!(reduction(0.0, 0.068) < reduction(0.0, 0.038) - 15.0);
}

/// If the slider is faster than the tip, there is no reversal. Coulomb friction would not fall at
/// all; Dahl friction falls slightly.
#[test]
fn a_slider_faster_than_the_tip_keeps_its_friction() {
    let metrics = experiment(&["rig.slider.speed_m_per_s=0.4"]);
    assert!(metrics.get("velocity_ratio").unwrap() > 2.0);
    assert!(metrics.get("reduction_percent").unwrap().abs() < 0.5, "{metrics:?}");
}

#[test]
fn energy_is_conserved_at_every_load() {
    for load in [0, 10] {
        for stiffness in ["0.056e6", "2e6", "6e7"] {
            let changes = [format!("rig.slider.load_n={load}"), format!("contact.dahl.stiffness_n_per_m={stiffness}")];
            let residual = experiment(&[&changes[0], &changes[1]]).get("energy_residual").unwrap();
            assert!(residual.abs() < 3e-4, "{changes:?}: {residual}");
        }
    }
}

/// Eight times finer steps than the stiffness requires change the reduction by less than 0.01
/// percentage points.
#[test]
fn steps_are_fine_enough() {
    for (stiffness, load, finer) in [("0.056e6", "0", 200), ("2e6", "10", 256), ("6e7", "10", 512)] {
        let contact = [format!("contact.dahl.stiffness_n_per_m={stiffness}"), format!("rig.slider.load_n={load}")];
        let steps = format!("integrator.steps_per_period={finer}");
        let usual = experiment(&[&contact[0], &contact[1]]).get("reduction_percent").unwrap();
        let fine = experiment(&[&contact[0], &contact[1], &steps]).get("reduction_percent").unwrap();
        assert!((usual - fine).abs() < 0.01, "Kt {stiffness}, {load} N: {usual} % and {fine} %");
    }
}

#[test]
fn the_load_cell_keeps_the_mean_and_hides_the_edge() {
    let metrics = experiment(&[]);
    let (cell, truth) = (metrics.get("load_cell_reduction_percent").unwrap(), metrics.get("reduction_percent").unwrap());
    assert!((cell - truth).abs() < 0.05, "{cell} {truth}");
    // The rise to 95 % takes three time constants; with the load cell it takes six milliseconds.
    assert!(metrics.get("rise_time_ms").unwrap() < 1.6);
}

/// Bursts too short for a settled silence: their reduction refers to the friction before the first.
fn bursts(changes: &[&str]) -> Metrics {
    measured("least-power", ["duration_s=0.4", "controller.burst.period_s=1e-3", "controller.burst.duty=0.5"], changes)
}

#[test]
fn a_reduction_has_the_friction_of_its_own_load_as_reference() {
    let reference = bursts(&[]).get("mean_reduction_percent").expect("a reduction");
    let backwards = bursts(&["rig.slider.speed_m_per_s=-0.038"]).get("mean_reduction_percent").expect("a reduction");
    assert!((backwards - reference).abs() < 0.5, "{backwards} % backwards, {reference} % forwards");
    for key in ["rig.slider.load_n", "rig.slider.speed_m_per_s"] {
        let changed = bursts(&[&format!("disturbance=[{{ at_s = 0.3, key = \"{key}\", to = 0.05 }}]")]);
        assert_eq!(changed.get("mean_reduction_percent"), None, "{key}: nothing shows the friction without vibration");
        assert!(changed.get("mean_friction_n").is_some_and(|friction| friction > 0.0), "{key}");
    }
}

/// Rows after a fault have no drive: their friction is whole, and their power zero.
#[test]
fn averages_end_at_a_fault() {
    let whole = bursts(&[]);
    let ended = bursts(&["fault=[{ at_s = 0.3, kind = \"overtemperature\" }]"]);
    assert!(ended.get("fault_code").is_some_and(|code| code > 0.0), "no fault");
    for name in ["mean_power_w", "mean_friction_n"] {
        let [whole, ended] = [&whole, &ended].map(|metrics| metrics.get(name).expect(name));
        assert!((ended / whole - 1.0).abs() < 0.02, "{name}: {ended} up to the fault, {whole} without one");
    }
}
